"""The stick-slip cycle against the oracle's long simulation: its measures, its motion, and how disturbances decay."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from models.plant.parameters import DrillstringParameters
from models.theory.cycle.cycle import LimitCycle, broken_law, limit_cycle
from models.theory.cycle.equations import equations, with_input
from models.theory.cycle.solver import held_at, resolved
from models.theory.stability.neutral_form import neutral_form
from tests.oracle import OracleSolution, Program, solve
from tests.theory.strings import LIGHT, NOMINAL, PAPER, oracle_of

pytestmark = pytest.mark.slow

CASES = {
    # string, Omega, WOB, slips in a period, and for how long the oracle is to run until it repeats to 1e-9
    "figure 2": (PAPER, 10.0, NOMINAL, 1, 100.0),
    "damped bit": (replace(PAPER, c_b=65.0), 10.0, NOMINAL, 1, 90.0),
    "heavy bit": (replace(PAPER, I_B=311.0), 10.0, NOMINAL, 1, 110.0),
    "short string": (replace(PAPER, L=400.0), 10.0, NOMINAL, 1, 50.0),
    "light weight, slow drive": (PAPER, 4.0, LIGHT, 1, 100.0),
    "two slips": (PAPER, 6.09, NOMINAL, 2, 130.0),
    "three slips": (PAPER, 7.35, NOMINAL, 3, 110.0),
}


@cache
def cycle(name: str) -> LimitCycle:
    parameters, omega, wob, _, _ = CASES[name]
    return limit_cycle(parameters, omega, wob)


@cache
def simulated(parameters: DrillstringParameters, omega: float, wob: float, end: float) -> OracleSolution:
    return solve(oracle_of(parameters), Program.constant(omega), Program.constant(wob), end)


def oracle(name: str) -> OracleSolution:
    parameters, omega, wob, _, end = CASES[name]
    return simulated(parameters, omega, wob, end)


def test_cycle_of_figure_2_has_the_measures_another_solver_found():
    found = cycle("figure 2")
    assert found.period == pytest.approx(3.2256227, abs=1e-7)
    assert found.stuck_fraction == pytest.approx(0.458836, abs=1e-6)
    assert found.peak == pytest.approx(18.7605, abs=1e-4)


@pytest.mark.parametrize("name", CASES)
def test_times_of_a_cycle_are_those_of_a_long_simulation(name):
    found, solution, slips = cycle(name), oracle(name), CASES[name][3]
    assert len(found.stops) == len(found.releases) == slips
    stops = solution.stops[-slips - 1 :]
    assert found.period == pytest.approx(stops[-1] - stops[0], abs=2e-9)
    stuck = np.diff(solution(stops[[0, -1]])["stuck_time"])[0]
    assert found.stuck_fraction * found.period == pytest.approx(stuck, abs=2e-9)
    assert found.peak == pytest.approx(solution.bit_speed_extremes(stops[0], stops[-1])[1], abs=1e-7)


@pytest.mark.parametrize("name", CASES)
def test_motion_is_that_of_a_long_simulation_all_through_the_period(name):
    found, solution = cycle(name), oracle(name)
    begin = solution.stops[-1] - found.period
    waits = [(release - max([begin, *solution.stops[solution.stops < release]]), release) for release in
             solution.releases if begin - 1e-9 < release < solution.stops[-1]]  # fmt: skip
    start = max(waits)[1] - found.period  # the first release is that after the longest rest
    times = np.linspace(0, found.period, 2001)[:-1]
    there = solution(start + times)
    assert found.bit_speed(times) == pytest.approx(there["bit_speed"], abs=1e-7)
    stuck = there["bit_stuck"]
    torque = 2 * found.orbit.parameters.impedance * found.orbit.incident(times)
    assert torque[stuck] == pytest.approx(there["bit_torque"][stuck], abs=1e-4)


@pytest.mark.parametrize("name", CASES)
def test_shift_in_time_neither_grows_nor_decays(name):
    found = cycle(name)
    assert np.abs(found.multipliers - 1).min() < 2e-6
    assert found.difference_multiplier <= found.multiplier < 1
    operator = neutral_form(found.orbit.parameters).difference
    per_period = found.period / found.orbit.parameters.travel_time
    assert found.difference_multiplier == pytest.approx(operator.radius**per_period, rel=1e-9)


def deviations(omega: float, end: float) -> np.ndarray:
    """Return how far intervals between stops are from the period, one after another, as the cycle is approached."""
    solution = simulated(PAPER, omega, NOMINAL, end)
    return np.diff(solution.stops) - limit_cycle(PAPER, omega, NOMINAL).period


def test_disturbance_of_the_cycle_of_figure_2_decays_as_its_multipliers_say():
    """The drive, slowed by 0.01 rad/s within a period, leaves one: a recurrence fits how it decays, stop by stop."""
    slowed = Program((0.0, 60.0, 63.2), (10.01, 10.01, 10.0), (0.0, -0.01 / 3.2, 0.0))
    stops = solve(oracle_of(PAPER), slowed, Program.constant(NOMINAL), 140.0).stops
    change = np.diff(stops[stops > 63.2], 2)[8:20]
    assert 1e-12 < np.abs(change[-1]) < np.abs(change[0]) < 1e-6
    columns, weights = np.stack([change[:-3], change[1:-2], change[2:-1]], axis=1), 1 / change[3:]
    coefficients, *_ = np.linalg.lstsq(columns * weights[:, None], np.ones(weights.size))
    leading, *pair = sorted(np.roots([1, *-coefficients[::-1]]), key=lambda root: (-root.real, root.imag))
    found = cycle("figure 2")
    assert found.multiplier == pytest.approx(0.43680, abs=1e-5)
    assert leading == pytest.approx(found.multiplier, abs=5e-4)
    assert pair == pytest.approx(sorted(found.multipliers[2:4], key=lambda root: root.imag), abs=0.015)


def test_jump_that_goes_to_and_fro_shrinks_by_the_difference_part_in_a_period():
    """The bit has inertia: what a jump of the drive becomes is left to the reflections, |Upsilon| each round trip."""
    found, round_trip, begin = cycle("figure 2"), 2 * PAPER.travel_time, 40.0
    jumping = Program.held((0.0, begin), (10.0, 10.5))
    solution = solve(oracle_of(PAPER), jumping, Program.constant(NOMINAL), begin + 7 * round_trip)
    returns = begin + round_trip * np.arange(1, 7)  # between the instants around a return the speed moves by 5e-8 rad/s
    jumps = solution(returns + 1e-9)["top_speed"] - solution(returns - 1e-9)["top_speed"]
    per_period = (jumps[1:] / jumps[:-1]) ** (found.period / round_trip)
    assert per_period == pytest.approx(found.difference_multiplier, abs=1e-6)
    assert found.difference_multiplier == pytest.approx(0.270242, abs=1e-6)


def test_disturbance_turns_as_a_pair_of_multipliers_says():
    """x[n + 2] = 2 Re(lambda) x[n + 1] - |lambda|^2 x[n], at 13 rad/s."""
    late = deviations(13.0, 80.0)[-13:]
    (trace, negative_determinant), *_ = np.linalg.lstsq(np.stack([late[1:-1], late[:-2]], axis=1), late[2:])
    pair = limit_cycle(PAPER, 13.0, NOMINAL).multipliers[1]
    assert abs(pair.imag) > 0.1
    assert trace == pytest.approx(2 * pair.real, abs=5e-3)
    assert -negative_determinant == pytest.approx(abs(pair) ** 2, abs=5e-3)


def test_finer_pieces_change_nothing():
    found = cycle("figure 2")
    finer = replace(found.orbit.mesh.resolution, limits=found.orbit.mesh.resolution.limits / 3)
    finer = replace(finer, faintest_stop=1e-12, faintest_release=1e-9)
    orbit = replace(found.orbit, mesh=replace(found.orbit.mesh, resolution=finer))
    again = resolved(orbit, "Omega", held_at("Omega", 10.0))
    assert again.mesh.size > 1.5 * found.orbit.mesh.size
    assert again.timing.vector == pytest.approx(found.orbit.timing.vector, abs=1e-10)


def test_derivatives_of_the_equations_are_their_differences():
    orbit = cycle("figure 2").orbit
    here, random = equations(orbit), np.random.default_rng(0)
    change = 1e-6 * random.normal(size=orbit.values.size)
    there = equations(replace(orbit, values=orbit.values + change))
    assert there.residual - here.residual == pytest.approx(here.by_values @ change, abs=1e-11)
    for name, step in (("Omega", 1e-3), ("WOB", 1.0)):
        value = {"Omega": orbit.omega, "WOB": orbit.wob}[name]
        pair = [equations(with_input(orbit, name, value + sign * step)).residual for sign in (1, -1)]
        assert (pair[0] - pair[1]) / (2 * step) == pytest.approx(here.by_input[name], abs=1e-10)
    for column in range(orbit.timing.vector.size):
        change = 1e-6 * np.eye(orbit.timing.vector.size)[column]
        pair = [equations(replace(orbit, mesh=orbit.mesh.moved(sign * change))).residual for sign in (1, -1)]
        assert (pair[0] - pair[1]) / 2e-6 == pytest.approx(here.by_timing[:, column], rel=1e-6, abs=1e-4)


def test_motion_that_would_have_broken_loose_before_is_seen():
    orbit = cycle("figure 2").orbit
    assert broken_law(orbit) is None
    assert "above what can hold it" in broken_law(with_input(orbit, "WOB", 0.97 * NOMINAL))
    assert "turn backwards" in broken_law(replace(orbit, values=orbit.values - 1e-3))


@pytest.mark.parametrize(
    ("omega", "wob", "message"),
    [
        (5.0, NOMINAL, "no stick-slip cycle found at Omega = 5.0 rad/s, WOB = 97347.0 N: the bit ends in rest"),
        (20.0, NOMINAL, "the bit ends in steady rotation"),
        (10.0, LIGHT, "the bit ends in steady rotation"),
        (0.0, NOMINAL, "Omega is 0.0; expected a finite value > 0"),
        (math.nan, NOMINAL, "Omega is nan"),
        (10.0, -1.0, "WOB is -1.0"),
    ],
)
def test_where_there_is_no_cycle_it_says_so(omega, wob, message):
    with pytest.raises(ValueError, match=message):
        limit_cycle(PAPER, omega, wob)
