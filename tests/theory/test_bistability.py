"""Cycles from the loss of stability to their fold: against harmonic balance, and against what the plant really does."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from models.theory.cycle.bistability import Bistability, bistable_omegas, bistable_wobs
from models.theory.cycle.continuation import BranchPoint, branch_from
from models.theory.cycle.cycle import broken_law, limit_cycle
from models.theory.cycle.floquet import leading_multiplier, multipliers
from models.theory.cycle.solver import held_at, resolved
from models.theory.stability.equilibrium import running_equilibrium
from models.theory.stability.spectrum import critical_omega, critical_point, critical_wob
from tests.plant.drive import PLANT, Drive
from tests.theory.harmonics import balanced
from tests.theory.strings import LIGHT, NOMINAL, PAPER, STRINGS, oracle_of

pytestmark = pytest.mark.slow


@cache
def over_omega() -> Bistability:
    return bistable_omegas(PAPER, NOMINAL, lambda done, part: told.append((done, part)))


told: list[tuple[str, float]] = []


def test_progress_grows_with_every_cycle_that_is_found() -> None:
    found = over_omega()
    parts = [part for _, part in told]
    assert parts == sorted(parts)
    assert 0.0 < parts[0] < parts[-1] < 1.0
    assert len(told) >= len(found.points) - 2
    assert told[0][0].startswith("2 cycles, Omega = 8.3")


@cache
def over_wob() -> Bistability:
    return bistable_wobs(PAPER, 10.0)


class Plant(Drive):
    """The plant from a uniform motion, at a constant drive speed and weight that can be changed slowly."""

    def __init__(self, omega: float, wob: float, speed: float = 0.0, torque: float = 0.0) -> None:
        start = {"Omega": omega, "WOB": wob, "initial_speed": speed, "initial_torque": torque}
        super().__init__(PLANT, asdict(PAPER) | start)

    def run(self, duration: float, **ramps: tuple[float, float]) -> None:
        """Go on, inputs going from a value to another in small steps."""
        begin, count = self.time, round(duration / 0.1)
        for k in range(count):
            for name, (first, last) in ramps.items():
                self.put(**{name: first + (last - first) * (k + 1) / count})
            self.go(begin + (k + 1) * duration / count)

    def period(self) -> float:
        """Return the time from a stop to the next but those of short slips: the last that repeats."""
        stops: list[float] = []
        while len(stops) < 5:
            self.go(self.time + 0.05)
            last = self.get("last_stop_time")
            if not stops or last > stops[-1]:
                stops.append(last)
        return stops[-1] - stops[-2]

    def slips(self, duration: float) -> bool:
        """Return whether the bit sticks and slips for as long."""
        before = self.get("slip_count")
        self.run(duration)
        return self.get("slip_count") > before


def test_between_the_threshold_and_the_fold_both_live_on():
    found = over_omega()
    assert found.threshold == critical_omega(PAPER, NOMINAL)
    assert found.grazing == pytest.approx(16.626078549, abs=1e-8)  # as this code found it, at two resolutions
    assert found.fold == pytest.approx(17.462442232, abs=1e-8)
    for point in found.points:
        assert found.threshold < point.input <= found.fold + 1e-7
        assert broken_law(point.orbit) is None


def test_stick_slip_lives_on_up_to_the_fold_of_cycles_and_not_beyond():
    fold = over_omega().fold
    with Plant(10.0, NOMINAL) as plant:
        plant.run(40.0)
        plant.run(120.0, Omega=(10.0, fold - 0.02))
        assert plant.slips(100.0)
        plant.run(10.0, Omega=(fold - 0.02, fold + 0.02))
        plant.run(150.0)
        assert not plant.slips(50.0)
        assert plant.get("bit_speed") == pytest.approx(running_equilibrium(PAPER, fold + 0.02, NOMINAL).speed, abs=1e-3)


def test_steady_rotation_lives_on_down_to_the_threshold_and_not_beyond():
    threshold = over_omega().threshold
    start = running_equilibrium(PAPER, threshold + 0.3, NOMINAL)
    with Plant(threshold + 0.3, NOMINAL, start.speed, start.torque) as plant:
        plant.run(100.0, Omega=(threshold + 0.3, threshold + 0.02))
        assert not plant.slips(200.0)
        plant.run(10.0, Omega=(threshold + 0.02, threshold - 0.1))
        plant.run(300.0)
        assert plant.slips(50.0)


def test_over_weight_stick_slip_lives_on_down_to_the_fold_and_rotation_up_to_the_threshold():
    found = over_wob()
    assert found.threshold == pytest.approx(critical_wob(PAPER, 10.0))
    assert found.fold < found.grazing < NOMINAL < found.threshold
    assert found.fold == pytest.approx(47270.905943, abs=1e-4)
    with Plant(10.0, NOMINAL) as plant:
        plant.run(40.0)
        plant.run(120.0, WOB=(NOMINAL, found.fold + 150.0))
        assert plant.slips(100.0)
        plant.run(10.0, WOB=(found.fold + 150.0, found.fold - 150.0))
        plant.run(150.0)
        assert not plant.slips(50.0)
        plant.run(200.0, WOB=(found.fold - 150.0, found.threshold - 300.0))
        assert not plant.slips(200.0)
        plant.run(10.0, WOB=(found.threshold - 300.0, found.threshold + 1500.0))
        plant.run(300.0)
        assert plant.slips(50.0)


@pytest.mark.parametrize("number", [2, 5, 8])
def test_cycles_without_rest_are_those_of_harmonic_balance(number):
    orbit = over_omega().points[number].orbit
    assert not orbit.timing.slips
    critical = critical_point(PAPER, NOMINAL)
    guess = critical.speed, 0.1, critical.frequency, critical.omega
    least = float(orbit.speed(np.zeros(1))[0])
    omega, frequency, speeds = balanced(oracle_of(PAPER), NOMINAL, least, guess)
    assert omega == pytest.approx(orbit.omega, abs=1e-7)
    assert 2 * math.pi / frequency == pytest.approx(orbit.timing.period, abs=1e-8)
    there = orbit.speed(orbit.timing.period * np.arange(speeds.size) / speeds.size)
    assert speeds == pytest.approx(there, abs=1e-6)


def test_first_cycles_are_those_of_the_hopf_point():
    found, critical = over_omega(), critical_point(PAPER, NOMINAL)
    first = found.points[0].orbit
    assert first.timing.period == pytest.approx(2 * math.pi / critical.frequency, rel=1e-4)
    assert first.omega == pytest.approx(critical.omega, rel=1e-3)


def test_cycles_are_unstable_from_the_threshold_to_the_fold_and_stable_beyond():
    found = over_omega()
    rates = [leading_multiplier(multipliers(point.orbit)) for point in found.points[1:]]
    before, after = rates[:-1], rates[-1]
    assert all(rate.imag == 0 and rate.real > 1 for rate in before[:-1])
    assert abs(after) < 1
    at_fold = multipliers(found.fold_cycle)
    assert np.sort(np.abs(at_fold - 1))[:2].max() < 0.02  # a double one, which rounding splits
    assert np.abs(at_fold[2:]).max() < 0.9


def edge_of_the_basins(omega: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the minima of the bit speed and their times in a motion between rotation and stick-slip."""
    torque = running_equilibrium(PAPER, omega, NOMINAL).torque
    low, high = running_equilibrium(PAPER, omega, NOMINAL).speed, 25.0

    def sticks(speed: float) -> bool:
        with Plant(omega, NOMINAL, speed, torque) as plant:
            while plant.time < 100.0:  # a motion that takes longer to decide is beside the edge as long as it matters
                plant.go(plant.time + 1.0)
                if plant.get("slip_count") or plant.get("bit_stuck"):
                    return True
        return False

    assert sticks(high)
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if sticks(middle) else (middle, high)
    step, speeds = 0.002, []
    with Plant(omega, NOMINAL, low, torque) as plant:
        while plant.time < 80.0:
            plant.go((len(speeds) + 1) * step)
            speeds.append(plant.get("bit_speed"))
    v = np.array(speeds)
    places = np.flatnonzero((v[1:-1] < v[:-2]) & (v[1:-1] <= v[2:])) + 1
    left, here, right = v[places - 1], v[places], v[places + 1]
    shift = (left - right) / (2 * (left - 2 * here + right))
    return here - 0.25 * (left - right) * shift, (places + 1 + shift) * step


