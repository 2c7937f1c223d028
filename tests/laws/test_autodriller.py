"""A driller who holds the weight, and a bit that drills: time constants, limits, and what stick-slip costs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.laws.rig import STEP, WEIGHT, Outcome, run
from tests.plant.drive import Drive

pytestmark = pytest.mark.slow

PACKAGINGS = ("native", "python")
STIFFNESS, DRILLABILITY, THRESHOLD = 5.98e5, 4.85e-9, 5000.0
HOUR = 3600.0


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_open_loop_the_weight_follows_with_its_time_constant(packaging: str) -> None:
    """With the feed held, what is left of a change dies away with 1 / (k a v), 55.6 s at 6.2 rad/s."""
    with Drive("Autodriller", {"WOB_initial": 50000.0, "bit_speed": 9.0, "enabled": False}, packaging) as driller:
        driller.put(bit_speed=6.2)
        weights: list[float] = []
        for k in range(60000):
            driller.go((k + 1) * 0.01)
            weights.append(driller.get("WOB"))
    final = THRESHOLD + (50000.0 - THRESHOLD) * 9.0 / 6.2
    left = final - np.array(weights)
    constant = 100.0 / math.log(left[1000] / left[11000])
    assert constant == pytest.approx(55.6, rel=0.02)
    assert constant == pytest.approx(1.0 / (STIFFNESS * DRILLABILITY * 6.2), rel=1e-4)


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_the_weight_comes_to_what_is_asked_for_and_the_depth_is_the_integral_of_the_rate(packaging: str) -> None:
    depth = 0.0
    with Drive("Autodriller", {"bit_speed": 6.2, "WOB_initial": 20000.0}, packaging) as driller:
        for k in range(12000):
            before = driller.get("rop")
            driller.go((k + 1) * 0.1)
            depth += 0.05 * (before + driller.get("rop"))
        assert driller.get("WOB") == pytest.approx(WEIGHT, rel=1e-3)
        assert driller.get("rop") == pytest.approx(DRILLABILITY * (WEIGHT - THRESHOLD) * 6.2, rel=2e-3)
        assert driller.get("depth") == pytest.approx(depth, rel=1e-9)


@pytest.mark.parametrize("bit_speed", [0.0, -3.0])
def test_a_bit_that_rests_or_turns_back_does_not_drill(bit_speed: float) -> None:
    with Drive("Autodriller", {"bit_speed": bit_speed, "WOB_initial": 90000.0}) as driller:
        for k in range(3000):
            driller.go((k + 1) * 0.1)
        assert driller.get("depth") == driller.get("rop") == 0.0
        assert 0.0 <= driller.get("WOB") <= 3e5


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_limits_hold_and_leave_nothing_wound_up(packaging: str) -> None:
    """Asked for more than it may feed, for an hour or a minute, the driller comes back the same way."""
    returns: list[np.ndarray] = []
    for minutes in (5, 60):
        with Drive("Autodriller", {"feed_max": 0.001, "WOB_initial": 20000.0, "bit_speed": 12.0}, packaging) as driller:
            driller.put(WOB_ref=2e5)
            for k in range(minutes * 60):
                driller.go(float(k + 1))
            assert driller.get("limit_active") == 1
            driller.put(WOB_ref=15000.0)
            back: list[float] = []
            for _ in range(300):
                driller.go(driller.time + 1.0)
                back.append(driller.get("WOB"))
            returns.append(np.array(back))
    assert returns[0] == pytest.approx(returns[1], rel=1e-3)


def test_a_switch_makes_no_bump() -> None:
    with Drive("Autodriller", {"bit_speed": 6.2, "WOB_initial": 60000.0}) as driller:
        weights = [driller.get("WOB")]
        for k in range(4000):
            if k % 1000 == 700:
                driller.put(enabled=bool(k // 1000 % 2))
            driller.go((k + 1) * 0.1)
            weights.append(driller.get("WOB"))
    steps = np.abs(np.diff(weights))
    # the feed goes on from where it was: no step is greater than those which a greatest feed of 20 mm/s could make
    assert np.abs(np.diff(steps)).max() < 0.1 * STIFFNESS * 0.02 * 0.1


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_a_bit_that_has_stalled_is_lifted_off_where_that_is_allowed(packaging: str) -> None:
    """At rest nothing is drilled, so that only the feed takes weight off: all that the string's spring holds."""
    weights: dict[float, float] = {}
    for least in (0.0, -0.02):
        start = {"feed_min": least, "WOB_initial": 2e5, "WOB_ref": 80000.0}
        with Drive("Autodriller", start, packaging) as driller:
            for k in range(6000):
                driller.go((k + 1) * 0.1)
            weights[least] = driller.get("WOB")
    assert weights[0.0] == 2e5
    assert weights[-0.02] == pytest.approx(80000.0, rel=1e-3)


def drilled(speed: float, law: bool) -> tuple[Outcome, float]:
    """Return a run from full cycle with the weight held by a driller, and its mean rate of penetration [m/h]."""
    start = {"WOB_initial": WEIGHT, "bit_speed": 4.0}
    soft = Drive("SoftTorque", {"enabled": False, "speed_ref": speed})
    with Drive("Autodriller", start) as driller, soft:

        def act(plant: Drive, k: int) -> dict[str, float]:
            now = (k + 1) * STEP
            soft.put(top_speed=plant.get("top_speed"), top_torque=plant.get("top_torque"))
            if law and k == 0:
                soft.put(enabled=True)
            soft.go(now)
            driller.put(bit_speed=plant.get("bit_speed"))
            driller.go(now)
            plant.put(Omega=soft.get("Omega"))
            plant.put(WOB=driller.get("WOB"))
            return {"depth": driller.get("depth"), "WOB": driller.get("WOB")}

        outcome = run(speed, 0.0, act, 600.0)
    depth = outcome.columns["depth"]
    return outcome, float(depth[-1] - depth[-30001]) / 300.0 * HOUR


def test_stick_slip_costs_depth_and_soft_torque_brings_it_back() -> None:
    stuck, slow = drilled(8.0, law=False)
    free, fast = drilled(8.0, law=True)
    assert stuck.severity > 1.0
    assert free.severity < 1e-2
    assert slow == pytest.approx(5.87, rel=0.02)
    assert fast == pytest.approx(6.71, rel=0.01)
