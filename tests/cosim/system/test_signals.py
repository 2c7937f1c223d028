from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cosim.errors import ScenarioError
from cosim.system.signals import Constant, FloatArray, Signal, Step, Table, ramp
from cosim.system.table_file import read_table


def test_a_step_has_its_new_value_at_the_jump_and_its_old_value_to_the_left() -> None:
    signal = Step(1.0, 2.0, at=0.5)
    times = np.array([0.0, 0.5, 1.0])
    assert signal.values(times).tolist() == [1.0, 2.0, 2.0]
    assert signal.left_values(times).tolist() == [1.0, 1.0, 2.0]
    assert signal.breakpoints == (0.5,)


def test_a_table_is_straight_between_points_jumps_where_a_time_repeats_and_is_held_outside() -> None:
    signal = Table((1.0, 2.0, 2.0, 4.0), (0.0, 10.0, 20.0, 0.0))
    times = np.array([0.0, 1.0, 1.25, 2.0, 3.0, 4.0, 9.0])
    assert signal.values(times).tolist() == [0.0, 0.0, 2.5, 20.0, 10.0, 0.0, 0.0]
    assert signal.left_values(times).tolist() == [0.0, 0.0, 2.5, 10.0, 10.0, 0.0, 0.0]
    assert signal.slopes(times).tolist() == [0.0, 10.0, 10.0, -10.0, -10.0, 0.0, 0.0]
    assert signal.breakpoints == (1.0, 2.0, 4.0)


def test_a_jump_at_either_end_of_a_table_is_a_jump() -> None:
    signal = Table((1.0, 1.0, 2.0, 2.0), (0.0, 1.0, 1.0, 5.0))
    times = np.array([1.0, 2.0])
    assert signal.values(times).tolist() == [1.0, 5.0]
    assert signal.left_values(times).tolist() == [0.0, 1.0]


def test_a_ramp_of_no_duration_is_a_step() -> None:
    assert ramp(1.0, 2.0, 3.0, 0.0) == Step(1.0, 2.0, 3.0)


def test_a_constant_keeps_its_type() -> None:
    assert Constant(True).values(np.zeros(2)).dtype == np.bool_
    assert Constant(3).values(np.zeros(2)).dtype.kind == "i"


@pytest.mark.parametrize(
    ("times", "points", "message"),
    [
        ((0.0, 2.0, 1.0), (0.0, 0.0, 0.0), "must not decrease"),
        ((0.0, 0.0, 0.0), (0.0, 1.0, 2.0), "more than twice"),
        ((0.0, 1.0), (0.0,), "1 values at 2 times"),
        ((), (), "at least one"),
        ((0.0, float("nan")), (0.0, 1.0), "not finite"),
    ],
)
def test_a_table_that_is_no_function_is_refused(times: tuple, points: tuple, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        Table(times, points)


def test_a_table_comes_from_the_named_column_of_a_csv_file(tmp_path: Path) -> None:
    path = tmp_path / "program.csv"
    path.write_text("time, speed, WOB\n0, 10, 1e5\n5, 12, 2e5\n")
    assert read_table(path, "WOB") == Table((0.0, 5.0), (1e5, 2e5))
    assert read_table(path) == Table((0.0, 5.0), (10.0, 12.0))
    with pytest.raises(ScenarioError, match="there is no column 'wob'; known: speed, WOB"):
        read_table(path, "wob")
    path.write_text("time,speed\n0,10\n5,twelve\n")
    with pytest.raises(ScenarioError, match="line 3: 'twelve' is not a number"):
        read_table(path)
    with pytest.raises(ScenarioError, match=r"absent\.csv: cannot be read"):
        read_table(tmp_path / "absent.csv")


def test_a_ramp_is_its_table_to_the_bit_and_keeps_what_it_is_made_from() -> None:
    signal, line = ramp(1.0, 4.0, 0.1, 0.7), Table((0.1, 0.1 + 0.7), (1.0, 4.0))
    times = np.linspace(-0.1, 1.0, 1001)
    for name in ("values", "left_values", "slopes"):
        assert getattr(signal, name)(times).tobytes() == getattr(line, name)(times).tobytes()
    assert signal.breakpoints == line.breakpoints
    assert signal.record() == {"kind": "ramp", "initial": 1.0, "final": 4.0, "start": 0.1, "duration": 0.7}
    assert not signal.is_level
    assert ramp(1.0, 1.0, 0.1, 0.7).is_level


@pytest.mark.parametrize("numbers", [(0.0, 1.0, 0.0, -1.0), (0.0, 1.0, 0.0, np.nan), (0.0, np.inf, 0.0, 0.0)])
def test_a_ramp_that_is_no_function_is_refused(numbers: tuple[float, float, float, float]) -> None:
    with pytest.raises(ScenarioError, match=r"^ramp: "):
        ramp(*numbers)


@pytest.mark.parametrize(
    "signal", [Constant(3), Step(False, True, 0.5), ramp(0.0, 1.0, 2.0, 3.0), Table((0.0,), (1.0,))]
)
def test_a_signal_is_made_again_of_what_it_records(signal: Signal) -> None:
    record = signal.record()
    assert record.pop("kind") == type(signal).__name__.lower()
    assert type(signal)(**record) == signal


class Wave(Signal):
    """A sine."""

    kind = "wave"

    @property
    def breakpoints(self) -> tuple[float, ...]:
        return ()

    def values(self, times: FloatArray) -> FloatArray:
        return np.sin(times)

    def left_values(self, times: FloatArray) -> FloatArray:
        return np.sin(times)

    def slopes(self, times: FloatArray) -> FloatArray:
        return np.cos(times)


def test_a_signal_of_ones_own_may_have_any_value_and_never_stands_for_a_constant() -> None:
    signal = Wave()
    assert (signal.levels, signal.held, signal.change, signal.is_level) == (None, None, None, False)
    assert signal.record() == {"kind": "wave"}
