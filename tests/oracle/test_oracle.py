"""The oracle is itself held to closed forms, to balances, and to figures from a different solver good to 1e-9."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.oracle import OracleParameters, OracleSolution, Program, solve
from tests.oracle.collocation import gauss_basis
from tests.oracle.elements import FieldSolution, solve_field

pytestmark = pytest.mark.slow

PAPER = OracleParameters()
NOMINAL_WEIGHT = 97347.0
LONG_ENOUGH = 25.0
MATCHED = replace(PAPER, c_a=PAPER.impedance)
HARD_CASES = {
    "drive reverses": (PAPER, Program.held([0, 10.123], [10, -10]), Program.constant(NOMINAL_WEIGHT)),
    "weight lifted while wound up": (
        PAPER,
        Program.constant(10),
        Program.held([0, 2.5, 6, 15], [NOMINAL_WEIGHT, 5000, NOMINAL_WEIGHT, 500]),
    ),
    "weight lifted off": (PAPER, Program.held([0, 18], [10, 0]), Program.held([0, 10, 12], [9e4, 0, 9e4])),
    "ramps": (
        PAPER,
        Program([0, 10, 15, 16.7], [0, 10, 10, 3], [1, 0, -0.2, 0.1]),
        Program([0, 3, 15, 20], [0, 30000, NOMINAL_WEIGHT, NOMINAL_WEIGHT], [10000, 4000, 0, -2000]),
    ),
    "string starts wound up and turning": (
        replace(PAPER, initial_torque=-25000.0, initial_speed=5.0),
        Program.constant(0),
        Program.held([0, 1.5], [NOMINAL_WEIGHT, 20000]),
    ),
    "jumps that coincide with returning waves": (
        PAPER,
        Program.held(np.array([0, 2, 4, 7]) * PAPER.travel_time, [10, -20, 30, 0]),
        Program.held(np.array([0, 1, 3, 9]) * PAPER.travel_time, [NOMINAL_WEIGHT, 1000, 1e5, 5]),
    ),
    "long string, heavy bit, weak drive": (
        replace(PAPER, L=3000.0, I_B=311.0, c_a=500.0),
        Program.constant(10),
        Program.constant(38000),
    ),
    "sharp friction": (
        replace(PAPER, gamma_b=20.0, I_B=20.0),
        Program.constant(10),
        Program.constant(NOMINAL_WEIGHT),
    ),
}


@cache
def from_rest(omega: float, weight: float, bit_damping: float = 0.03, end_time: float = 100.0) -> OracleSolution:
    parameters = replace(PAPER, c_b=bit_damping)
    return solve(parameters, Program.constant(omega), Program.constant(weight), end_time)


def greatest_difference(one: OracleSolution, other: OracleSolution, end_time: float) -> float:
    """Greatest difference of any output, relative to its own size where that is above one."""
    times = np.linspace(0, end_time, 30011)
    first, second = one(times), other(times)
    return max(
        np.abs(first[name].astype(float) - second[name]).max() / max(1, np.abs(first[name].astype(float)).max())
        for name in first
    )


def test_string_constants_are_the_papers():
    assert PAPER.travel_time == pytest.approx(0.3718598930, abs=1e-10)
    assert PAPER.impedance == pytest.approx(299.4138440, abs=1e-7)
    assert PAPER.reflection == pytest.approx(0.7395737659, abs=1e-10)


def test_first_slips_from_rest_are_where_the_other_solver_found_them():
    solution = from_rest(10, NOMINAL_WEIGHT)
    assert solution.releases[:2] == pytest.approx([2.603019251, 5.577898395], abs=2e-9)
    assert solution.stops[:2] == pytest.approx([4.226441632, 5.607609331], abs=2e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bit_damping", "peak", "period"),
    [(0.03, 18.7605, 3.2256227), (0.8, 18.7324, 3.224275), (15, 18.2929, 3.212047), (65, 16.8969, 3.203594)],
)
def test_limit_cycle_is_the_one_the_other_solver_found(bit_damping, peak, period):
    solution = from_rest(10, NOMINAL_WEIGHT, bit_damping)
    begin, end = solution.stops[-2:]
    assert end - begin == pytest.approx(period, abs=1e-6)
    assert solution.bit_speed_extremes(begin, end) == pytest.approx((0, peak), abs=1e-4)


def test_bit_rests_for_the_known_share_of_a_cycle():
    solution = from_rest(10, NOMINAL_WEIGHT)
    begin, end = solution.stops[-2:]
    assert np.diff(solution(np.array([begin, end]))["stuck_time"]) / (end - begin) == pytest.approx(0.458836, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("omega", "weight", "bit_damping", "reference"),
    [
        (10, 31649, 0.03, 8.768644096751),
        (20, NOMINAL_WEIGHT, 0.03, 16.213565871),
        (10, NOMINAL_WEIGHT, 150, 5.768533359),
    ],
)
def test_steady_drilling_ends_where_the_torques_balance(omega, weight, bit_damping, reference):
    def excess(speed):
        friction = PAPER.mu_cb + (PAPER.mu_sb - PAPER.mu_cb) * math.exp(-PAPER.gamma_b * speed / PAPER.v_f)
        return PAPER.c_a * (omega - speed) - bit_damping * speed - weight * PAPER.R_b * friction

    balance = brentq(excess, omega / 2, omega, xtol=1e-14)
    speeds = from_rest(omega, weight, bit_damping, 130.0)(np.array([130.0]))
    assert balance == pytest.approx(reference, abs=1e-9)
    assert speeds["bit_speed"] == pytest.approx(balance, abs=1e-12)
    assert speeds["top_speed"] == pytest.approx(balance, abs=1e-12)


@pytest.mark.slow
def test_finer_pieces_and_higher_degree_change_nothing_over_100_s():
    inputs = Program.constant(10), Program.constant(NOMINAL_WEIGHT)
    other = solve(PAPER, *inputs, 100.0, nodes=16, longest_piece=0.0093)
    solution = from_rest(10, NOMINAL_WEIGHT)
    assert greatest_difference(solution, other, 100.0) < 1e-11
    assert other.releases == pytest.approx(solution.releases, abs=1e-12)
    assert other.stops == pytest.approx(solution.stops, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", HARD_CASES)
def test_hard_cases_do_not_depend_on_pieces_or_degree(name):
    solution, other = (
        solve(*HARD_CASES[name], LONG_ENOUGH, nodes=n, longest_piece=h) for n, h in ((20, 0.015), (26, 0.019))
    )
    assert greatest_difference(solution, other, LONG_ENOUGH) < 1e-11


@pytest.mark.parametrize("name", HARD_CASES)
def test_energy_is_what_was_put_in_less_what_the_bit_used(name):
    outputs = solve(*HARD_CASES[name], LONG_ENOUGH)(np.linspace(0, LONG_ENOUGH, 20011))
    gained = outputs["energy"] - outputs["energy"][0]
    assert gained == pytest.approx(
        outputs["work_in"] - outputs["bit_loss"], abs=1e-12 * outputs["work_in"].max() + 1e-8
    )


def test_hard_cases_hold_reverse_slip_and_passing_straight_through():
    solution = solve(*HARD_CASES["weight lifted while wound up"], LONG_ENOUGH)
    assert len(solution.crossings) == 6
    assert solution.bit_speed_extremes(0, LONG_ENOUGH)[0] == pytest.approx(-12.5, abs=0.1)


def test_mirrored_inputs_give_the_mirrored_motion():
    parameters, omega, weight = HARD_CASES["string starts wound up and turning"]
    mirrored = replace(parameters, initial_speed=-parameters.initial_speed, initial_torque=-parameters.initial_torque)
    times = np.linspace(0, 10, 2001)
    here = solve(parameters, omega, weight, 10.0)(times)
    there = solve(mirrored, omega, weight, 10.0)(times)
    for name in ("bit_speed", "top_speed", "bit_torque", "top_torque", "bit_angle", "top_angle"):
        np.testing.assert_array_equal(here[name], -there[name])


def test_matched_drive_and_constant_friction_follow_exponentials_through_zero_to_rest():
    """No reflection and no falling friction: straight lines in v' against v, solved by hand."""
    parameters = replace(MATCHED, mu_cb=0.6, mu_sb=0.6)
    weight, back, rest = 30000.0, 6.0, 9.0
    impedance, away, friction = parameters.impedance, parameters.travel_time, 0.6 * parameters.R_b * weight
    damping = impedance + parameters.c_b
    omega = Program.held([0, back, rest], [20.0, -20.0, -1.0])
    solution = solve(parameters, omega, Program.constant(weight), 15.0)

    def moving(start, torque, elapsed):
        end = torque / damping
        return end + (start - end) * math.exp(-damping / parameters.I_B * elapsed)

    forward = moving(0, impedance * 20 - friction, back)
    pull = (impedance * 20 + friction) / damping
    crossing = back + away + parameters.I_B / damping * math.log(1 + forward / pull)
    reverse = moving(0, friction - impedance * 20, rest + away - crossing)
    lasting = parameters.I_B / damping * math.log(1 - reverse * damping / (friction - impedance))
    assert solution.releases == pytest.approx([away], abs=1e-13)
    assert solution.crossings == pytest.approx([crossing], abs=1e-12)
    assert solution.stops == pytest.approx([rest + away + lasting], abs=1e-12)
    times = np.array([back + away, rest + away, 14.0])
    assert solution(times)["bit_speed"] == pytest.approx([forward, reverse, 0], abs=1e-12)
    assert solution(times)["bit_torque"][-1] == pytest.approx(-impedance, abs=1e-10)


