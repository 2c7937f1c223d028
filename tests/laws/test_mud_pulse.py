"""Telemetry from downhole: when a value arrives, how coarse it is, what is lost, and what it is good for."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import pytest

from tests.laws.rig import STEP, run
from tests.plant.drive import Drive
from tests.plant.fmi import OK, Instance, must

pytestmark = pytest.mark.slow

PACKAGINGS = ("native", "python")
TRANSPORT = 1172.0 / 1200.0


def arrivals(packaging: str, step_time: float, size: float, **parameters: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times and what has arrived, when the value steps from 0 to 30."""
    times, found = [], []
    with Drive("MudPulse", parameters, packaging) as link:
        for k in range(round(6.0 / size)):
            link.put(value=30.0 if (k + 1) * size > step_time else 0.0)
            link.go((k + 1) * size)
            times.append((k + 1) * size)
            found.append(link.get("measured"))
    return np.array(times), np.array(found)


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("step_time", [0.005, 0.4, 0.995, 1.005, 2.5])
def test_a_step_arrives_after_sampling_frame_and_transport(packaging: str, step_time: float) -> None:
    size = 0.01
    times, found = arrivals(packaging, step_time, size)
    sampled = math.ceil(step_time)
    due = sampled + 1.0 + TRANSPORT
    arrived = times[np.argmax(found > 15.0)]
    assert due - 1e-9 <= arrived < due + size
    # between communication points it is seen at the next one; with one at the instant, there
    assert found.max() == pytest.approx(30.0, abs=0.5 * 40.0 / 255)


def test_wired_pipe_is_as_fast_as_it_is_sampled() -> None:
    times, found = arrivals("native", 0.4, 0.01, link=2)
    assert times[np.argmax(found > 15.0)] <= 0.4 + 0.02 + 1e-9


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_frames_arrive_on_time_however_late_it_is(packaging: str) -> None:
    """One frame a step through wired pipe: as many of a seed are lost early and late, none for rounding in times."""
    lost: list[list[float]] = []
    for start in (0.0, 1e6):
        with Drive("MudPulse", {"link": 2, "loss": 0.3}, packaging, start=start) as link:
            found: list[float] = []
            for k in range(1000):
                link.go(start + (k + 1) * 0.01)
                found.append(link.get("valid"))
        lost.append(found)
    assert lost[0] == lost[1]


def test_quantum_is_a_255th_of_the_range() -> None:
    seen: set[float] = set()
    with Drive("MudPulse", {"link": 2}) as link:
        for k in range(3000):
            link.put(value=k * 40.0 / 3000)
            link.go((k + 1) * 0.01)
            seen.add(link.get("measured"))
    levels = np.array(sorted(seen))
    assert np.diff(levels) == pytest.approx(40.0 / 255, rel=1e-9)


def test_a_value_is_two_to_three_seconds_old() -> None:
    ages: list[float] = []
    with Drive("MudPulse", {}) as link:
        for k in range(2000):
            link.go((k + 1) * 0.01)
            if link.get("valid"):
                ages.append(link.get("age"))
    assert min(ages) == pytest.approx(1.0 + TRANSPORT, abs=0.011)
    assert max(ages) == pytest.approx(2.0 + TRANSPORT, abs=0.011)


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_lost_frames_are_those_of_the_seed_and_as_many_as_asked_for(packaging: str) -> None:
    valid: dict[int, list[float]] = {}
    for seed in (1, 2):
        with Drive("MudPulse", {"loss": 0.3, "seed": seed, "link": 2}, packaging) as link:
            valid[seed] = []
            for k in range(2000):
                link.go((k + 1) * 0.01)
                valid[seed].append(link.get("valid"))
    assert np.mean(valid[1]) == pytest.approx(0.7, abs=0.04)
    assert valid[1] != valid[2]


def test_more_frames_under_way_than_are_kept_are_refused() -> None:
    with Instance("MudPulse") as link:
        must(link, link.set(bit_rate=1000.0, wave_speed=100.0))
        must(link, link.set(link=3))
        assert link.initialize() != OK
        assert "expected at most 254 times the time between frames" in link.messages[-1].text


def test_set_points_raised_by_what_arrives_free_the_string() -> None:
    """The speed asked for goes up by 1 rad/s every 30 s while the severity that arrives is above 0.3, from 10 rad/s."""
    window: deque[float] = deque(maxlen=2000)
    asked = [10.0]
    with Drive("MudPulse", {"range": 5.0}) as link:

        def act(plant: Drive, k: int) -> dict[str, float]:
            window.append(plant.get("bit_speed"))
            mean = sum(window) / len(window)
            link.put(value=(max(window) - min(window)) / (2.0 * mean) if mean > 0.0 else 5.0)
            link.go((k + 1) * STEP)
            if k % 3000 == 2999 and link.get("valid") and link.get("measured") > 0.3:
                asked[0] += 1.0
            plant.put(Omega=asked[0])
            return {"asked": asked[0]}

        outcome = run(10.0, 0.0, act, 400.0)
    assert outcome.severity < 0.01
    assert 100.0 < outcome.last_stuck < 300.0
    assert 12.0 < asked[0] < 20.0
