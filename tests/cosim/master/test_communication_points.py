from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cosim.errors import InputError
from cosim.master.communication_points import communication_points


def test_times_are_start_plus_k_steps_and_never_a_sum_of_steps() -> None:
    points = communication_points(0.0, 100.0, 0.01, (), can_vary_step=True).points()
    assert points.times.tolist() == [k * 0.01 for k in range(10001)]
    assert set(points.sizes[:-1].tolist()) == {0.01}
    assert np.cumsum(np.full(10000, 0.01))[-1] != points.times[-1], "a sum of steps would have drifted"


def test_breakpoints_become_communication_points_where_steps_can_vary() -> None:
    grid = communication_points(0.0, 1.0, 0.25, (0.3, 0.9, 2.0, -1.0), can_vary_step=True)
    points = grid.points()
    assert points.times.tolist() == [0.0, 0.25, 0.3, 0.5, 0.75, 0.9, 1.0]
    assert points.sizes == pytest.approx([0.25, 0.05, 0.2, 0.25, 0.15, 0.1])
    assert grid.missed == ()


def test_breakpoints_are_reported_as_missed_where_steps_are_fixed() -> None:
    grid = communication_points(0.0, 1.0, 0.25, (0.3, 0.5), can_vary_step=False)
    points = grid.points()
    assert points.times.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert grid.missed == (0.3,)


def test_a_breakpoint_within_rounding_of_a_regular_point_is_that_point() -> None:
    jump = 0.3
    points = communication_points(0.0, 1.0, 0.1, (jump,), can_vary_step=True).points()
    assert points.times[3] == 3 * 0.1 != jump
    assert points.times.size == 11
    assert points.signal_times[3] == jump


def test_a_stop_time_between_steps_is_reached_by_a_shorter_last_step() -> None:
    points = communication_points(0.0, 1.1, 0.25, (), can_vary_step=True).points()
    assert points.times.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0, 1.1]
    points = communication_points(0.0, 0.1, 0.25, (), can_vary_step=True).points()
    assert points.times.tolist() == [0.0, 0.1]


def test_a_stop_time_between_fixed_steps_is_refused() -> None:
    with pytest.raises(InputError, match=r"stop time 1\.1 s is not a whole number of steps of 0\.25 s"):
        communication_points(0.0, 1.1, 0.25, (), can_vary_step=False)


@pytest.mark.parametrize(
    ("start", "stop", "step", "message"),
    [
        (0.0, 1.0, 0.0, "step size is 0 s; expected a number > 0"),
        (0.0, 1.0, -0.1, "step size is -0.1 s"),
        (0.0, 1.0, float("nan"), "step size is nan s; expected a finite number"),
        (0.0, float("inf"), 0.1, "stop time is inf s"),
        (1.0, 1.0, 0.1, "stop time is 1 s; expected a time after the start"),
    ],
)
def test_times_that_no_run_can_have_are_refused(start: float, stop: float, step: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        communication_points(start, stop, step, (), can_vary_step=True)


@given(
    st.floats(0.1, 50),
    st.floats(0.01, 5),
    st.lists(st.floats(0, 50) | st.integers(0, 100).map(lambda k: 0.25 * k), max_size=5),
    st.booleans(),
    st.data(),
)
def test_a_stretch_of_points_is_that_part_of_them_all(
    stop: float, step: float, breakpoints: list[float], vary: bool, data: st.DataObject
) -> None:
    grid = communication_points(0.0, stop if vary else step * math.ceil(stop / step), step, breakpoints, vary)
    first = data.draw(st.integers(0, grid.steps))
    last = data.draw(st.integers(first, grid.steps))
    part, whole = grid.points(first, last), grid.points()
    assert part.times.tobytes() == whole.times[first : last + 1].tobytes()
    assert part.sizes.tobytes() == whole.sizes[first:last].tobytes()
    assert part.signal_times.tobytes() == whole.signal_times[first : last + 1].tobytes()
    assert grid.end == whole.times[-1]
    assert all(grid.after(missed) == whole.times[whole.times >= missed][0] for missed in grid.missed)


def test_far_points_are_found_without_those_before_them() -> None:
    grid = communication_points(0.0, 1e9, 1e-3, (5e8 + 0.0005,), can_vary_step=True)
    assert grid.steps == 10**12 + 1
    assert grid.points(5 * 10**11, 5 * 10**11 + 2).times.tolist() == [5e8, 5e8 + 0.0005, 500000000.001]


@given(
    st.floats(-100, 100), st.floats(0.1, 50), st.floats(0.01, 5), st.lists(st.floats(-100, 150), max_size=5)
)  # fmt: skip
def test_points_increase_from_start_to_stop_and_each_step_leads_to_the_next(
    start: float, duration: float, step: float, breakpoints: list[float]
) -> None:
    points = communication_points(start, start + duration, step, breakpoints, can_vary_step=True).points()
    assert points.times[0] == start
    assert points.times[-1] == pytest.approx(start + duration, abs=1e-5 * step)
    assert (np.diff(points.times) > 0).all()
    assert points.times[:-1] + points.sizes == pytest.approx(points.times[1:], abs=1e-9)
    for point in breakpoints:
        if start < point < start + duration:
            assert np.abs(points.signal_times - point).min() <= 2e-6 * step


USUAL = [
    (stop, step) for stop in (1.0, 5.0, 10.0, 20.0, 60.0, 100.0, 500.0) for step in (0.1, 0.05, 0.01, 0.005, 0.001)
]


def test_usual_runs_would_end_beyond_their_stop_time() -> None:
    """So that the next test cannot pass for nothing."""
    beyond = [(stop, step) for stop, step in USUAL if (round(stop / step) - 1) * step + step > stop]
    assert len(beyond) > 5
    assert (100.0, 0.01) in beyond


@pytest.mark.parametrize(("stop", "step"), USUAL)
def test_no_step_ends_beyond_the_stop_time_by_any_bit(stop: float, step: float) -> None:
    points = communication_points(0.0, stop, step, (), can_vary_step=False).points()
    assert (points.times[:-1] + points.sizes <= points.times[-1]).all()
    assert np.abs(points.sizes - step).max() <= 4 * np.spacing(stop)
    assert (points.sizes[:-1] == step).all()


@given(st.floats(-10, 10), st.floats(1e-3, 100), st.integers(1, 2000), st.booleans())
def test_the_last_step_of_any_run_stays_within_it(start: float, step: float, count: int, vary: bool) -> None:
    grid = communication_points(start, start + count * step, step, (), vary)
    points = grid.points()
    assert points.times[-2] + points.sizes[-1] <= points.times[-1]
    assert abs(points.sizes[-1] - np.diff(points.times)[-1]) <= 4 * np.spacing(np.abs(points.times).max())
