"""Characteristic roots and critical values, against 40-digit arithmetic, closed forms and small-signal simulation."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from scipy.optimize import brentq

from models.plant.parameters import DrillstringParameters
from models.theory.stability.characteristic import Characteristic
from models.theory.stability.equilibrium import equilibria, least_running_omega, running_equilibrium
from models.theory.stability.spectrum import (
    critical_omega,
    critical_point,
    critical_slope,
    critical_wob,
    rightmost_roots,
    roots_about,
    spectral_abscissa,
    unstable_count,
)
from tests.oracle import Program, solve
from tests.plant.theory import drive_of, slope_of_torque, torque_on_bit
from tests.theory.strings import LIGHT, NOMINAL, PAPER, STRINGS, oracle_of

DIGITS = 40
SPEEDS = (1.7, 4.0, 9.0)


def exactly(parameters: DrillstringParameters, slope: float, s: complex) -> mpmath.mpc:
    """Return the root next to s to 40 digits: I_B s + T' + Z (1 + Y e) = Y e (I_B s + T' - Z) written as impedances."""
    p = {name: mpmath.mpf(getattr(parameters, name)) for name in ("G", "J", "I", "L", "I_B", "c_a")}
    z = mpmath.sqrt(p["I"] * p["G"] * p["J"])
    gamma = p["L"] * mpmath.sqrt(p["I"] / (p["G"] * p["J"]))

    def impedances(x: mpmath.mpc) -> mpmath.mpc:
        """Those of the bit and of a line that ends in c_a, by the tangent formula of transmission lines."""
        t = mpmath.tanh(gamma * x)
        return (p["I_B"] * x + slope) * (z + p["c_a"] * t) + z * (p["c_a"] + z * t)

    with mpmath.workdps(DIGITS):
        return mpmath.findroot(impedances, mpmath.mpc(s), tol=1e-30)


def at_speed(name: str, speed: float) -> tuple[DrillstringParameters, float]:
    """Return a string, and the Omega at which its bit turns with a speed."""
    return STRINGS[name], drive_of(oracle_of(STRINGS[name]), NOMINAL, speed)


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("name", STRINGS)
def test_roots_are_exact_to_1e_10(name, speed):
    parameters, omega = at_speed(name, speed)
    equilibrium = equilibria(parameters, omega, NOMINAL)[-1]
    roots = rightmost_roots(parameters, omega, NOMINAL, 12)
    assert roots.shape == (12,)
    for root in roots:
        assert abs(complex(exactly(parameters, equilibrium.slope, root)) - root) < 1e-10
    assert np.diff(np.sort_complex(np.round(roots, 9))).all()


@pytest.mark.parametrize("speed", SPEEDS)
@pytest.mark.parametrize("name", STRINGS)
def test_none_is_missing(name, speed):
    """The integral of h'/h, by quadrature, round all the strip up to a height midway between two roots."""
    parameters, omega = at_speed(name, speed)
    function = Characteristic(parameters, slope_of_torque(oracle_of(parameters), NOMINAL, speed))
    roots = rightmost_roots(parameters, omega, NOMINAL, 26)
    uppers = np.sort(roots.imag[roots.imag > 0])
    height = (uppers[6] + uppers[7]) / 2
    left, right = sorted((function.chain, function.local))
    left, right = left - 0.5 / parameters.travel_time, right + 0.5 / parameters.travel_time
    corners = [left - 1j * height, right - 1j * height, right + 1j * height, left + 1j * height]
    nodes, weights = np.polynomial.legendre.leggauss(10)
    cuts = np.linspace(0, 1, 401)
    total = 0.0
    for start, end in zip(corners, [*corners[1:], corners[0]], strict=True):
        places = start + (end - start) * (cuts[:-1, None] + np.diff(cuts)[:, None] * (nodes + 1) / 2)
        total += ((function.derivative(places) / function.value(places)) @ weights).sum() * (end - start) / 800
    assert total / (2j * math.pi) == pytest.approx((np.abs(roots.imag) < height).sum(), abs=1e-6)


