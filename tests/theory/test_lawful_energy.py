"""Energy under law (9): against the law itself at given motions, and against the torque it holds."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from models.controllers.laws import DissipativeLaw
from models.theory.lawful_energy import TopMotion, drain, lawful_work, unloaded_speed
from tests.theory.strings import NOMINAL, PAPER

LAW = DissipativeLaw(omega_max=math.inf, top_speed_min=0.0)
SPEEDS = np.concatenate([-np.geomspace(1e-3, 300, 400), np.geomspace(1e-3, 300, 400)])


def friction(string, wob: float, speed: float) -> float:
    """Paper (3) and (4)."""
    mu = string.mu_cb + (string.mu_sb - string.mu_cb) * math.exp(-string.gamma_b / string.v_f * abs(speed))
    return string.c_b * speed + wob * string.R_b * mu * math.copysign(1.0, speed)


def surplus(string, law: DissipativeLaw, wob: float, speed: float, wanted: float, beta: float = 0.0) -> float:
    """Return the torque the drive passes on in uniform rotation, less what holds the string back [N m]."""
    omega = law.command(speed, speed, wanted, 0.0).omega
    return string.c_a * (omega - speed) - friction(string, wob, speed) - beta * string.L * speed


@pytest.mark.parametrize("form", ["printed", "tracking"])
def test_lawful_work_is_that_of_a_drive_that_obeys_at_every_instant(form):
    law = replace(LAW, form=form, c_1=0.4, c_2=1.7, c_b=90.0)

    def top(t: float) -> float:
        return 6.0 + 4.0 * math.sin(3.0 * t)

    def bit(t: float) -> float:
        return 5.0 - 9.0 * math.cos(2.0 * t)

    def over(rate) -> np.ndarray:
        return np.array([quad(rate, 0.3 * i, 0.3 * i + 0.3, epsrel=1e-12)[0] for i in range(8)])

    refs = np.linspace(4.0, 11.0, 8), np.linspace(2e3, 9e3, 8)
    motion = TopMotion(
        duration=np.full(8, 0.3),
        top=over(top),
        bit=over(bit),
        top_square=over(lambda t: top(t) ** 2),
        product=over(lambda t: top(t) * bit(t)),
    )
    expected: list[float] = []
    for i, (r, torque) in enumerate(zip(*refs, strict=True)):

        def rate(t: float, r: float = r, torque: float = torque) -> float:
            return 2000.0 * (law.command(top(t), bit(t), r, torque).omega - top(t)) * top(t)

        expected.append(quad(rate, 0.3 * i, 0.3 * i + 0.3, epsrel=1e-12)[0])
    assert lawful_work(law, 2000.0, motion, *refs) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("c_1", "c_2", "c_b", "beta"), [(0.3, 2.0, 0.03, 0.0), (-1.0, 0.4, 80.0, 0.3), (0.9, 9.0, 0.0, 0.0)]
)
def test_drain_is_the_power_missing_in_uniform_rotation(c_1, c_2, c_b, beta):
    string, law = replace(PAPER, c_b=c_b), replace(LAW, c_1=c_1, c_2=c_2, c_b=c_b)
    for wob in (0.0, NOMINAL):
        missing = [-surplus(string, law, wob, speed, 10.0, beta) * speed for speed in SPEEDS]
        # a difference of terms that grow beyond all bounds near the pole
        assert drain(string, law, wob, 10.0, SPEEDS, beta) == pytest.approx(missing, rel=1e-9, abs=1e-5)


def test_no_rotation_is_an_equilibrium_of_the_printed_law_with_dry_friction():
    """The torque left over never changes sign on either side of rest: no drive by the law holds any speed."""
    random = np.random.default_rng(1)
    for _ in range(40):
        c_b = 10.0 ** random.uniform(-2, 2.5)
        string = replace(PAPER, c_b=c_b)
        law = replace(LAW, c_b=c_b, c_1=1 - 10.0 ** random.uniform(-2, 1), c_2=10.0 ** random.uniform(-2, 1))
        wob, wanted = random.uniform(1e3, 2e5), random.uniform(0.5, 30)
        assert all(surplus(string, law, wob, speed, wanted) * speed < 0 for speed in SPEEDS)
        assert drain(string, law, wob, wanted, SPEEDS).min() > 0


def test_least_drain_at_the_nominal_point_is_what_a_finer_look_finds():
    fine = np.linspace(5.0, 30.0, 25001)
    missing = np.array([-surplus(PAPER, LAW, NOMINAL, speed, 10.0) * speed for speed in fine])
    least = drain(PAPER, LAW, NOMINAL, 10.0, fine)
    assert least.argmin() == missing.argmin()
    assert least.min() == pytest.approx(missing.min(), rel=1e-9)
    assert 1.18e5 < least.min() < 1.19e5


def test_without_dry_friction_one_speed_is_held_and_it_is_not_the_wanted_one():
    speed = unloaded_speed(LAW, 10.0)
    held = minimize_scalar(lambda w: -surplus(PAPER, LAW, 0.0, w, 10.0) * w, bounds=(10.0, 30.0), method="bounded")
    assert held.fun == pytest.approx(0.0, abs=1e-6)
    assert speed == pytest.approx(held.x, abs=1e-5)
    assert drain(PAPER, LAW, 0.0, 10.0, speed) == pytest.approx(0.0, abs=1e-20)
    assert drain(PAPER, LAW, 0.0, 10.0, SPEEDS).min() > 0
    root = math.sqrt(1 - LAW.c_1) - math.sqrt(LAW.c_b / LAW.c_a)
    assert unloaded_speed(replace(LAW, c_2=root**2), 10.0) == pytest.approx(10.0)


def test_nonsense_is_refused():
    with pytest.raises(ValueError, match=r"c_a = 1500\.0 and c_b = 0\.03; expected 2000\.0 and 0\.03"):
        drain(PAPER, replace(LAW, c_a=1500.0), NOMINAL, 10.0, 10.0)
    with pytest.raises(ValueError, match=r"WOB is -1\.0"):
        drain(PAPER, LAW, -1.0, 10.0, 10.0)
    with pytest.raises(ValueError, match=r"expected 1 - c_1 to differ"):
        unloaded_speed(replace(LAW, c_b=0.0, c_1=1.0), 10.0)
