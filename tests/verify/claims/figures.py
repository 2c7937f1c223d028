"""Figs. 2 to 4: stick-slip, and less weight and more speed against it."""

from __future__ import annotations

from tests.verify.claim import Trial, claim
from tests.verify.claims.runs import equilibrium_start, from_the_cycle, run

INERTIAS = (89.0, 311.0)
NOTABLE = 0.5
"""A swing of the torque of this part of its mean is counted as important."""


@claim("Fig. 2, section 3")
def stick_slip() -> list[Trial]:
    """At W = 97347 N and Ω = 10 rad/s the model shows stick-slip oscillations

    Rotation and stick-slip are both stable here; the start decides.
    """
    trials: list[Trial] = []
    for inertia in INERTIAS:
        found = run("stick-slip", plant__I_B=inertia)
        trials.append(Trial(f"from rest, I_B = {inertia:.0f}", str(found), found.sticks))
    for inertia in INERTIAS:
        found = run("stick-slip", plant__I_B=inertia, **equilibrium_start(inertia))
        trials.append(Trial(f"from steady rotation, I_B = {inertia:.0f}", str(found), found.sticks))
    return trials


@claim("Fig. 2, section 3")
def torque_fluctuations() -> list[Trial]:
    """When the phenomenon occurs, important torque fluctuations appear"""
    trials: list[Trial] = []
    for inertia in INERTIAS:
        found = run("stick-slip", plant__I_B=inertia)
        for output, place in (("bit_torque", "on the bit"), ("top_torque", "on the top")):
            mean, swing = found.swing(output)
            told = f"mean {mean / 1e3:.2f} kN m, from least to greatest {swing / 1e3:.2f} kN m"
            trials.append(Trial(f"torque {place}, I_B = {inertia:.0f}", told, swing > NOTABLE * mean))
    return trials


@claim("Fig. 3, section 3")
def less_weight() -> list[Trial]:
    """Decreasing the weight on the bit from 97347 N to 31649 N reduces stick-slip importantly"""
    trials: list[Trial] = []
    for inertia in INERTIAS:
        found = run("lower-wob", plant__I_B=inertia, stop_time=140.0)
        trials.append(Trial(f"from rest, I_B = {inertia:.0f}", str(found), not found.sticks))
        found = from_the_cycle("WOB", 31649.0, inertia)
        trials.append(Trial(f"from the cycle, I_B = {inertia:.0f}", str(found), not found.sticks))
    return trials


@claim("Fig. 4, section 3")
def more_speed() -> list[Trial]:
    """Increasing the speed of the drive from 10 rad/s to 20 rad/s reduces stick-slip importantly"""
    trials: list[Trial] = []
    for inertia in INERTIAS:
        found = run("higher-speed", plant__I_B=inertia, stop_time=140.0)
        trials.append(Trial(f"from rest, I_B = {inertia:.0f}", str(found), not found.sticks))
        found = from_the_cycle("Omega", 20.0, inertia)
        trials.append(Trial(f"from the cycle, I_B = {inertia:.0f}", str(found), not found.sticks))
    return trials


@claim("section 3")
def less_weight_or_more_speed_in_general() -> list[Trial]:
    """To avoid stick-slip, reduce the weight on the bit or increase the speed at the surface

    It has to be enough. Stick-slip ends for certain beyond the [fold](theory.md#bistability) of the cycles; a sudden
    change can end it a little before.
    """
    trials: list[Trial] = []
    for weight in (80e3, 60e3, 50e3, 46e3):
        found = from_the_cycle("WOB", weight)
        trials.append(Trial(f"from the cycle to {weight / 1e3:.0f} kN at 10 rad/s", str(found), not found.sticks))
    for omega in (12.0, 14.0, 16.0, 18.0):
        found = from_the_cycle("Omega", omega)
        trials.append(Trial(f"from the cycle to {omega:.0f} rad/s at 97347 N", str(found), not found.sticks))
    return trials
