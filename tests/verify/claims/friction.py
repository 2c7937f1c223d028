"""Eqs. (3) and (4): the falling torque on the bit and what it does."""

from __future__ import annotations

import numpy as np

from tests.plant.programs import PAPER
from tests.plant.theory import slope_of_torque
from tests.verify.claim import Trial, claim
from tests.verify.claims.runs import NOMINAL_WEIGHT, run


@claim("(3), (4), section 2.1")
def falling_torque() -> list[Trial]:
    """The torque on the bit decreases with increasing speed at low speeds"""
    trials: list[Trial] = []
    speeds = np.linspace(0.01, 40.0, 4000)
    for weight in (31649.0, NOMINAL_WEIGHT):
        slopes = np.array([slope_of_torque(PAPER, weight, float(speed)) for speed in speeds])
        falls = slopes < 0.0
        until = float(speeds[falls].max(initial=0.0))
        told = f"it falls up to {until:.1f} rad/s, by {-slopes[0]:.0f} N m s/rad next to rest"
        trials.append(Trial(f"slope of (3) with (4) at {weight:.0f} N", told, bool(falls[speeds <= 1.0].all())))
    return trials


@claim("section 2.1")
def cause_of_stick_slip() -> list[Trial]:
    """The torque that decreases with speed (Stribeck effect) is the cause of stick-slip

    What is needed is that rest holds more than motion does. Where friction is constant there is no stick-slip; where it
    falls so fast that nothing is left of the slope once the bit turns, there is.
    """
    trials: list[Trial] = []
    for coefficient in (0.5, 0.8):
        found = run("stick-slip", plant__mu_cb=coefficient, plant__mu_sb=coefficient)
        trials.append(Trial(f"constant friction, mu_cb = mu_sb = {coefficient}", str(found), not found.sticks))
    found = run("stick-slip", plant__v_f=1e-3)
    trials.append(Trial("no slope beyond some 0.01 rad/s, v_f = 0.001 rad/s", str(found), not found.sticks))
    return trials
