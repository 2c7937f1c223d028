"""Tables of what is not Real: whole numbers, Booleans, items and texts hold until the next, from files and in place."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cosim import Component, System, load_scenario, read_column, read_table, simulate
from cosim.errors import InputError, ScenarioError, SystemDefinitionError
from cosim.system.description import Variable
from cosim.system.field_units import in_declared_units
from cosim.system.signals import Signal, Table
from cosim.system.staircase import Staircase
from tests.cosim.fakes import describe

MODES = {"slow": 1, "fast": 2, "7": 7, "none": 9}
VARIABLES = (
    Variable("n", 0, "Integer", "input", "discrete", start="0", maximum=50.0),
    Variable("b", 1, "Boolean", "input", "discrete", start="false"),
    Variable("e", 2, "Enumeration", "input", "discrete", start="1", items=MODES),
    Variable("s", 3, "String", "input", "discrete", start=""),
    Variable("r", 4, "Real", "input", "discrete", start="0"),
)
Written = Callable[[str], Path]


@pytest.fixture
def written(tmp_path: Path) -> Written:
    def write(text: str) -> Path:
        path = tmp_path / "log.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def driving(variable: str, signal: Signal) -> Signal:
    """Return what a signal becomes at a variable."""
    system = System((Component("a", "fake"),), inputs={f"a.{variable}": signal})
    return in_declared_units(system, {"a": describe(extra=VARIABLES)}).inputs[f"a.{variable}"]


@pytest.mark.parametrize(
    ("variable", "cells", "levels"),
    [
        ("n", ("3", "4.0", "5e0"), (3, 4, 5)),
        ("b", ("true", "FALSE", "1"), (True, False, True)),
        ("b", ("0", "1", "0.0"), (False, True, False)),
        ("e", ("fast", "1", "slow"), (2, 1, 1)),
        ("e", ("none", "7", "2.0"), (9, 7, 2)),
        ("s", ("007", "A12", "nan"), ("007", "A12", "nan")),
        ("s", ("1", "2", "3"), ("1", "2", "3")),
    ],
)
def test_cells_are_read_by_the_type_of_what_they_drive(
    written: Written, variable: str, cells: tuple[str, ...], levels: tuple[object, ...]
) -> None:
    rows = "".join(f"{time},{cell}\n" for time, cell in enumerate(cells))
    column = read_column(written(f"time,value\n{rows}"), "value")
    assert driving(variable, column) == Staircase((0.0, 1.0, 2.0), levels)  # type: ignore[arg-type]


def test_a_table_of_numbers_from_a_file_may_drive_a_string(written: Written) -> None:
    table = read_table(written("time,well\n0,007\n1,12\n"))
    assert table == Table((0.0, 1.0), (7.0, 12.0))
    assert driving("s", table) == Staircase((0.0, 1.0), ("007", "12"))
    assert driving("s", pickle.loads(pickle.dumps(table))) == driving("s", copy.deepcopy(table))


def test_levels_hold_until_the_next_and_change_where_they_differ() -> None:
    stairs = Staircase((1.0, 2.0, 2.0, 3.0, 4.0), ("a", "b", "c", "c", "d"))
    times = np.array([0.0, 1.0, 1.9, 2.0, 3.9, 4.0, 9.0])
    assert stairs.values(times).tolist() == ["a", "a", "a", "c", "c", "d", "d"]
    assert stairs.left_values(times).tolist() == ["a", "a", "a", "a", "c", "c", "d"]
    assert stairs.breakpoints == (2.0, 4.0)
    assert stairs.levels == ("a", "b", "c", "d")
    assert (stairs.held, Staircase((0.0, 1.0), (5, 5)).held) == (None, 5)


@pytest.mark.parametrize(
    ("variable", "cell", "message"),
    [
        ("n", "2.5", r"log\.csv, line 3: a\.n is '2\.5'; expected an integer"),
        ("n", "51", r"log\.csv, line 3: a\.n is 51; expected a finite number .*<= 50"),
        ("b", "yes", r"log\.csv, line 3: a\.b is 'yes'; expected true or false"),
        ("e", "brisk", r"log\.csv, line 3: a\.e is 'brisk'; expected one of 'slow' \(1\), 'fast' \(2\)"),
        ("r", "brisk", r"log\.csv, line 3: 'brisk' is not a number"),
        ("n", "", "log\\.csv, line 3: '' is not a value; gaps = \"hold\" goes on over 1 missing value"),
        ("s", "", "log\\.csv, line 3: '' is not a value"),
    ],
)
def test_a_cell_that_is_none_of_its_type_is_refused_by_file_and_line(
    written: Written, variable: str, cell: str, message: str
) -> None:
    column = read_column(written(f"time,value\n0,1\n1,{cell}\n2,1\n"), "value")
    with pytest.raises(InputError, match=message):
        driving(variable, column)


def test_what_is_for_numbers_is_refused_for_others(written: Written) -> None:
    path = written("time,value\n0,1\n1,\n2,3\n")
    assert driving("n", read_column(path, gaps="hold")) == Staircase((0.0, 1.0, 2.0), (1, 1, 3))
    with pytest.raises(ScenarioError, match=r"gaps is 'interpolate', but a\.n is Integer; expected 'hold'"):
        driving("n", read_column(path, gaps="interpolate"))
    with pytest.raises(ScenarioError, match=r"factor is 2, but a\.n is Integer; expected none"):
        driving("n", read_column(path, factor=2.0))
    with pytest.raises(SystemDefinitionError, match=r"a\.n is a table in rpm, but is not Real; expected no unit"):
        driving("n", Table((0.0,), (1.0,), "rpm"))


POINTS = """
stop_time = 1.0
step_size = 0.25
[components.a]
fmu = "{fmu}"
[inputs]
"a.u" = 0.5
"a.v" = 0.0
"a.n" = {n}
"a.flag" = {flag}
"""
NUMBERS = '{ kind = "table", points = [[0, 3], [0.5, 4]] }'
FLAGS = '{ kind = "table", points = [[0, true], [0.6, false]] }'


@pytest.mark.parametrize("options", [{}, {"algorithm": "implicit"}, {"isolate": True}])
def test_an_fmu_is_given_the_levels_of_points_and_files(
    probe: Path, tmp_path: Path, options: dict[str, object]
) -> None:
    (tmp_path / "log.csv").write_text("time;n;flag\n0;3;true\n0,5;4;true\n0,6;4;false\n")
    files = ['{ kind = "table", file = "log.csv", column = "%s", decimal = "," }' % name for name in ("n", "flag")]  # noqa: UP031
    found: list[list[list[float]]] = []
    for n, flag in ((NUMBERS, FLAGS), files):
        path = tmp_path / "levels.toml"
        path.write_text(POINTS.format(fmu=probe, n=n, flag=flag))
        result = simulate(load_scenario(path), **options)  # type: ignore[arg-type]
        assert result.time.tolist() == [0.0, 0.25, 0.5, 0.6, 0.75, 1.0]
        found.append([result["a.n_next"].tolist(), result["a.flag"].tolist()])
        assert result.record["inputs"]["a.n"]["kind"] == "table"
    assert found[0] == found[1]
    assert found[0][0] == [0, 4, 4, 5, 5, 5]  # 0 before the first step; what was set at the beginning of each, plus 1
    assert found[0][1] == [True, True, True, True, False, False]


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ("[[0, 3], [0.5, true]]", r"inputs\.a\.n: table: points hold 3 and True; expected values of one type"),
        ("[[0, 3], [0.5, 3.5]]", r"a\.n is 3\.5; expected an integer"),
        ('[[0, "three"]]', r"a\.n is 'three'; expected an integer"),
        ("[[true, 3]]", r"inputs\.a\.n: points hold \[True, 3\]; expected pairs of a time in s and a value"),
        ('[[0, "3"]], factor = 2', r"inputs\.a\.n: factor is for numbers; expected points without it"),
    ],
)
def test_points_that_do_not_fit_are_refused(probe: Path, tmp_path: Path, points: str, message: str) -> None:
    path = tmp_path / "levels.toml"
    signal = f'{{ kind = "table", points = {points} }}'
    path.write_text(POINTS.format(fmu=probe, n=signal, flag="true"))
    with pytest.raises(InputError, match=message):
        simulate(load_scenario(path))


def test_points_with_units_are_a_table_with_lines(tmp_path: Path) -> None:
    path = tmp_path / "field.toml"
    points = '{ kind = "table", points = [[0, "60 rpm"], [4, "120 rpm"]] }'
    path.write_text(
        'stop_time = 2\nstep_size = 1\n[components.plant]\nfmu = "DrillstringNeutral"\n'
        f'[inputs]\n"plant.Omega" = {points}\n'
    )
    turn = 2.0 * np.pi
    assert simulate(path)["plant.Omega"].tolist() == pytest.approx([turn, 1.25 * turn, 1.5 * turn], rel=1e-15)
