"""Equilibria: that the torques balance, how many there are, and which of them motions keep to."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from models.plant.parameters import DrillstringParameters
from models.theory.stability.equilibrium import equilibria, least_running_omega, running_equilibrium
from models.theory.stability.spectrum import spectral_abscissa
from models.theory.stability.torque_curve import TorqueCurve
from tests.oracle import Program, solve
from tests.plant.theory import drive_of, equilibrium, slope_of_torque, torque_on_bit
from tests.theory.strings import LIGHT, NOMINAL, PAPER, oracle_of

STATIC = PAPER.mu_sb * PAPER.R_b * NOMINAL / PAPER.c_a
"""Drive speed up to which a bit at rest is held [rad/s]."""
LEAST = 5.69195076
"""Drive speed down to which the bit can turn steadily [rad/s]: the least of w + T(w) / c_a, from a fine grid."""


@given(
    st.floats(-60, 60),
    st.floats(0, 3e5),
    st.builds(
        DrillstringParameters,
        c_a=st.floats(20, 2e4),
        c_b=st.floats(0, 300),
        gamma_b=st.floats(0, 1),
        v_f=st.floats(0.1, 5),
        mu_sb=st.floats(0.5, 1),
    ),
)
@settings(max_examples=100, deadline=None)
def test_torques_balance_in_as_many_equilibria_as_the_curves_meet(omega, wob, parameters):
    found = equilibria(parameters, omega, wob)
    oracle, turning = oracle_of(parameters), [e for e in found if not e.stuck]
    for e in turning:
        assert math.copysign(1, e.speed) == math.copysign(1, omega)
        assert e.torque == pytest.approx(torque_on_bit(oracle, wob, e.speed), rel=1e-12)
        assert e.torque == pytest.approx(
            parameters.c_a * (omega - e.speed), abs=parameters.c_a * (1e-9 * abs(omega) + 1e-14)
        )
        assert e.slope == pytest.approx(slope_of_torque(oracle, wob, abs(e.speed)), rel=1e-12)
    speeds = np.linspace(0, abs(omega), 20_001)[1:]
    excess = np.array([drive_of(oracle, wob, speed) for speed in speeds[::100]]) - abs(omega)
    assert len(turning) >= np.count_nonzero(np.diff(np.sign(excess)))
    assert len(turning) <= 2
    assert (len(found) > len(turning)) == (
        parameters.c_a * abs(omega) <= wob * parameters.R_b * parameters.mu_sb * (1 + 1e-15)
    )


@pytest.mark.parametrize(
    ("omega", "kinds"),
    [
        (0.9 * LEAST, ["stuck"]),
        (1.001 * LEAST, ["stuck", "turning", "turning"]),
        (0.999 * STATIC, ["stuck", "turning", "turning"]),
        (1.001 * STATIC, ["turning"]),
        (10.0, ["turning"]),
    ],
)
def test_slow_drive_leaves_several_equilibria(omega, kinds):
    for sign in (1.0, -1.0):
        found = equilibria(PAPER, sign * omega, NOMINAL)
        assert ["stuck" if e.stuck else "turning" for e in found] == kinds
        assert all(earlier.speed * sign < later.speed * sign for earlier, later in pairwise(found))


def test_least_running_omega_is_the_least_of_the_curve():
    grid = np.linspace(0.01, 3, 300_001)
    curve = grid + (PAPER.c_b * grid + NOMINAL * PAPER.R_b * (0.5 + 0.3 * np.exp(-0.9 * grid))) / PAPER.c_a
    assert least_running_omega(PAPER, NOMINAL) == pytest.approx(curve.min(), abs=1e-9)
    assert curve.min() == pytest.approx(LEAST, abs=1e-8)


@pytest.mark.parametrize(("omega", "wob"), [(10.0, NOMINAL), (20.0, NOMINAL), (10.0, LIGHT)])
def test_running_equilibrium_is_where_a_motion_stays(omega, wob):
    found = running_equilibrium(PAPER, omega, wob)
    assert found.speed == pytest.approx(equilibrium(oracle_of(PAPER), omega, wob), abs=1e-12)
    start = oracle_of(PAPER, found.speed, found.torque)
    solution = solve(start, Program.constant(omega), Program.constant(wob), 20.0)
    assert solution.bit_speed_extremes(0, 20) == pytest.approx((found.speed, found.speed), abs=1e-10)


def motion_from(speed: float, torque: float, omega: float, end_time: float) -> np.ndarray:
    start = oracle_of(PAPER, speed, torque)
    solution = solve(start, Program.constant(omega), Program.constant(NOMINAL), end_time)
    return solution(np.linspace(0, end_time, 2001))["bit_speed"]


def test_stuck_bit_stays_stuck_when_its_string_is_disturbed_and_the_waves_die_as_the_chain_says():
    stuck = equilibria(PAPER, 5.9, NOMINAL)[0]
    assert stuck.stuck
    assert stuck.torque == pytest.approx(5.9 * PAPER.c_a)
    start = oracle_of(PAPER, 0.0, stuck.torque - 200.0)
    solution = solve(start, Program.constant(5.9), Program.constant(NOMINAL), 20.0)
    assert not solution.releases.size
    early, late = (
        abs(solution(np.array([t]))["bit_torque"][0] - stuck.torque) for t in (1.0, 1.0 + 10 * PAPER.travel_time)
    )
    rate = math.log(late / early) / (10 * PAPER.travel_time)
    assert rate == pytest.approx(spectral_abscissa(PAPER, stuck), rel=1e-9)


@pytest.mark.parametrize("which", [1, 2])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_turning_equilibria_at_slow_drive_are_left(which, sign):
    """The slower with the one real root of a bit that gains from falling friction more than c_a takes, and the rest."""
    found = equilibria(PAPER, 5.9, NOMINAL)[which]
    assert spectral_abscissa(PAPER, found) > 0
    speeds = motion_from(found.speed + sign * 1e-7, found.torque, 5.9, 3.0)
    assert abs(speeds - found.speed).max() > 0.1


def test_slower_of_two_turning_equilibria_has_an_odd_number_of_unstable_roots_one_of_them_real():
    slower = equilibria(PAPER, 5.9, NOMINAL)[1]
    early = motion_from(slower.speed + 1e-9, slower.torque, 5.9, 0.3)
    rate = math.log((early[-1] - slower.speed) / (early[1000] - slower.speed)) / 0.15
    assert spectral_abscissa(PAPER, slower) == pytest.approx(rate, rel=1e-4)


def test_torque_curve_is_that_of_the_paper():
    for speed in (0.1, 1.0, 7.0):
        curve = TorqueCurve.of(PAPER, NOMINAL)
        assert curve.torque(speed) == pytest.approx(torque_on_bit(oracle_of(PAPER), NOMINAL, speed), rel=1e-14)
        assert curve.slope(speed) == pytest.approx(slope_of_torque(oracle_of(PAPER), NOMINAL, speed), rel=1e-14)
        assert curve.speed_of_slope(curve.slope(speed)) == pytest.approx(speed, rel=1e-12)


def test_what_has_no_equilibrium_is_refused():
    for omega, wob, message in (
        (math.inf, 1.0, "Omega is inf"),
        (1.0, math.nan, "WOB is nan"),
        (1.0, -5.0, "WOB is -5"),
    ):
        with pytest.raises(ValueError, match=message):
            equilibria(PAPER, omega, wob)
    with pytest.raises(ValueError, match=r"expected \|Omega\| > 5.69195"):
        running_equilibrium(PAPER, 4.0, NOMINAL)
    assert equilibria(replace(PAPER, c_b=0.0), 3.0, 0.0)[0].speed == pytest.approx(3.0)