def test_bit_that_never_turns_gives_the_staircase_of_reflections():
    solution = from_rest(10, 300000.0, end_time=20.0)
    away, share = PAPER.travel_time, PAPER.transmission * 10
    times = np.arange(0.25, 25) * 2 * away
    down = share * np.cumsum(PAPER.reflection ** np.arange(25))
    before = np.concatenate([[0], down[:-1]])
    outputs = solution(times)
    assert outputs["top_torque"] == pytest.approx(PAPER.impedance * (down + before), rel=1e-12)
    assert outputs["bit_torque"] == pytest.approx(PAPER.impedance * 2 * before, rel=1e-12, abs=1e-9)
    assert not solution.releases.size


def test_ramp_releases_the_bit_when_its_torque_reaches_the_static_one():
    start, slope, weight = 1.0, 3.0, 40000.0
    solution = solve(MATCHED, Program([0, start], [0, 0], [0, slope]), Program.constant(weight), 12.0)
    static = MATCHED.mu_sb * MATCHED.R_b * weight
    assert solution.releases[0] == pytest.approx(
        start + MATCHED.travel_time + static / (MATCHED.impedance * slope), abs=1e-12
    )


def grazing_inputs(excess: float, slope: float) -> tuple[OracleParameters, Program, Program]:
    """Lift weight off a bit at rest so that the string's torque, which is falling, is over the static one by that."""
    lifted, speed = 3.0, 20.0
    first = speed + slope * (lifted - MATCHED.travel_time)
    limit = MATCHED.R_b * MATCHED.mu_sb / MATCHED.impedance
    weight = Program.held([0, lifted], [2 * first / limit, (speed - excess / MATCHED.impedance) / limit])
    return replace(MATCHED, initial_torque=MATCHED.impedance * first), Program([0], [first], [-slope]), weight


