"""Names as exporters choose them, in every format with delimiters: what is written reads back under its own name."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from cosim import Result, open_trajectory
from cosim.recording.result import Column, Rows
from cosim.run.store import create_csv, csv_file, decimate
from cosim.run.zarr_layout import array_name
from cosim.run.zarr_store import create_zarr

NAMES = (
    "a.m[1,2]",
    'a.the "real" one',
    "a.b/c",
    "a.b%2Fc",
    "a.100 %",
    "a.x\\y",
    "a.per cent; semi:colon*?",
    "a.über.größe",
    "a." + "long" * 75,
    "a." + "long" * 75 + "er",
    "a." + "ä" * 150,
    ".hidden",
)
TIMES = np.array([0.0, 0.5, 1.0])
VALUES = {name: np.arange(3.0) + 10.0 * place for place, name in enumerate(NAMES)}
COLUMNS = tuple(Column(name, "", np.dtype(np.float64)) for name in NAMES)


def test_a_csv_reader_gets_each_name_and_as_many_values(tmp_path: Path) -> None:
    Result(TIMES, dict(VALUES), {}).to_csv(tmp_path / "a.csv")
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    assert head == ["time", *NAMES]
    assert [[float(text) for text in row] for row in rows] == [
        [t, *column] for t, *column in zip(TIMES, *VALUES.values(), strict=True)
    ]


def test_a_streamed_csv_has_the_same_head(tmp_path: Path) -> None:
    store = create_csv(tmp_path, {1: COLUMNS})
    store.take(Rows(0, TIMES, VALUES))
    store.close({})
    Result(TIMES, dict(VALUES), {}).to_csv(tmp_path / "a.csv")
    assert csv_file(tmp_path, 1).read_bytes() == (tmp_path / "a.csv").read_bytes()


def test_zarr_gives_back_every_name(tmp_path: Path) -> None:
    store = create_zarr(tmp_path / "trajectory.zarr", {1: COLUMNS}, {})
    store.take(Rows(0, TIMES, VALUES))
    store.close({})
    with open_trajectory(tmp_path) as read:
        assert set(read.data_vars) == set(NAMES)
        assert all(read[name].values.tolist() == VALUES[name].tolist() for name in NAMES)


def test_no_two_names_share_an_array() -> None:
    assert len({array_name(name).casefold() for name in NAMES}) == len(NAMES)
    assert all(len(array_name(name).encode()) <= 255 for name in NAMES)
    assert not any(set(array_name(name)) & set("/\\:*?<>|") for name in NAMES)


@pytest.mark.parametrize("order", [("a.m[1,2]", "a.m*", "a.*"), ("a.*", "a.m*", "a.m[1,2]")])
def test_what_is_a_name_is_no_pattern(order: tuple[str, ...]) -> None:
    strides = {"a.m[1,2]": 2, "a.m*": 3, "a.*": 5}
    columns = tuple(Column(name, "", np.dtype(np.float64)) for name in ("a.m[1,2]", "a.m1", "a.n"))
    chosen = decimate(columns, {pattern: strides[pattern] for pattern in order})
    assert [column.name for column in chosen[2]] == ["a.m[1,2]"]
