"""A run's folder is complete or it is not there."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from cosim.errors import OutputError
from cosim.recording.result import Result
from cosim.run.report import write_content
from cosim.run.run_folder import run_folder


def result(**columns: np.ndarray) -> Result:
    named = {name.replace("_", ".", 1): values for name, values in columns.items()}
    return Result(np.arange(3) * 0.1, named, dict.fromkeys(named, ""))


def a_run(path: Path, mark: str) -> None:
    with run_folder(path) as folder:
        (folder / "mark.txt").write_text(mark)
        write_content(folder, {"variants": [{"trajectory": "mark.txt"}]})


def test_numbers_in_a_csv_file_read_back_to_the_same_bits(tmp_path: Path) -> None:
    values = np.array([0.1 + 0.2, -1e-308 / 3.0, np.nextafter(1.0, 2.0)])
    result(plant_speed=values, plant_stuck=np.array([True, False, True]), plant_count=np.array([1, 2, 3])).to_csv(
        tmp_path / "trajectory.csv"
    )
    with (tmp_path / "trajectory.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["time", "plant.speed", "plant.stuck", "plant.count"]
    assert [float(row["time"]) for row in rows] == [0.0, 0.1, 0.2]
    assert [float(row["plant.speed"]) for row in rows] == values.tolist()
    assert [row["plant.stuck"] for row in rows] == ["1", "0", "1"]
    assert [row["plant.count"] for row in rows] == ["1", "2", "3"]


def test_a_run_appears_whole_under_its_name(tmp_path: Path) -> None:
    path = tmp_path / "runs" / "mine"
    with run_folder(path) as folder:
        assert not path.exists()
        (folder / "trajectory.csv").write_text("time\n")
        write_content(folder, {"ssi": float("inf")})
    assert sorted(entry.name for entry in path.iterdir()) == ["manifest.json", "trajectory.csv"]
    assert json.loads((path / "manifest.json").read_text())["ssi"] == "inf"
    assert [entry.name for entry in path.parent.iterdir()] == ["mine"]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_a_failed_run_leaves_nothing_not_even_the_folders_made_for_it(tmp_path: Path, error: type) -> None:
    def fail() -> None:
        with run_folder(tmp_path / "new" / "runs" / "mine") as folder:
            (folder / "trajectory.csv").write_text("half")
            raise error

    with pytest.raises(error):
        fail()
    assert list(tmp_path.iterdir()) == []


def test_a_failed_run_leaves_the_earlier_one_as_it_was(tmp_path: Path) -> None:
    a_run(tmp_path / "mine", "first")
    with pytest.raises(ValueError, match="later"), run_folder(tmp_path / "mine"):
        raise ValueError("later")
    assert (tmp_path / "mine" / "mark.txt").read_text() == "first"
    assert [entry.name for entry in tmp_path.iterdir()] == ["mine"]


def test_a_later_run_replaces_what_an_earlier_one_wrote_and_nothing_of_the_users(tmp_path: Path) -> None:
    with run_folder(tmp_path / "mine") as folder:
        (folder / "steep").mkdir()
        (folder / "steep" / "rows.csv").write_text("first")
        write_content(folder, {"variants": [{"trajectory": "steep/rows.csv"}]})
    (tmp_path / "mine" / "thesis.tex").write_text("precious")
    a_run(tmp_path / "mine", "second")
    left = {path.relative_to(tmp_path / "mine").as_posix() for path in (tmp_path / "mine").rglob("*")}
    assert left == {"manifest.json", "mark.txt", "thesis.tex"}
    assert (tmp_path / "mine" / "thesis.tex").read_text() == "precious"
    assert [entry.name for entry in tmp_path.iterdir()] == ["mine"]


def test_a_folder_of_the_users_within_that_of_a_variant_stays(tmp_path: Path) -> None:
    with run_folder(tmp_path / "mine") as folder:
        (folder / "steep").mkdir()
        (folder / "steep" / "rows.csv").write_text("first")
        write_content(folder, {"variants": [{"trajectory": "steep/rows.csv"}]})
    (tmp_path / "mine" / "steep" / "notes.txt").write_text("precious")
    a_run(tmp_path / "mine", "second")
    assert [path.name for path in (tmp_path / "mine" / "steep").iterdir()] == ["notes.txt"]


@pytest.mark.parametrize("kind", ["file", "folder", "link"])
def test_what_is_in_the_way_is_refused_before_the_run_and_kept(tmp_path: Path, kind: str) -> None:
    a_run(tmp_path / "mine", "first")
    place = tmp_path / "mine" / "figure.png"
    if kind == "file":
        place.write_text("precious")
    elif kind == "folder":
        place.mkdir()
    else:
        (tmp_path / "elsewhere").write_text("precious")
        place.symlink_to(tmp_path / "elsewhere")
    with (
        pytest.raises(OutputError, match=r"figure\.png is in the way, and is not of an earlier run"),
        run_folder(tmp_path / "mine", ["manifest.json", "figure.png"]),
    ):
        pytest.fail("the run was started")
    assert place.is_symlink() or place.exists()
    assert (tmp_path / "mine" / "mark.txt").read_text() == "first"


def test_a_link_to_a_folder_is_followed(tmp_path: Path) -> None:
    (tmp_path / "disk").mkdir()
    (tmp_path / "mine").symlink_to(tmp_path / "disk")
    a_run(tmp_path / "mine", "first")
    a_run(tmp_path / "mine", "second")
    assert (tmp_path / "mine").is_symlink()
    assert (tmp_path / "disk" / "mark.txt").read_text() == "second"
    assert {entry.name for entry in tmp_path.iterdir()} == {"disk", "mine"}


def test_a_manifest_that_leads_out_of_its_folder_removes_nothing_there(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("precious")
    a_run(tmp_path / "mine", "first")
    named = [{"trajectory": "../thesis.tex"}, {"trajectory": str(tmp_path / "thesis.tex")}, {"trajectory": "mark.txt"}]
    write_content(tmp_path / "mine", {"variants": named})
    a_run(tmp_path / "mine", "second")
    assert (tmp_path / "thesis.tex").read_text() == "precious"
    assert (tmp_path / "mine" / "mark.txt").read_text() == "second"


def test_a_finished_streamed_run_is_never_replaced(tmp_path: Path) -> None:
    a_run(tmp_path / "mine", "first")
    write_content(tmp_path / "mine", {"variants": [{"trajectory": "mark.txt", "figure": "figure.png"}]})
    with pytest.raises(OutputError, match="holds a finished streamed run, which is not replaced"):
        a_run(tmp_path / "mine", "second")
    assert (tmp_path / "mine" / "mark.txt").read_text() == "first"


def test_a_run_that_cannot_be_moved_to_its_place_leaves_the_earlier_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    a_run(tmp_path / "mine", "first")
    rename = Path.rename

    def failing(path: Path, target: Path) -> Path:
        if path.name == "mark.txt" and path.read_text() == "second" and target.parent == tmp_path / "mine":
            raise OSError(28, "No space left on device")
        return rename(path, target)

    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises(OutputError, match="No space left"):
        a_run(tmp_path / "mine", "second")
    assert (tmp_path / "mine" / "mark.txt").read_text() == "first"
    assert (tmp_path / "mine" / "manifest.json").exists()
    assert [entry.name for entry in tmp_path.iterdir()] == ["mine"]


def test_an_empty_folder_is_used(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    a_run(tmp_path / "mine", "first")
    assert (tmp_path / "mine" / "mark.txt").read_text() == "first"


@pytest.mark.parametrize("name", ["thesis.tex", "manifest.json"])
def test_a_folder_with_something_else_in_it_is_refused_and_kept(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("{}")
    with pytest.raises(OutputError, match="holds something that is not a run"):
        a_run(tmp_path, "first")
    assert (tmp_path / name).read_text() == "{}"


def test_a_file_in_the_place_of_the_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("precious")
    with pytest.raises(OutputError, match="is a file; expected a folder"):
        a_run(tmp_path / "file", "first")
    with pytest.raises(OutputError, match="cannot be written"):
        a_run(tmp_path / "file" / "below", "first")


def test_a_folder_without_permission_is_refused_before_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def forbid(**options: object) -> str:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tempfile.mkdtemp", forbid)
    with (
        pytest.raises(OutputError, match="mine cannot be written: Permission denied"),
        run_folder(tmp_path / "new" / "mine"),
    ):
        pytest.fail("the run was started")
    assert list(tmp_path.iterdir()) == []