def test_motion_between_rotation_and_stick_slip_follows_the_unstable_cycle():
    """Kept between the two by bisection, the plant stays beside the unstable cycle, until it is repelled."""
    point = unstable_at(9.0)
    orbit = point.orbit
    minima, times = edge_of_the_basins(9.0)
    apart = minima - float(orbit.speed(np.zeros(1))[0])
    beside = int(np.abs(apart).argmin())
    assert np.abs(apart[beside]) < 1e-6
    assert np.diff(times)[beside] == pytest.approx(orbit.timing.period, abs=5e-6)
    assert 1e-5 < np.abs(apart[-1]) < 1e-3
    rate = leading_multiplier(multipliers(orbit)).real
    assert rate == pytest.approx(2.278, abs=1e-3)
    assert apart[-2:] / apart[-3:-1] == pytest.approx(rate, abs=2e-3)


def unstable_at(omega: float) -> BranchPoint:
    """Return the cycle at a drive speed among those that come from the threshold."""
    nearest = min(over_omega().points, key=lambda point: (point.orbit.timing.slips, abs(point.input - omega)))
    return replace(nearest, orbit=resolved(nearest.orbit, "Omega", held_at("Omega", omega)))


def test_two_stick_slip_cycles_live_beside_each_other():
    """Followed from 13 rad/s down, the cycle is not the one that a bit from rest comes to; both are stable."""
    branch = branch_from(limit_cycle(PAPER, 13.0, NOMINAL).orbit, "Omega", False, lambda point: point.input < 12.72)
    other, usual = branch.points[-1].orbit, limit_cycle(PAPER, branch.points[-1].input, NOMINAL)
    assert usual.period > other.timing.period + 0.1
    assert abs(leading_multiplier(multipliers(other))) < 1
    assert usual.multiplier < 1
    with Plant(13.0, NOMINAL) as plant:
        plant.run(60.0)
        plant.run(60.0, Omega=(13.0, other.omega))
        plant.run(60.0)
        assert plant.period() == pytest.approx(other.timing.period, abs=1e-6)
    with Plant(other.omega, NOMINAL) as plant:
        plant.run(80.0)
        assert plant.period() == pytest.approx(usual.period, abs=1e-6)