@pytest.mark.parametrize("name", STRINGS)
def test_unstable_roots_are_as_many_as_the_argument_principle_counts(name):
    parameters = STRINGS[name]
    for speed in (0.2, 1.0, 1.7, 3.0, 4.5, 6.0, 12.0):
        equilibrium = min(equilibria(*at_speed(name, speed), NOMINAL), key=lambda e: abs(e.speed - speed))
        assert equilibrium.speed == pytest.approx(speed, rel=1e-9)
        count = unstable_count(parameters, equilibrium)
        roots = roots_about(parameters, equilibrium, count + 1)
        assert (roots.real > 0).sum() == count
        assert (spectral_abscissa(parameters, equilibrium) < 0) == (count == 0)


def test_all_roots_lie_between_the_chain_and_the_rate_of_the_bit_alone():
    for name, parameters in STRINGS.items():
        for speed in SPEEDS:
            slope = slope_of_torque(oracle_of(parameters), NOMINAL, speed)
            chain = math.log(abs(parameters.reflection)) / (2 * parameters.travel_time)
            low, high = sorted((chain, -slope / parameters.I_B))
            roots = rightmost_roots(*at_speed(name, speed), NOMINAL, 30)
            assert roots.real.min() > low - 1e-9
            assert roots.real.max() < high + 1e-9


def test_far_roots_draw_near_the_chain():
    roots = rightmost_roots(PAPER, 10.0, NOMINAL, 101)
    chain = math.log(PAPER.reflection) / (2 * PAPER.travel_time)
    assert 0 < roots[-1].real - chain < 1e-3 * (roots[0].real - chain)
    assert np.diff(roots[-9::2].imag) == pytest.approx(math.pi / PAPER.travel_time, rel=1e-3)


def test_without_reflection_there_is_one_root():
    matched = replace(PAPER, c_a=PAPER.impedance)
    slope = slope_of_torque(oracle_of(matched), NOMINAL, 6.0)
    omega = drive_of(oracle_of(matched), NOMINAL, 6.0)
    assert rightmost_roots(matched, omega, NOMINAL, 3) == pytest.approx([-(slope + matched.impedance) / matched.I_B])


def test_top_that_turns_rigidly_leaves_a_string_clamped_to_the_drive():
    """c_a to infinity: I_B s + T' + Z coth(Gamma s) = 0, whose error is of order Z^2 / c_a."""
    slope = slope_of_torque(oracle_of(PAPER), NOMINAL, 9.0)
    errors = []
    for sliding in (1e7, 1e8):
        rigid = replace(PAPER, c_a=sliding)
        for root in rightmost_roots(rigid, drive_of(oracle_of(rigid), NOMINAL, 9.0), NOMINAL, 6):
            clamped = mpmath.findroot(
                lambda s: (PAPER.I_B * s + slope) * mpmath.tanh(PAPER.travel_time * s) + PAPER.impedance,
                mpmath.mpc(root),
            )
            errors.append(abs(complex(clamped) - root))
    assert max(errors[:6]) < 2e-4
    assert max(errors[6:]) < 2e-5


def test_more_points_of_the_generator_give_the_roots_ever_faster():
    equilibrium = running_equilibrium(PAPER, 10.0, NOMINAL)
    exact = rightmost_roots(PAPER, 10.0, NOMINAL, 1)[0]
    system = Characteristic(PAPER, equilibrium.slope).system()
    errors = [np.abs(np.linalg.eigvals(system.generator(degree)) - exact).min() for degree in (4, 6, 8, 12)]
    assert errors[0] < 0.1
    assert all(later < earlier / 20 for earlier, later in pairwise(errors))
    assert errors[-1] < 1e-9


def test_small_disturbance_dies_at_the_rate_of_the_rightmost_root():
    equilibrium = running_equilibrium(PAPER, 10.0, NOMINAL)
    root = rightmost_roots(PAPER, 10.0, NOMINAL, 1)[0]
    disturbed = oracle_of(PAPER, equilibrium.speed + 1e-3, equilibrium.torque)
    solution = solve(disturbed, Program.constant(10.0), Program.constant(NOMINAL), 46.0)
    period = 2 * math.pi / root.imag
    spans = (start + np.linspace(0, 2 * period, 400) for start in (20.0, 20.0 + 8 * period))
    first, later = (np.sqrt(np.mean((solution(span)["bit_speed"] - equilibrium.speed) ** 2)) for span in spans)
    assert math.log(later / first) / (8 * period) == pytest.approx(root.real, rel=1e-3)


