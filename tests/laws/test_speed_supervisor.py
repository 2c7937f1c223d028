"""A supervisor of stick-slip: severity as it is defined, decisions when they are due, and what holds them back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.plant.drive import Drive
from tests.plant.fmi import OK, Instance, must

PACKAGINGS = ("native", "python")


def severities(packaging: str, size: float, seconds: float, **parameters: float) -> np.ndarray:
    """Return the severity told of a bit that turns at 6 + 4 sin(2 pi t / 4 s) rad/s, at every step."""
    found: list[float] = []
    with Drive("SpeedSupervisor", {"bit_speed": 6.0, **parameters}, packaging) as supervisor:
        for k in range(round(seconds / size)):
            supervisor.put(bit_speed=6.0 + 4.0 * math.sin(0.5 * math.pi * (k + 1) * size))
            supervisor.go((k + 1) * size)
            found.append(supervisor.get("severity"))
    return np.array(found)


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("size", [0.01, 0.37])
def test_severity_is_the_swing_by_twice_the_mean(size: float, packaging: str) -> None:
    """Four sixths, of a window that holds five whole cycles; in long steps peaks are missed by up to half a step."""
    found = severities(packaging, size, 40.0)
    known = found[math.ceil(20.0 / size) :]
    assert (found[: math.floor(20.0 / size) - 1] == 0.0).all()
    assert known == pytest.approx(4.0 / 6.0, rel=1e-3 if size < 0.1 else 0.1)


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize(("speed", "told"), [(0.0, 5.0), (-3.0, 5.0), (7.0, 0.0)])
def test_a_bit_that_does_not_turn_forward_is_as_severe_as_can_be_told(
    speed: float, told: float, packaging: str
) -> None:
    with Drive("SpeedSupervisor", {"bit_speed": speed}, packaging) as supervisor:
        supervisor.go(19.9)
        assert supervisor.get("severity") == 0.0
        supervisor.go(25.0)
        assert supervisor.get("severity") == told


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_the_speed_is_raised_at_decisions_alone_and_not_beyond_its_limit(packaging: str) -> None:
    start = {"interval": 2.0, "speed_step": 3.0, "speed_max": 18.0, "measured": 0.4}
    speeds: list[float] = []
    with Drive("SpeedSupervisor", start, packaging) as supervisor:
        for k in range(100):
            supervisor.go(0.1 * (k + 1))
            speeds.append(supervisor.get("speed_ref"))
            assert supervisor.get("limit_active") == (k >= 59)
    jumps = np.flatnonzero(np.diff(speeds)) + 1
    assert jumps.tolist() == [19, 39, 59]
    assert np.array(speeds)[jumps].tolist() == [13.0, 16.0, 18.0]


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("held", [{"measured": 0.3}, {"valid": False}, {"enabled": False}])
def test_what_is_not_above_the_threshold_nor_valid_nor_enabled_raises_nothing(
    held: dict[str, float], packaging: str
) -> None:
    with Drive("SpeedSupervisor", {"measured": 0.4, **held}, packaging) as supervisor:
        for k in range(10):
            supervisor.go(30.0 * (k + 1))
            assert supervisor.get("speed_ref") == 10.0
        for name in held:
            supervisor.put(**{name: {"measured": 0.31}.get(name, True)})
        supervisor.go(supervisor.time + 30.0)
        assert supervisor.get("speed_ref") == 11.0


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_it_measures_and_decides_as_early_however_late_it_is(packaging: str) -> None:
    """At 1e6 s times have a last bit of 1e-10 s; what is remembered stays as large as it was."""
    late: list[np.ndarray] = []
    for start in (0.0, 1e6):
        told: list[float] = []
        with Drive("SpeedSupervisor", {"window": 0.4, "interval": 0.1}, packaging, start=start) as supervisor:
            for k in range(400):
                supervisor.put(bit_speed=6.0 + math.sin(1.3 * k), measured=0.1 + 0.5 * (k % 37 < 5))
                supervisor.go(start + 0.01 * (k + 1))
                told += [supervisor.get("severity"), supervisor.get("speed_ref")]
            assert len(supervisor.serialized()) < 8000
        late.append(np.array(told))
    assert late[0] == pytest.approx(late[1], abs=1e-6), "but for rounding in the sizes of steps"


def test_a_start_beyond_the_limit_and_a_step_without_end_are_refused() -> None:
    with Instance("SpeedSupervisor") as supervisor:
        must(supervisor, supervisor.set(speed_initial=21.0))
        assert supervisor.initialize() != OK
        assert "speed_initial is 21; expected at most speed_max, 20" in supervisor.messages[-1].text
    with Drive("SpeedSupervisor", {}) as supervisor:
        assert supervisor.step(0.0, 1e5) != OK
        assert "expected at most 5000 s" in supervisor.messages[-1].text