@pytest.mark.parametrize(
    ("free", "growing", "end"),
    [("Omega", True, 10.2), ("Omega", False, 9.6), ("WOB", True, 95e3), ("WOB", False, 90e3)],
)
def test_followed_cycles_are_those_that_a_bit_from_rest_comes_to(free, growing, end):
    sign = 1 if growing else -1
    start = limit_cycle(PAPER, 10.0, 92e3)
    branch = branch_from(start.orbit, free, growing, lambda point: sign * (point.input - end) > 0)
    assert branch.end == "it was followed as far as asked for"
    assert all(sign * (after.input - before.input) > 0 for before, after in pairwise(branch.points))
    orbit = branch.points[-1].orbit
    found = limit_cycle(PAPER, orbit.omega, orbit.wob)
    assert orbit.timing.vector == pytest.approx(found.orbit.timing.vector, abs=1e-7)
    assert abs(found.period - start.period) > 1e-3


def test_branch_ends_where_an_echo_would_free_the_resting_bit():
    branch = branch_from(limit_cycle(PAPER, 11.0, NOMINAL).orbit, "Omega", True, lambda point: point.input > 12)
    assert "torque on the resting bit" in branch.end
    last = branch.points[-1]
    assert last.input == pytest.approx(11.013, abs=2e-3)
    for omega, slips in ((last.input - 0.005, 1), (last.input + 0.005, 2)):
        assert len(limit_cycle(PAPER, omega, NOMINAL).stops) == slips


def test_other_weights_and_bits_have_a_fold_beyond_their_threshold():
    for parameters, wob, fold in ((PAPER, LIGHT, 7.4839802), (STRINGS["heavy bit"], NOMINAL, 11.3785036)):
        found = bistable_omegas(parameters, wob)
        assert found.fold == pytest.approx(fold, abs=1e-6)
        assert found.threshold < found.grazing < found.fold


def test_where_nothing_is_born_at_the_threshold_it_says_so():
    with pytest.raises(ValueError, match="without an oscillation"):
        bistable_omegas(STRINGS["very heavy bit"], NOMINAL)
    with pytest.raises(ValueError, match="stable at every Omega"):
        bistable_omegas(PAPER, 1000.0)
