"""Formal and strong stability, against polynomial roots, closed forms and difference equations that are run."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from models.theory.stability.difference import DifferenceOperator
from models.theory.stability.neutral_form import neutral_form
from tests.theory.strings import PAPER, STRINGS


@pytest.mark.parametrize("name", STRINGS)
def test_drillstring_is_formally_stable_with_the_margin_of_its_reflection(name):
    """Eq. (21): det = 1 - Upsilon^2 exp(-4 Gamma s); the coupling E_1 does not matter, to strong stability neither."""
    parameters = STRINGS[name]
    operator, upsilon = neutral_form(parameters).difference, abs(parameters.reflection)
    assert operator.formally_stable
    assert operator.radius == pytest.approx(math.sqrt(upsilon), rel=1e-12)
    assert operator.margin == pytest.approx(1 - math.sqrt(upsilon), rel=1e-10)
    assert operator.abscissa == pytest.approx(math.log(upsilon) / (2 * parameters.travel_time), rel=1e-10)
    assert operator.strong_radius == pytest.approx(upsilon, rel=1e-9)
    assert operator.strongly_stable


def test_rank_condition_holds_to_the_right_of_the_chain_and_fails_on_it():
    operator, period = neutral_form(PAPER).difference, 2 * math.pi / (4 * PAPER.travel_time)
    for number in range(8):
        on_chain = complex(operator.abscissa, number * period)
        expected = (on_chain - 1e-3, on_chain, on_chain + 1e-3)
        lost = [np.linalg.svd(operator.matrix(s), compute_uv=False)[-1] for s in expected]
        assert lost[1] < 1e-14
        assert min(lost[0], lost[2]) > 1e-5


def test_top_that_gives_no_torque_or_turns_rigidly_has_no_margin():
    for sliding in (1e-9, 1e14):
        assert neutral_form(replace(PAPER, c_a=sliding)).difference.margin == pytest.approx(0, abs=1e-11)


coefficients = st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=6).filter(lambda c: abs(c[-1]) > 1e-3)


@given(coefficients)
@settings(max_examples=150, deadline=None)
def test_scalar_operators_are_stable_as_their_polynomials_are(numbers):
    roots = np.roots([-number for number in numbers[::-1]] + [1.0])
    assert DifferenceOperator.of(0.5, numbers).radius == pytest.approx(1 / np.abs(roots).min(), rel=1e-6)


@given(st.integers(0, 10_000), st.integers(1, 3), st.integers(1, 3))
@settings(max_examples=60, deadline=None)
def test_matrix_operators_are_stable_as_their_determinants_are(seed, size, count):
    matrices = np.random.default_rng(seed).normal(size=(count, size, size)) / 2
    degree = size * count
    points = np.exp(2j * np.pi * np.arange(degree + 1) / (degree + 1))
    powers = points[:, None] ** np.arange(1, count + 1)
    values = np.linalg.det(np.eye(size) - np.tensordot(powers, matrices, 1))
    determinant = np.fft.fft(values).real / (degree + 1)  # coefficients of 1, z, z^2, ...
    roots = np.roots(determinant[::-1])
    operator = DifferenceOperator.of(2.0, matrices)
    assert operator.radius == pytest.approx(1 / np.abs(roots).min(), rel=1e-6)
    assert operator.abscissa == pytest.approx(math.log(operator.radius) / 2.0)


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=4))
@settings(max_examples=25, deadline=None)
def test_strong_radius_of_numbers_is_the_sum_of_their_sizes(numbers):
    operator = DifferenceOperator.of(1.0, numbers)
    assert operator.strong_radius == pytest.approx(sum(map(abs, numbers)), abs=1e-7)
    assert operator.strong_radius <= operator.strong_bound + 1e-12


@given(st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_strong_stability_is_never_claimed_without_formal_stability(seed):
    random = np.random.default_rng(seed)
    operator = DifferenceOperator.of(1.0, random.normal(size=(2, 2, 2)) * 0.5)
    assert operator.strong_radius < 1.0 or not operator.strongly_stable
    if not operator.formally_stable:
        assert operator.strong_radius >= 1.0 - 1e-6


def test_formal_stability_can_hang_on_the_ratio_of_delays_where_strong_stability_is_missing():
    """x(t) = -0.6 x(t - 1) - 0.6 x(t - r): it decays for r = 2, and grows for r = 2.05, as one sees by running it."""
    exact = DifferenceOperator.of(1.0, [-0.6, -0.6])
    detuned = DifferenceOperator.of(0.05, [0.0] * 19 + [-0.6] + [0.0] * 20 + [-0.6])
    assert exact.strong_radius == pytest.approx(1.2)
    assert exact.formally_stable
    assert not exact.strongly_stable
    assert not detuned.formally_stable
    rates = []
    for long in (40, 41):
        past = list(np.random.default_rng(1).normal(size=41))
        for _ in range(12_000):
            past.append(-0.6 * past[-20] - 0.6 * past[-long])
        sizes = [np.abs(past[start : start + 2000]).max() for start in (2000, 10_000)]
        rates.append(math.log(sizes[1] / sizes[0]) / (8000 * 0.05) if sizes[1] else -math.inf)
    assert rates[0] < 0 < rates[1]
    assert rates[1] == pytest.approx(detuned.abscissa, rel=0.05)


@pytest.mark.parametrize(
    ("delay", "matrices", "message"),
    [
        (0.0, [1.0], "delay is 0.0 s"),
        (1.0, [], "no matrix was given"),
        (1.0, [[[1.0, 2.0]]], "E_1 is"),
        (1.0, [0.5, [[1.0, 0.0], [0.0, 1.0]]], "E_2 is"),
        (1.0, [math.nan], "E_1 is"),
    ],
)
def test_what_is_no_difference_operator_is_refused(delay, matrices, message):
    with pytest.raises(ValueError, match=message):
        DifferenceOperator.of(delay, matrices)
