"""Stores of streamed trajectories: what comes back is what was taken, however it was cut, and wherever it was left."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.errors import CheckpointError, InputError, OutputError
from cosim.master.run import Snapshot
from cosim.recording.result import Column, Rows
from cosim.run import zarr_layout, zarr_store
from cosim.run.checkpoint import read_checkpoint, write_checkpoint
from cosim.run.store import create_csv, csv_file, decimate, reopen_csv
from cosim.run.zarr_store import create_zarr, reopen_zarr

COLUMNS = (
    Column("plant.speed", "rad/s", np.dtype(np.float64), "speed of the bit"),
    Column("plant.stuck", "", np.dtype(np.bool_)),
    Column("law.count", "1", np.dtype(np.int32)),
    Column("law.a/b", "", np.dtype(np.float64)),
)
ROWS = 200
RNG = np.random.default_rng(7)
TIMES = np.cumsum(RNG.uniform(0.1, 0.2, ROWS))
VALUES = {
    "plant.speed": RNG.normal(size=ROWS),
    "plant.stuck": RNG.random(ROWS) < 0.5,
    "law.count": RNG.integers(-9, 9, ROWS).astype(np.int32),
    "law.a/b": np.where(RNG.random(ROWS) < 0.1, np.nan, np.inf),
}


def rows(first: int, last: int) -> Rows:
    return Rows(first, TIMES[first:last], {name: values[first:last] for name, values in VALUES.items()})


def cuts(draw: st.DrawFn) -> list[int]:
    return [0, *sorted(draw(st.sets(st.integers(1, ROWS - 1), max_size=6))), ROWS]


@st.composite
def courses(draw: st.DrawFn) -> tuple[list[int], int]:
    """Where rows are cut, and at which of the cuts the program ends and begins again."""
    places = cuts(draw)
    return places, draw(st.integers(0, len(places) - 2))


STRIDES = st.fixed_dictionaries({name: st.sampled_from([0, 1, 3, 10]) for name in ("plant.*", "law.count", "law.a/b")})


@pytest.mark.slow
@settings(deadline=None, max_examples=40)
@given(courses(), STRIDES.filter(lambda strides: any(strides.values())), st.sampled_from([1, 7, 64, 65536]))
def test_zarr_gives_back_what_it_took(course: tuple[list[int], int], strides: dict[str, int], chunk: int) -> None:
    places, left = course
    columns = decimate(COLUMNS, strides)
    with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryDirectory() as folder:
        patch.setattr(zarr_layout, "CHUNK", chunk)
        path = Path(folder, "trajectory.zarr")
        store = create_zarr(path, columns, {"title": "t", "isolated": ["a"]})
        proof, position = store.proof, store.commit()
        for place, (first, last) in enumerate(pairwise(places)):
            store.take(rows(first, last))
            if place == left:
                store.commit()
                store = reopen_zarr(path, columns, position, proof)
                store.take(rows(first, last))
            position = store.commit()
        store.close({"steps": 3})
        with xr.open_zarr(path) as found:
            assert found.attrs == {"title": "t", "isolated": '["a"]', "steps": 3}
            for stride, chosen in columns.items():
                along = "time" if stride == 1 else f"time_{stride}"
                assert found[along].attrs["units"] == "s"
                np.testing.assert_array_equal(found[along].values, TIMES[::stride])
                for column in chosen:
                    array = found[column.name.replace("/", "%2F")]
                    assert array.dims == (along,)
                    assert array.dtype == column.dtype
                    assert array.attrs["units"] == (column.unit or "1")
                    np.testing.assert_array_equal(array.values, VALUES[column.name][::stride])
            names = {column.name.replace("/", "%2F") for chosen in columns.values() for column in chosen}
            assert set(found.data_vars) == names


@settings(deadline=None, max_examples=20)
@given(courses(), STRIDES.filter(lambda strides: any(strides.values())))
def test_csv_is_the_same_text_however_it_was_cut(course: tuple[list[int], int], strides: dict[str, int]) -> None:
    places, left = course
    columns = decimate(COLUMNS, strides)
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory() as other:
        whole = create_csv(Path(one), columns)
        whole.take(rows(0, ROWS))
        whole.close({})
        whole.release()
        store = create_csv(Path(other), columns)
        position, proof = store.commit(), store.proof
        for place, (first, last) in enumerate(pairwise(places)):
            store.take(rows(first, last))
            if place == left:
                store.close({})
                store.release()
                store = reopen_csv(Path(other), columns, position, proof)
                store.take(rows(first, last))
            position, proof = store.commit(), store.proof
        store.close({})
        store.release()
        for stride, chosen in columns.items():
            text = csv_file(Path(other), stride).read_bytes()
            assert text == csv_file(Path(one), stride).read_bytes()
            lines = text.decode().splitlines()
            assert lines[0].split(",") == ["time", *(column.name for column in chosen)]
            read = np.array([[float(number) for number in line.split(",")] for line in lines[1:]])
            np.testing.assert_array_equal(read[:, 0], TIMES[::stride])
            for index, column in enumerate(chosen, 1):
                np.testing.assert_array_equal(read[:, index], VALUES[column.name][::stride])


def test_a_store_that_has_lost_rows_is_refused(tmp_path: Path) -> None:
    columns = decimate(COLUMNS, {})
    path = tmp_path / "trajectory.zarr"
    store = create_zarr(path, columns, {})
    store.take(rows(0, 10))
    with pytest.raises(OutputError, match=r"plant\.speed has been stored for less than 10 rows"):
        reopen_zarr(path, columns, {"time": 10}, store.proof)
    create_csv(tmp_path, columns).close({})
    with pytest.raises(OutputError, match=r"trajectory\.csv has less than 1000 bytes"):
        reopen_csv(tmp_path, columns, {"time": 1000}, {"time": ""})


@pytest.mark.parametrize("operations", range(40))
@pytest.mark.parametrize("complete", [False, True])
def test_a_death_while_a_store_is_reopened_leaves_one_that_is_reopened_again(
    complete: bool, operations: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Chunks were stored beyond the last checkpoint, so that the arrays are longer than what the index is cut to."""
    monkeypatch.setattr(zarr_layout, "CHUNK", 16)
    columns, path = decimate(COLUMNS, {}), tmp_path / "trajectory.zarr"
    store = create_zarr(path, columns, {})
    store.take(rows(0, 20))
    position, proof = store.commit(), store.proof
    store.take(rows(20, 150))
    store.commit()
    if complete:
        store.close({})
    left = operations
    replace = zarr_store.replace_file

    def dying(*arguments: Any, **keywords: Any) -> None:
        nonlocal left
        if left == 0:
            raise KeyboardInterrupt
        left -= 1
        replace(*arguments, **keywords)

    for module in (zarr_store, zarr_layout):
        monkeypatch.setattr(module, "replace_file", dying)
    with suppress(KeyboardInterrupt):
        reopen_zarr(path, columns, position, proof)
    left = 1000
    store = reopen_zarr(path, columns, position, proof)
    store.take(rows(20, ROWS))
    store.commit()
    store.close({})
    with xr.open_zarr(path) as found:
        np.testing.assert_array_equal(found["plant.speed"].values, VALUES["plant.speed"])


