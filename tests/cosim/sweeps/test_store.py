"""A store holds the same bytes however its sweep went, can be read at any time, and is never another's."""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import zlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim import InputError, open_series, open_sweep, sweep
from cosim.errors import OutputError, SweepInterruptedError
from cosim.sweeps import store
from cosim.sweeps.arrays import begin_group, consolidate, coordinate
from cosim.sweeps.measures import FinalValues, Output
from cosim.sweeps.reading import load_sweep
from cosim.sweeps.workers import dispatch
from cosim.sweeps.workers.crew import Here
from tests.cosim.sweeps.measuring import OUTPUTS, Last

GRID = {"plant.Omega": "4:16:21", "plant.WOB": "2e4:1e5:2"}


def run(path: Path, **changes: Any) -> Any:
    given: dict[str, Any] = {"grid": GRID, "measures": Last(), "workers": 1, "stop_time": 3.0, **changes}
    return sweep("stick-slip", path, **given)


def content(path: Path) -> dict[str, bytes]:
    """Return all files of a store."""
    return {file.relative_to(path).as_posix(): file.read_bytes() for file in path.rglob("*") if file.is_file()}


@pytest.fixture
def one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hand out points one by one."""
    monkeypatch.setattr(dispatch, "TARGET", 0.0)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, bytes]]:
    """Return the content of sweeps that nothing interrupted, by branch."""
    folder = tmp_path_factory.mktemp("whole")
    for branch in ("rest", "up"):
        run(folder / branch, branch=branch)
    return {branch: content(folder / branch) for branch in ("rest", "up")}


@pytest.mark.slow
@pytest.mark.usefixtures("one_by_one")
@pytest.mark.parametrize("branch", ["rest", "up"])
def test_a_sweep_that_was_killed_ends_as_others_do(
    tmp_path: Path, whole: dict[str, dict[str, bytes]], branch: str
) -> None:
    path, copies = tmp_path / "s.zarr", list[tuple[int, Path]]()

    def copy(said: str, part: float) -> None:
        """Keep what a kill at this moment would leave."""
        done = int(said.partition(" ")[0])
        if done < 42 and done >= 12 * len(copies) + 1:
            copies.append((done, tmp_path / f"killed-{len(copies)}"))
            shutil.copytree(path, copies[-1][1])
        assert 0.0 <= part <= 1.0

    run(path, progress=copy, branch=branch)
    assert content(path) == whole[branch]
    assert len(copies) == 4
    for done, killed in copies:
        begun = open_sweep(killed)
        assert int(begun["failed"].notnull().sum()) <= done
        counted = Counting()
        run(killed, executor=(counted, 1), branch=branch)
        assert content(killed) == whole[branch]
        assert counted.points == 42 - done


class Counting(Here):
    """Count the points that are handed out."""

    points = 0

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
        future = super().submit(fn, *args, **kwargs)
        self.points += sum(len(done.numbers) for done in future.result().done or ())
        return future


@pytest.mark.usefixtures("one_by_one")
def test_an_interrupted_sweep_can_be_read_as_far_as_it_got(tmp_path: Path, whole: dict[str, dict[str, bytes]]) -> None:
    path = tmp_path / "s.zarr"

    def interrupt(said: str, part: float) -> None:
        if part >= 0.5:
            raise KeyboardInterrupt

    with pytest.raises(SweepInterruptedError, match=r"^interrupted after (\d+) of 42 points, which are in ") as stopped:
        run(path, progress=interrupt)
    done = stopped.value.done
    assert 21 <= done < 42
    begun = open_sweep(path)
    assert int(begun["failed"].notnull().sum()) == done
    assert int(begun["energy"].notnull().sum()) == done
    run(path)
    assert content(path) == whole["rest"]


def test_a_line_that_was_being_written_is_dropped(tmp_path: Path, whole: dict[str, dict[str, bytes]]) -> None:
    path = tmp_path / "s.zarr"
    run(path)
    for torn in (b"", b"0123", b'00000000 {"done":[[0,0,[[1,2,3,4,5]],{},null]]}\n', b"\xff" * 100):
        (path / store.JOURNAL).write_bytes(torn)
        run(path)
        assert content(path) == whole["rest"]


def test_a_sweep_that_is_done_is_returned_at_once(tmp_path: Path, whole: dict[str, dict[str, bytes]]) -> None:
    run(tmp_path / "s.zarr")
    counted = Counting()
    found = run(tmp_path / "s.zarr", executor=(counted, 1))
    assert counted.points == 0
    assert content(tmp_path / "s.zarr") == whole["rest"]
    assert found["failed"].values.sum() == 0


def test_without_its_journal_a_store_tells_by_itself_what_is_done(
    tmp_path: Path, whole: dict[str, dict[str, bytes]]
) -> None:
    path = tmp_path / "s.zarr"
    run(path)
    for file in (path / "failed").glob("0.*"):
        file.unlink()
    run(path)
    assert content(path) == whole["rest"]


def test_a_store_tells_what_it_holds(tmp_path: Path) -> None:
    found = run(tmp_path / "s.zarr")
    assert found["energy"].dims == ("plant.Omega", "plant.WOB")
    assert found["plant.WOB"].attrs == {"units": "N", "long_name": "Weight on bit"}
    record = json.loads(found.attrs["record"])
    assert record["components"]["plant"]["sha256"] in json.dumps(record["fmus"])
    assert record["components"]["plant"]["parameters"]["L"] == 1172.0
    assert json.loads(found.attrs["versions"])["drillstring-cosim"] == record["product"]
    assert set(found.data_vars) == {*OUTPUTS, "failed", "message"}
    # chunks of 10 to 50 rows
    assert open_sweep(tmp_path / "s.zarr")["energy"].encoding["chunks"] == (21, 2)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"grid": {**GRID, "plant.WOB": "2e4:1e5:3"}}, "has other values of plant.WOB"),
        ({"grid": {"plant.Omega": "4:16:21"}}, "is over other values"),
        ({"stop_time": 4.0}, "has another duration"),
        ({"overrides": {"plant.c_b": 0.5}}, "is of other FMUs or parameters"),
        ({"branch": "up"}, "is of another branch (rest, not up)"),
        ({"measures": Last(window=1.0)}, "has other measures"),
        ({"packaging": "python"}, "is of other FMUs or parameters"),
    ],
)
def test_a_store_of_another_sweep_is_refused_and_left_alone(
    tmp_path: Path, changes: dict[str, Any], sentence: str
) -> None:
    path = tmp_path / "s.zarr"
    run(path)
    before = content(path)
    with pytest.raises(OutputError) as refused:
        run(path, **changes)
    assert str(refused.value) == f"{path} {sentence}; expected the same sweep to go on with, or a new name"
    assert content(path) == before


@pytest.mark.parametrize(
    ("name", "sentence"), [("format", "another format (0, not 1)"), ("product", "another version")]
)
def test_a_store_of_another_version_is_refused(tmp_path: Path, name: str, sentence: str) -> None:
    path = tmp_path / "s.zarr"
    run(path)
    attributes = json.loads((path / ".zattrs").read_text())
    attributes["record"] = json.dumps({**json.loads(attributes["record"]), name: 0})
    (path / ".zattrs").write_text(json.dumps(attributes))
    with pytest.raises(OutputError, match=re.escape(sentence)):
        run(path)


def test_what_is_no_store_is_refused(tmp_path: Path) -> None:
    (tmp_path / "s.zarr").mkdir()
    (tmp_path / "s.zarr" / "mine.txt").touch()
    with pytest.raises(OutputError, match=r"is there already and is no store of a sweep; expected a new name$"):
        run(tmp_path / "s.zarr")
    assert os.listdir(tmp_path / "s.zarr") == ["mine.txt"]
    with pytest.raises(InputError, match=r"there is no store of a sweep$"):
        open_sweep(tmp_path / "s.zarr")


@pytest.mark.usefixtures("one_by_one")
def test_a_full_disk_costs_no_point_that_is_kept(
    tmp_path: Path, whole: dict[str, dict[str, bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    path, written = tmp_path / "s.zarr", list[int]()
    write = store.write_all

    def fill(descriptor: int, given: bytes) -> None:
        """Write a part of the twentieth line only."""
        written.append(descriptor)
        if len(written) == 20:
            os.write(descriptor, given[:10])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        write(descriptor, given)

    monkeypatch.setattr(store, "write_all", fill)
    with pytest.raises(OutputError, match=r"s\.zarr cannot be written: No space left on device; what is done is in it"):
        run(path)
    kept = open_sweep(path)
    assert int(kept["failed"].notnull().sum()) == 19
    assert np.isfinite(kept["energy"].values[kept["failed"].values == 0]).all()
    counted = Counting()
    run(path, executor=(counted, 1))
    assert counted.points == 42 - 19
    assert content(path) == whole["rest"]


def test_a_store_that_cannot_be_begun_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match=r"cannot be written: "):
        run(tmp_path / "file" / "s.zarr")


def test_a_journal_that_makes_no_sense_is_refused(tmp_path: Path, whole: dict[str, dict[str, bytes]]) -> None:
    path = tmp_path / "s.zarr"
    run(path)
    for said in (b'{"done":[[99,0,[[1,2,3,4,5]],{},null]]}', b'{"done":[[0,0,[[1]],{},null]]}', b'{"done":[1]}'):
        (path / store.JOURNAL).write_bytes(b"%08x %s\n" % (zlib.crc32(said), said))
        with pytest.raises(OutputError, match=r"its journal is not of this sweep; without \.journal what the store"):
            run(path)
    (path / store.JOURNAL).unlink()
    run(path)
    assert content(path) == whole["rest"]


@pytest.mark.usefixtures("one_by_one")
def test_an_interrupt_of_an_interrupt_loses_nothing(
    tmp_path: Path, whole: dict[str, dict[str, bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "s.zarr"

    def interrupt(said: str = "", part: float = 1.0) -> None:
        if part >= 0.5:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(store.SweepStore, "flush", lambda _: interrupt())
        with pytest.raises(SweepInterruptedError, match=r"^interrupted after \d+ of 42 points"):
            run(path, progress=interrupt)
    run(path)
    assert content(path) == whole["rest"]


def test_a_path_is_taken_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    grid = {"plant.Omega": [4.0]}
    found = sweep("stick-slip", "~/s.zarr", grid=grid, keep=["plant.bit_speed"], workers=1, stop_time=21.0)
    assert found["failed"].values.tolist() == [0.0]
    assert open_sweep(tmp_path / "~" / "s.zarr").equals(found)
    assert open_series("~/s.zarr")["plant.bit_speed"].notnull().all()


def test_a_value_that_is_written_in_two_ways_is_one(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^plant\.Omega: 10\.0 is given twice; expected each value once$"):
        sweep("stick-slip", tmp_path / "s.zarr", grid={"plant.Omega": "10,8,10 rad/s"}, workers=1)


def test_a_store_that_another_program_begins_meanwhile_is_left_to_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, begin = tmp_path / "s.zarr", store.begin_group

    def late(*arguments: Any) -> None:
        monkeypatch.setattr(store, "begin_group", begin)
        with ThreadPoolExecutor(1) as other:
            other.submit(run, path).result()
        begin(*arguments)

    monkeypatch.setattr(store, "begin_group", late)
    assert run(path).equals(open_sweep(path))


def test_what_is_no_store_of_a_sweep_or_is_damaged_is_told(tmp_path: Path) -> None:
    begin_group(tmp_path / "other.zarr", "", {"a": coordinate("a", [1.0, 2.0])})
    consolidate(tmp_path / "other.zarr")
    with pytest.raises(InputError, match=r"other\.zarr: there is no store of a sweep, but another one of Zarr$"):
        open_sweep(tmp_path / "other.zarr")
    path = tmp_path / "s.zarr"
    run(path)
    for file in (path / "energy").glob("[0-9]*"):
        file.write_bytes(b"a chunk that is none")
    with pytest.raises(InputError, match=r"s\.zarr cannot be read: "):
        load_sweep(path)
    (path / ".zmetadata").write_text("{")
    with pytest.raises(OutputError, match=r"s\.zarr is damaged: .*; expected a new name$"):
        run(path)


def test_a_file_is_no_store(tmp_path: Path) -> None:
    (tmp_path / "s.zarr").touch()
    with pytest.raises(OutputError, match=r"is there already and is no store of a sweep; expected a new name$"):
        run(tmp_path / "s.zarr")


NESTED = """
title = "nested"
stop_time = 3.0
step_size = 0.1
[components."inner/the 100 % plant"]
fmu = "DrillstringNeutral"
[inputs]
"inner/the 100 % plant.Omega" = 10.0
"inner/the 100 % plant.WOB" = 97347.0
"""


def test_names_of_any_characters_come_back_as_they_are(tmp_path: Path) -> None:
    (tmp_path / "nested.toml").write_text(NESTED)
    part = "inner/the 100 % plant"
    given: dict[str, Any] = {
        "grid": {part: ["DrillstringNeutral", "DrillstringDistributed"], f"{part}.Omega": [5.0, 10.0]},
        "samples": {f"{part}.WOB": "5e4:9e4"}, "count": 2, "workers": 1, "keep": [f"{part}.bit_speed"],
        "measures": FinalValues((Output(f"{part}.top_speed", "rad/s", ""),)),
    }  # fmt: skip
    found = sweep(tmp_path / "nested.toml", tmp_path / "s.zarr", **given)
    assert found.sizes == {part: 2, f"{part}.Omega": 2, "sample": 2}
    assert set(found.coords) == {part, f"{part}.Omega", f"{part}.WOB"}
    assert set(found.data_vars) == {f"{part}.top_speed", "failed", "message"}
    assert (found[f"{part}.top_speed"] > 0.0).all()
    series = open_series(tmp_path / "s.zarr", {f"{part}.Omega": 10.0, part: "DrillstringDistributed"})
    assert series[f"{part}.bit_speed"].sizes == {"sample": 2, "time": 31}
    assert series[f"{part}.bit_speed"].notnull().all()
    assert found.attrs.keys() == open_sweep(tmp_path / "s.zarr").attrs.keys()
    assert not [path for path in (tmp_path / "s.zarr").rglob("*") if set(path.name) & set('\\:*?"<>|')]


@pytest.mark.parametrize("name", ["failed", "message", "sample", "series", "time", "ssi", "quantile", "left_out"])
def test_a_component_whose_name_the_store_needs_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "s.toml").write_text(NESTED.replace("inner/the 100 % plant", name))
    with pytest.raises(InputError, match=rf"^{name} is to vary, and the store has that name for something else; expec"):
        sweep(tmp_path / "s.toml", tmp_path / "s.zarr", grid={name: ["DrillstringDistributed"]}, workers=1)
    assert not (tmp_path / "s.zarr").exists()


def test_what_is_set_and_varies_is_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    found = run(
        tmp_path / "s.zarr", grid={"plant.Omega": [4.0, 16.0]}, overrides={"plant.Omega": 9.0, "plant.L": 900.0}
    )
    assert found["plant.Omega"].values.tolist() == [4.0, 16.0]
    assert caplog.messages == ["plant.Omega varies, so that the value it is set to has no effect"]