def grazing(excess: float, slope: float = 15.0) -> OracleSolution:
    """Solve that by the march."""
    return solve(*grazing_inputs(excess, slope), 3.0 + min(0.5, 20.0 / slope))


def grazing_field(excess: float) -> FieldSolution:
    """Solve that by elements."""
    return solve_field(*grazing_inputs(excess, 15.0), np.array([2.9, 3.2]), elements=10)


@pytest.mark.parametrize("slope", [15.0, 1e4])
@pytest.mark.parametrize("excess", [0.0, *(sign * 10.0**power for sign in (-1, 1) for power in range(-15, -9))])
def test_bit_rests_on_where_a_falling_torque_touches_the_static_one_to_rounding(excess, slope):
    solution = grazing(excess, slope)
    assert np.abs(solution(np.linspace(0, solution.end_time, 1001))["bit_speed"]).max() < 1e-12
    assert solution.releases.size == solution.stops.size == 0


@pytest.mark.parametrize("excess", [1e-8, 3e-8, 1e-7])
def test_departure_that_is_over_within_the_rounding_of_an_instant_is_none(excess):
    """The torque falls by 3e6 N m a second: it is over the static one for less than 1e-13 s."""
    solution = grazing(excess, 1e4)
    assert solution(np.array([3.0, 3.001]))["bit_stuck"].all()
    assert solution.releases.size == solution.stops.size == 0