def test_the_last_pattern_that_matches_holds() -> None:
    found = decimate(COLUMNS, {"*": 100, "plant.*": 10, "plant.speed": 1, "law.count": 0})
    assert {stride: [column.name for column in chosen] for stride, chosen in found.items()} == {
        1: ["plant.speed"],
        10: ["plant.stuck"],
        100: ["law.a/b"],
    }
    assert decimate(COLUMNS, {}) == {1: COLUMNS}


@pytest.mark.parametrize(
    ("strides", "message"),
    [
        ({"plant.sped": 2}, r"there is no 'plant\.sped'; did you mean 'plant\.speed'\?"),
        ({"*": -1}, r"\* = -1; expected 0 or a number of rows"),
        ({"*": 0}, "nothing is stored"),
    ],
)
def test_a_choice_that_makes_no_sense_is_refused(strides: dict[str, int], message: str) -> None:
    with pytest.raises(InputError, match=message):
        decimate(COLUMNS, strides)


CHECKPOINT = Snapshot(
    {"row": 12, "why": "µ"}, {"state plant": np.arange(200, dtype=np.uint8), "values": RNG.random((2, 3))}
)


def test_a_checkpoint_comes_back_as_it_was(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.npz"
    write_checkpoint(path, Snapshot({}, {}))
    write_checkpoint(path, CHECKPOINT)
    found = read_checkpoint(path)
    assert found.notes == CHECKPOINT.notes
    assert found.arrays.keys() == CHECKPOINT.arrays.keys()
    assert all(found.arrays[name].tobytes() == values.tobytes() for name, values in CHECKPOINT.arrays.items())
    assert [entry.name for entry in tmp_path.iterdir()] == ["checkpoint.npz"]


def test_a_damaged_checkpoint_is_refused_wherever_it_is_damaged(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.npz"
    write_checkpoint(path, CHECKPOINT)
    whole = path.read_bytes()
    for place in range(0, len(whole), 7):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x55]) + whole[place + 1 :])
        try:
            found = read_checkpoint(path)
        except CheckpointError:
            continue
        assert found.notes == CHECKPOINT.notes, place
        assert all(found.arrays[name].tobytes() == values.tobytes() for name, values in CHECKPOINT.arrays.items())
    path.write_bytes(whole[:-30])
    with pytest.raises(CheckpointError, match=r"checkpoint\.npz is no checkpoint, or is damaged"):
        read_checkpoint(path)
    with pytest.raises(CheckpointError, match="there is no such file"):
        read_checkpoint(tmp_path / "other.npz")


def test_a_checkpoint_that_cannot_be_written_leaves_the_one_before(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.npz"
    write_checkpoint(path, CHECKPOINT)
    (tmp_path / ".checkpoint.npz.new").mkdir()
    with pytest.raises(OutputError, match="cannot be written"):
        write_checkpoint(path, Snapshot({"row": 13}, {}))
    assert read_checkpoint(path).notes == CHECKPOINT.notes
