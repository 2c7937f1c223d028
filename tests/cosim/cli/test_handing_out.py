"""FMU files for other tools: listed, copied, never over somebody's file."""

from __future__ import annotations

from pathlib import Path

from typer.testing import CliRunner

from cosim.cli.app import app
from cosim.fmi2.locate import locate_fmu

runner = CliRunner()


def test_without_a_folder_they_are_listed() -> None:
    done = runner.invoke(app, ["fmus"])
    assert done.exit_code == 0
    assert str(locate_fmu("DrillstringNeutral", "native")) in done.stdout.split()


def test_copies_are_the_files_that_runs_use(tmp_path: Path) -> None:
    done = runner.invoke(app, ["fmus", str(tmp_path / "out")])
    assert done.exit_code == 0
    copies = sorted((tmp_path / "out").iterdir())
    assert "WeightOnBitLaw.fmu" in [path.name for path in copies]
    assert all(path.read_bytes() == locate_fmu(path.stem, "native").read_bytes() for path in copies)
    assert runner.invoke(app, ["fmus", str(tmp_path / "out")]).exit_code == 0, "the same files are no conflict"


def test_another_file_of_that_name_stays_unless_forced(tmp_path: Path) -> None:
    mine = tmp_path / "WeightOnBitLaw.fmu"
    mine.write_bytes(b"mine")
    done = runner.invoke(app, ["fmus", str(tmp_path)])
    assert done.exit_code == 2
    assert "is there already and is another file; expected --force" in " ".join(done.stderr.split())
    assert [path.name for path in tmp_path.iterdir()] == [mine.name]
    assert mine.read_bytes() == b"mine"
    assert runner.invoke(app, ["fmus", str(tmp_path), "--force"]).exit_code == 0
    assert mine.read_bytes() == locate_fmu("WeightOnBitLaw", "native").read_bytes()


def test_a_folder_that_cannot_be_made_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    done = runner.invoke(app, ["fmus", str(tmp_path / "file" / "below")])
    assert done.exit_code == 2
    assert "cannot be written" in done.stderr


def test_a_packaging_that_does_not_exist_is_named() -> None:
    done = runner.invoke(app, ["fmus", "--packaging", "nativ"])
    assert done.exit_code == 2
    assert "there is no packaging 'nativ'" in done.stderr