@pytest.mark.parametrize("excess", [1e-3, 0.1, 8.0])
def test_slip_much_shorter_than_a_piece_is_as_long_as_by_hand(excess):
    """The torque falls by Z 15 rad/s² and the friction is the static one, but for what is of third order in time."""
    solution = grazing(excess)
    lasting = 2 * excess / (MATCHED.impedance * 15.0)
    assert lasting < 0.015 / 4
    assert solution.releases == pytest.approx([3.0], abs=1e-13)
    assert solution.stops - solution.releases == pytest.approx([lasting], rel=lasting * 10, abs=1e-12)


@pytest.mark.parametrize("excess", [0.0, *(sign * 10.0**power for sign in (-1, 1) for power in range(-15, -5))])
def test_bit_of_the_elements_rests_on_where_a_falling_torque_touches_the_static_one(excess):
    solution = grazing_field(excess)
    assert not solution.bit_speed.any()
    assert solution.releases.size == solution.stops.size == 0


@pytest.mark.parametrize("excess", [1e-2, 0.1, 8.0])
def test_slip_within_one_step_of_the_elements_ends_where_the_march_ends_it(excess):
    lasting = grazing(excess).stops - 3.0
    assert lasting.size == 1
    solution = grazing_field(excess)
    assert solution.stops - 3.0 == pytest.approx(lasting, rel=1e-6 + 1e-6 / excess)  # a torque good to 1e-6 N m
    assert solution.bit_speed[-1] == 0.0


@pytest.mark.parametrize("rounding", [-1e-15, 0.0, 1e-15])
def test_zero_after_a_start_from_zero_does_not_depend_on_the_rounding_there(rounding):
    basis = gauss_basis(20)
    for zero in (1e-9, 1e-4, 0.01, 0.3):
        x = 1 + basis.nodes
        place = basis.first_fall(x * (zero - x) + rounding, 1e-13, from_zero=True)
        assert place == pytest.approx(zero - 1, abs=1e-11)
    assert basis.first_fall(-1 - basis.nodes + rounding, 1e-13, from_zero=True) == -1.0
    assert basis.first_fall(1 + basis.nodes + rounding, 1e-13, from_zero=True) is None


def test_outputs_at_a_jump_are_left_limits():
    solution = solve(PAPER, Program.held([0, 5], [10, 12]), Program.held([0, 3], [NOMINAL_WEIGHT, 5e4]), 8.0)
    for time, name in ((5.0, "top_torque"), (5.0, "top_speed"), (3.0, "bit_torque")):
        before, at, after = solution(np.array([time - 1e-9, time, time + 1e-9]))[name]
        assert at == pytest.approx(before, abs=1e-3)
        assert abs(after - at) > 1


def test_running_equilibrium_stays_though_the_bit_from_rest_sticks():
    torque = PAPER.c_a * (10 - 6.20518676448)
    parameters = replace(PAPER, initial_speed=6.20518676448, initial_torque=torque)
    solution = solve(parameters, Program.constant(10), Program.constant(NOMINAL_WEIGHT), 50.0)
    assert solution.bit_speed_extremes(0, 50) == pytest.approx((6.20518676448, 6.20518676448), abs=1e-9)


def test_bit_at_rest_under_more_than_static_torque_slips_at_once():
    weight = 20000.0
    parameters = replace(PAPER, initial_torque=1.01 * PAPER.mu_sb * PAPER.R_b * weight)
    solution = solve(parameters, Program.constant(0), Program.constant(weight), 1.0)
    assert solution.releases[0] == 0
    assert not solution(np.array([0.0]))["bit_stuck"][0]


def test_negative_weight_is_refused():
    with pytest.raises(ValueError, match="weight on bit is negative"):
        solve(PAPER, Program.constant(10), Program([0], [100], [-100]), 2.0)
