"""Loops close where a solution exists, whatever their gain, and are said not to where none does."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cosim.master.coupled_loop import LoopSolver
from cosim.master.root_finding import UnsolvedError

TOLERANCE = 1e-10


def solver(unknowns: int = 1, low: float = -1e6, high: float = 1e6, tolerance: float = TOLERANCE) -> LoopSolver:
    return LoopSolver(np.full(unknowns, low), np.full(unknowns, high), tolerance)


def scalar(function):
    """Turn an answer to one value into a residual, and record the calls."""
    calls: list[float] = []

    def residual(values):
        calls.append(float(values[0]))
        return np.array([function(float(values[0])) - float(values[0])])

    return residual, calls


@pytest.mark.parametrize("gain", [0.0, 0.5, 0.99, 1.5, 4.0, 100.0, -0.5, -1.0, -3.0, -100.0])
def test_a_linear_loop_of_any_gain_but_one_closes_in_three_trials(gain: float) -> None:
    residual, calls = scalar(lambda x: gain * x + 1.0)
    values, trials = solver().solve(residual, np.array([0.3]))
    assert values[0] == pytest.approx(1.0 / (1.0 - gain), rel=1e-9)
    assert trials <= 3
    assert calls[-1] == values[0]


def test_what_was_learned_serves_the_next_step() -> None:
    loop = solver()
    for step in range(5):
        residual, _ = scalar(lambda x, step=step: -3.0 * x + math.sin(step))
        _, trials = loop.solve(residual, np.array([1.0]))
        assert trials == (3 if step == 0 else 2)


@pytest.mark.parametrize("unknowns", [2, 3, 6])
@pytest.mark.parametrize("radius", [0.5, 1.5, 4.0])
def test_a_linear_loop_of_several_unknowns_closes_in_two_trials_more_and_the_next_step_in_two(
    unknowns: int, radius: float
) -> None:
    generator = np.random.default_rng(unknowns)
    matrix = generator.normal(size=(unknowns, unknowns))
    matrix *= radius / np.abs(np.linalg.eigvals(matrix)).max()
    loop = solver(unknowns)
    for step in range(1, 10):
        source = np.sin(0.3 * step * np.arange(1, unknowns + 1))
        values, trials = loop.solve(lambda x, source=source: matrix @ x + source - x, np.zeros(unknowns))
        assert values == pytest.approx(np.linalg.solve(np.eye(unknowns) - matrix, source), abs=1e-8)
        assert trials <= (unknowns + 2 if step == 1 else 2)


KINKED = [
    (lambda x: 2.0 - 3.0 * x if x > 1.0 else 5.0 - 6.0 * x, 5.0 / 7.0),
    (lambda x: max(-40.0, min(40.0, 1000.0 * (0.5 - x))), 500.0 / 1001.0),
    (lambda x: -math.copysign(math.sqrt(abs(x)), x) - 1.0, -0.3819660112501051),
    (lambda x: -20.0 * math.atan(50.0 * (x - 3.0)), None),
    (lambda x: 10.0 - math.exp(2.0 * x), None),
    (lambda x: x + 1e-3 * (x - 17.0) ** 3, None),
]


@pytest.mark.parametrize(("function", "root"), KINKED)
@pytest.mark.parametrize("start", [-30.0, 0.0, 0.9, 25.0])
def test_a_continuous_loop_that_bends_closes(function, root: float | None, start: float) -> None:
    residual, calls = scalar(function)
    values, trials = solver().solve(residual, np.array([start]))
    assert function(values[0]) == pytest.approx(values[0], abs=2e-10 * max(1.0, abs(values[0])))
    if root is not None:
        assert values[0] == pytest.approx(root, abs=1e-3)
    assert calls[-1] == values[0]
    assert trials < 100


def test_a_loop_of_several_unknowns_that_bends_closes() -> None:
    def residual(x):
        return np.array([5.0 - 3.0 * max(x[1], 0.5 * x[1]) - 2.0 * x[0], np.arctan(10.0 * (x[0] - 1.0)) - x[1]]) - x

    values, _ = solver(2).solve(residual, np.array([-8.0, 9.0]))
    assert np.abs(residual(values)).max() < 2e-10 * max(1.0, np.abs(values).max())


def test_a_jump_across_the_loop_is_found_and_not_taken_for_a_solution() -> None:
    residual, _ = scalar(lambda x: 40.0 if x < 2.5 else -40.0)
    with pytest.raises(UnsolvedError) as caught:
        solver().solve(residual, np.array([0.0]))
    assert caught.value.jump is not None
    below, above = caught.value.jump
    assert below.values[0] <= 2.5 <= above.values[0]
    assert above.values[0] - below.values[0] < 1e-6
    assert (below.residual[0], above.residual[0]) == pytest.approx((37.5, -42.5))
    assert caught.value.best.miss >= 37.0
    assert caught.value.trials < 100


@settings(max_examples=200, deadline=None)
@example(k=1.0, part=0.5, side=-1.0, start=2.225073858507e-311)  # the answer to it overflows
@example(k=1.0, part=0.5, side=1.0, start=0.0)
@example(k=1.0, part=0.5, side=1.0, start=2.3e-308)  # its square does
@given(st.floats(0.05, 50.0), st.floats(1e-4, 0.999), st.sampled_from([-1.0, 1.0]), st.floats(-30.0, 30.0))
def test_two_roots_on_one_side_of_a_pole_are_not_missed(k: float, part: float, side: float, start: float) -> None:
    """x = s (k - c / (s x)) has two roots on one side of zero where c < k^2 / 4, and none where c is greater."""
    c = part * k * k / 4.0
    residual, calls = scalar(lambda x: side * (k - c / (side * x)) if x else math.inf)
    values, _ = solver().solve(residual, np.array([start]))
    roots = side * 0.5 * k * (1.0 + np.array([-1.0, 1.0]) * math.sqrt(1.0 - part))
    assert np.abs(values[0] - roots).min() <= 1e-8 * max(1.0, k) / math.sqrt(1.0 - part)
    assert calls[-1] == values[0]


@pytest.mark.parametrize("start", [-3.0, 0.2, 7.0])
def test_a_pole_without_a_root_on_either_side_is_told_as_such(start: float) -> None:
    residual, _ = scalar(lambda x: 4.0 - 4.1 / x if x else math.inf)
    with pytest.raises(UnsolvedError) as caught:
        solver().solve(residual, np.array([start]))
    assert caught.value.jump is not None
    assert abs(caught.value.jump[0].values[0]) < 1e-6
    assert caught.value.trials < 200


def test_a_loop_without_a_root_is_told_with_its_least_residual() -> None:
    residual, _ = scalar(lambda x: x * x + 1.0 + x)
    with pytest.raises(UnsolvedError) as caught:
        solver().solve(residual, np.array([3.0]))
    assert caught.value.jump is None
    assert caught.value.best.miss >= 1.0
    assert caught.value.trials < 100


def test_several_unknowns_without_a_root_are_told() -> None:
    with pytest.raises(UnsolvedError) as caught:
        solver(2).solve(lambda x: np.array([x[0] ** 2 + x[1] ** 2 + 1.0, x[0] - x[1]]), np.array([3.0, 1.0]))
    assert caught.value.best.miss >= 1.0


def test_no_value_beyond_the_bounds_is_ever_tried() -> None:
    residual, calls = scalar(lambda x: -50.0 * x + 3.0)
    with pytest.raises(UnsolvedError):
        solver(low=1.0, high=2.0).solve(residual, np.array([1.5]))
    assert all(1.0 <= x <= 2.0 for x in calls)


def test_values_that_are_refused_are_approached_again() -> None:
    residual, _ = scalar(lambda x: 1.0 + 3.0 * x - 0.8 * x * x if x < 4.5 else math.nan)
    values, _ = solver().solve(residual, np.array([2.0]))
    assert 1.0 + 3.0 * values[0] - 0.8 * values[0] ** 2 == pytest.approx(values[0], abs=1e-9)


def test_a_start_that_is_refused_is_told() -> None:
    with pytest.raises(UnsolvedError) as caught:
        solver().solve(lambda x: np.full(1, np.nan), np.array([0.0]))
    assert not caught.value.best.answered