@pytest.mark.parametrize(
    ("parameters", "wob", "omega"),
    [(PAPER, NOMINAL, 8.345275247), (STRINGS["heavy bit"], NOMINAL, 7.492695301), (PAPER, LIGHT, 4.541597865)],
)
def test_critical_drive_speed_is_the_one_another_solver_found(parameters, wob, omega):
    assert critical_omega(parameters, wob) == pytest.approx(omega, abs=1e-8)
    assert critical_wob(parameters, omega) == pytest.approx(wob, abs=1e-4)


def test_critical_point_of_the_paper_is_the_known_one():
    point = critical_point(PAPER, NOMINAL)
    assert point.frequency == pytest.approx(2.473392, abs=1e-6)
    assert point.speed == pytest.approx(4.520150, abs=1e-6)


def crossings(parameters: DrillstringParameters) -> list[float]:
    """Return all slopes T' for which a root lies on the axis: I_B w = -Im of the string's impedance has a top end."""
    upsilon, z = parameters.reflection, parameters.impedance
    top = 2 * z * abs(upsilon) / ((1 - upsilon**2) * parameters.I_B)

    def string(w: float) -> complex:
        echo = upsilon * cmath.exp(-2j * parameters.travel_time * w)
        return z * (1 + echo) / (1 - echo)

    def reactance(w: float) -> float:
        return string(w).imag + parameters.I_B * w

    grid = np.linspace(0, 1.001 * top, 100_001)[1:]
    signs = np.diff(np.sign([reactance(w) for w in grid]))
    roots = [brentq(reactance, *grid[place : place + 2], xtol=1e-14) for place in np.flatnonzero(signs)]
    return [-string(w).real for w in (0.0, *roots)]


@pytest.mark.parametrize("name", STRINGS)
def test_stability_is_lost_at_the_greatest_slope_at_which_a_root_is_on_the_axis(name):
    _, slope = critical_slope(STRINGS[name])
    assert slope == pytest.approx(max(crossings(STRINGS[name])), rel=1e-9)


@pytest.mark.parametrize("name", STRINGS)
def test_equilibrium_is_stable_just_above_the_critical_drive_speed_and_not_below(name):
    parameters = STRINGS[name]
    point = critical_point(parameters, NOMINAL)
    above = running_equilibrium(parameters, point.omega * (1 + 1e-4), NOMINAL)
    assert unstable_count(parameters, above) == 0
    if point.frequency:
        below = running_equilibrium(parameters, point.omega * (1 - 1e-4), NOMINAL)
        assert unstable_count(parameters, below) == 2
    else:
        assert point.omega == pytest.approx(least_running_omega(parameters, NOMINAL), rel=1e-12)
        with pytest.raises(ValueError, match="no running equilibrium"):
            running_equilibrium(parameters, point.omega * (1 - 1e-4), NOMINAL)


def test_critical_point_satisfies_the_printed_equations_to_14_digits():
    point = critical_point(PAPER, NOMINAL)
    oracle = oracle_of(PAPER)
    assert point.omega == pytest.approx(
        point.speed + torque_on_bit(oracle, NOMINAL, point.speed) / PAPER.c_a, rel=1e-14
    )
    assert point.slope == pytest.approx(slope_of_torque(oracle, NOMINAL, point.speed), rel=1e-12)
    assert abs(exactly(PAPER, point.slope, 1j * point.frequency) - 1j * point.frequency) < 1e-13


def test_where_there_is_no_critical_value_it_says_so():
    with pytest.raises(ValueError, match=r"stable at every Omega at WOB = 1000.0 N.*expected more than 69.93"):
        critical_omega(PAPER, 1000.0)
    with pytest.raises(ValueError, match="WOB is nan"):
        critical_omega(PAPER, math.nan)
    with pytest.raises(ValueError, match="WOB is -1"):
        critical_omega(PAPER, -1.0)
    with pytest.raises(ValueError, match="stable up to WOB"):
        critical_wob(PAPER, 0.1)
    with pytest.raises(ValueError, match="does not fall"):
        critical_wob(replace(PAPER, mu_sb=0.5), 10.0)
    with pytest.raises(ValueError, match="count is 0"):
        rightmost_roots(PAPER, 10.0, NOMINAL, 0)
    with pytest.raises(ValueError, match=r"no running equilibrium at Omega = 5.0 rad/s.*> 5.69195"):
        rightmost_roots(PAPER, 5.0, NOMINAL, 1)
    with pytest.raises(ValueError, match="bit is stuck"):
        roots_about(PAPER, equilibria(PAPER, 5.0, NOMINAL)[0], 1)
