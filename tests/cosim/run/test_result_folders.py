"""Folders of streamed runs: what is in them is not destroyed, believed or followed, whoever has put it there."""

from __future__ import annotations

import hashlib
import io
import json
import logging
import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from cosim import Component, Constant, RunOptions, Scenario, System, load_scenario, open_trajectory, stream
from cosim.cli.app import app
from cosim.errors import CheckpointError, InputError, OutputError, RunInterruptedError
from cosim.fmi2.locate import locate_fmu
from cosim.run import report
from cosim.run.checkpoint import read_checkpoint
from cosim.run.job import Job, resume_job, run_job
from cosim.run.options import Streaming
from cosim.run.report import Manifest
from cosim.run.zarr_layout import INDEX, Index, digest
from tests.cosim.run.faults import KilledError
from tests.cosim.run.jobs import SCENARIO, Outcome, go_on, manifest_of, nothing, outcome, rows_of, small

pytestmark = pytest.mark.slow

CSV = pytest.mark.parametrize("csv", [False, True])


def content(folder: Path) -> dict[str, str]:
    """Every file of a folder, by the digest of what it has."""
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def interrupted(job: Job, folder: Path, part: float = 0.5) -> Path:
    """Leave a job in its middle."""

    def interrupt(label: str, done: float) -> None:
        if done > part:
            raise KeyboardInterrupt

    with pytest.raises(RunInterruptedError):
        run_job(job, folder, interrupt)
    return folder


def of_copied_fmu(place: Path, **choices: Any) -> Job:
    """A small job of an FMU that can be removed."""
    fmu = place / "Plant.fmu"
    shutil.copyfile(locate_fmu("DrillstringNeutral", "native", place), fmu)
    job = small(place, **choices)
    Path(job.source).write_text(SCENARIO.replace("DrillstringNeutral", "Plant.fmu"), encoding="utf-8")
    return Job(load_scenario(job.source), job.options, job.variants, job.streaming, job.source)


@CSV
def test_a_complete_trajectory_needs_nothing_but_its_manifest(
    csv: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    job = of_copied_fmu(tmp_path, csv=csv)
    run_job(job, tmp_path / "whole", nothing)

    def killed(manifest: Manifest, folder: Path) -> None:
        if len(manifest.variants) == 2:
            raise KilledError
        written(manifest, folder)

    written = Manifest.write
    monkeypatch.setattr(Manifest, "write", killed)
    with pytest.raises(KilledError):
        run_job(job, tmp_path / "run", nothing)
    monkeypatch.undo()
    (tmp_path / "Plant.fmu").unlink()
    Path(job.source).unlink()
    done = CliRunner().invoke(app, ["resume", str(tmp_path / "run")])
    assert done.exit_code == 0, done.output
    outcome(tmp_path / "run").assert_same(outcome(tmp_path / "whole"))
    assert not list((tmp_path / "run").rglob("checkpoint.npz"))
    assert (tmp_path / "run" / "heavy" / "figure.png").stat().st_size > 1000


@CSV
def test_a_run_whose_fmu_is_gone_is_refused_before_anything_is_touched(csv: bool, tmp_path: Path) -> None:
    job = of_copied_fmu(tmp_path, csv=csv)
    folder = interrupted(job, tmp_path / "run")
    before = content(folder)
    (tmp_path / "Plant.fmu").rename(tmp_path / "Moved.fmu")
    with pytest.raises(InputError, match=r"Plant\.fmu"):
        go_on(job, folder)
    for checkpoint in folder.rglob("checkpoint.npz"):
        checkpoint.rename(tmp_path / "checkpoint.npz")
    without = content(folder)
    with pytest.raises(InputError, match=r"Plant\.fmu"):
        go_on(job, folder)
    assert content(folder) == without
    assert set(before) - set(without) == {"light/checkpoint.npz"}


@CSV
def test_a_run_that_cannot_be_resumed_is_refused_and_its_rows_stay(csv: bool, probe: Path, tmp_path: Path) -> None:
    scenario = tmp_path / "guest.toml"
    scenario.write_text(
        'stop_time = 10.0\nstep_size = 0.1\n[components.guest]\nfmu = "probe.fmu"\n[inputs]\n"guest.u" = 2.0\n'
    )
    assert probe.parent == tmp_path
    job = Job(load_scenario(scenario), RunOptions(), streaming=Streaming(csv=csv), source=str(scenario))
    folder = interrupted(job, tmp_path / "run")
    before = content(folder)
    told = CliRunner().invoke(app, ["resume", str(folder)])
    assert told.exit_code == 2
    assert "holds a run that cannot be resumed, as guest cannot give a state" in told.stderr
    assert content(folder) == before
    assert len(rows_of(folder)) > 0


def test_a_run_that_goes_on_is_not_gone_on_with_by_another_program(tmp_path: Path) -> None:
    job = small(tmp_path, "light")
    refused: list[str] = []

    def second(label: str, part: float) -> None:
        command = [sys.executable, "-m", "cosim", "resume", str(tmp_path / "run")]
        if not refused:
            refused.append(subprocess.run(command, capture_output=True, text=True, check=False).stderr)

    run_job(job, tmp_path / "run", second)
    assert "run is in use: the run in it is going on" in refused[0]
    run_job(job, tmp_path / "whole", nothing)
    outcome(tmp_path / "run").assert_same(outcome(tmp_path / "whole"))


def test_a_run_in_python_is_held_as_well(tmp_path: Path) -> None:
    def second(part: float) -> None:
        with pytest.raises(OutputError, match="is in use"):
            stream(load_scenario("stick-slip"), tmp_path / "run", resume=True, stop_time=1.0)

    stream(load_scenario("stick-slip"), tmp_path / "run", stop_time=1.0, progress=second)


def test_a_complete_run_in_python_is_finished_when_it_is_resumed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenario, short = load_scenario("wob-law"), {"stop_time": 2.0, "step_size": 0.01}
    whole = stream(scenario, tmp_path / "whole", **short)  # type: ignore[arg-type]

    def killed(folder: Path) -> None:
        raise KilledError

    monkeypatch.setattr("cosim.run.stream.forget", killed)
    with pytest.raises(KilledError):
        stream(scenario, tmp_path / "run", **short)  # type: ignore[arg-type]
    monkeypatch.undo()
    with pytest.raises(CheckpointError, match=r"step_size is 0\.02 now"):
        stream(scenario, tmp_path / "run", resume=True, stop_time=2.0, step_size=0.02)
    found = stream(scenario, tmp_path / "run", resume=True, **short)  # type: ignore[arg-type]
    assert found == whole
    assert found.record["steps"] == whole.record["steps"]
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["trajectory.zarr"]


NAMES = ("figure.png", "manifest.json", "checkpoint.npz", "trajectory.csv", "trajectory_10.csv")


@pytest.mark.parametrize("name", [*NAMES, *(f".{name}.new" for name in NAMES[:3])])
def test_a_link_in_a_folder_from_elsewhere_is_never_written_through(name: str, tmp_path: Path) -> None:
    job = small(tmp_path, "light", csv=True)
    folder = interrupted(job, tmp_path / "run")
    target = tmp_path / "precious"
    if (folder / name).exists():
        (folder / name).rename(target)
    else:
        target.write_text("precious")
    before = target.read_bytes()
    (folder / name).symlink_to(target)
    told = CliRunner().invoke(app, ["resume", str(folder)])
    assert target.read_bytes() == before
    if name in NAMES[1:]:
        assert told.exit_code == 2
        assert f"{name} is a link" in told.stderr
    else:
        assert told.exit_code == 0, told.stderr
        assert not (folder / name).is_symlink()


@pytest.mark.parametrize("name", ["trajectory.zarr", "trajectory.zarr/time", "trajectory.zarr/plant.bit_speed/0"])
def test_a_store_that_leads_elsewhere_is_refused(name: str, tmp_path: Path) -> None:
    job = small(tmp_path, "light")
    folder = interrupted(job, tmp_path / "run")
    (folder / name).rename(tmp_path / "elsewhere")
    (folder / name).symlink_to(tmp_path / "elsewhere")
    before = content(tmp_path)
    with pytest.raises(InputError, match="is a link"):
        go_on(job, folder)
    assert content(tmp_path) == before


def test_a_table_with_another_name_is_not_cut(tmp_path: Path) -> None:
    job = small(tmp_path, "light", csv=True)
    folder = interrupted(job, tmp_path / "run")
    os.link(folder / "trajectory.csv", tmp_path / "backup.csv")
    before = content(tmp_path)
    with pytest.raises(OutputError, match=r"trajectory\.csv is also known by another name"):
        go_on(job, folder)
    assert content(tmp_path) == before


def test_a_chunk_that_is_missing_is_no_zeros(tmp_path: Path) -> None:
    job = small(tmp_path, "light")
    run_job(job, tmp_path / "run", nothing)
    (tmp_path / "run" / "trajectory.zarr" / "plant.bit_speed" / "0").unlink()
    with open_trajectory(tmp_path / "run") as found:
        assert found.time.size == 97
        with pytest.raises(InputError, match=r"plant\.bit_speed/0 is missing"):
            _ = found["plant.bit_speed"].values


def test_a_store_without_digests_is_refused_in_a_sentence(tmp_path: Path) -> None:
    run_job(small(tmp_path, "light"), tmp_path / "run", nothing)
    (tmp_path / "run" / "trajectory.zarr" / INDEX).unlink()
    with pytest.raises(
        InputError, match=r"has the digests; an earlier version wrote none, and xarray\.open_zarr reads"
    ):
        open_trajectory(tmp_path / "run")


def crafted(folder: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    """Change an index, and the digest above it as well, as somebody would who knows how."""
    path = folder / "trajectory.zarr" / INDEX
    told = json.loads(path.read_bytes().partition(b"\n")[2])
    change(told)
    text = json.dumps(told).encode()
    path.write_bytes(digest(text).encode() + b"\n" + text)
    return folder


CRAFTED: dict[str, Callable[[dict[str, Any]], object]] = {
    "a type with pickles": lambda told: told["axes"][0]["columns"][0].update(dtype="|V8"),
    "a size of its own": lambda told: told.update(chunk=2**40),
    "more rows than a chunk has": lambda told: told["axes"][0]["columns"][0].update(last=[[2**40, "a"]]),
    "a number for text": lambda told: told["axes"][0]["columns"][0].update(name=3),
    "an unknown key": lambda told: told.update(codec="pickle"),
    "no columns": lambda told: told["axes"][0].update(columns=[]),
    "a column twice": lambda told: told["axes"][0]["columns"].append(told["axes"][0]["columns"][0]),
    "a stride of none": lambda told: told["axes"][0].update(stride=0),
    "no axes but text": lambda told: told.update(axes="all"),
    "another format": lambda told: told.update(format="cosim-index-9"),
    "a name that leads out": lambda told: told["axes"][0]["columns"][0].update(name="../../elsewhere"),
}


@pytest.mark.parametrize("way", CRAFTED)
def test_an_index_that_was_made_up_is_refused(way: str, tmp_path: Path) -> None:
    run_job(small(tmp_path, "light"), tmp_path / "run", nothing)
    with pytest.raises(InputError) as refused:
        open_trajectory(crafted(tmp_path / "run", CRAFTED[way]))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("key", ["dtype", "compressor", "filters", "chunks", "shape", "order", "zarr_format"])
def test_what_describes_an_array_is_held_against_what_is_written(key: str, tmp_path: Path) -> None:
    run_job(small(tmp_path, "light"), tmp_path / "run", nothing)
    path = tmp_path / "run" / "trajectory.zarr" / "plant.bit_speed" / ".zarray"
    hostile: dict[str, Any] = {"dtype": "|O", "compressor": {"id": "pickle"}, "filters": [{"id": "pickle"}]}
    path.write_text(json.dumps({**json.loads(path.read_text()), key: hostile.get(key, [2**40])}))
    with pytest.raises(InputError, match=r"plant\.bit_speed/\.zarray is damaged"):
        open_trajectory(tmp_path / "run")


def checkpoint_with(array: bytes, compression: int = zipfile.ZIP_STORED) -> bytes:
    """A checkpoint whose only array is what is given."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", compression) as archive:
        archive.writestr("head.npy", array)
    return file.getvalue()


def header(**told: Any) -> bytes:
    """The beginning of an array that says of itself what is given."""
    file = io.BytesIO()
    usual = {"descr": "<f8", "fortran_order": False, "shape": (3,)}
    np.lib.format.write_array_header_1_0(file, usual | told)
    return file.getvalue()


@pytest.mark.parametrize(
    "array",
    [
        checkpoint_with(header(shape=(2**40,)) + bytes(24)),
        checkpoint_with(header(shape=(2**31, 2**31)) + bytes(24)),
        checkpoint_with(header(shape=(0, 2**62)) + bytes(24)),
        checkpoint_with(header(descr="|O") + bytes(24)),
        checkpoint_with(header() + bytes(2**26), zipfile.ZIP_DEFLATED),
        checkpoint_with(b"\x93NUMPY\x01\x00\xff\xff" + b"(" * 65535),
        checkpoint_with(b""),
    ],
    ids=["terabytes", "exabytes", "nothing of much", "pickles", "compressed", "nested", "empty"],
)
def test_a_checkpoint_allocates_no_more_than_it_has(array: bytes, tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.npz"
    path.write_bytes(array)
    with pytest.raises(CheckpointError, match="is no checkpoint, or is damaged"):
        read_checkpoint(path)


MANIFESTS: dict[str, Callable[[dict[str, Any]], object]] = {
    "a number for a name": lambda told: told.update(scenario=3),
    "text for variants": lambda told: told.update(variants="none"),
    "numbers for variants": lambda told: told.update(variants=[1, 2]),
    "an empty job": lambda told: told.update(job={}),
    "text for a time": lambda told: told["job"]["choices"].update(stop_time="soon"),
    "a table for a time": lambda told: told["job"]["choices"].update(stop_time={}),
    "text for limits": lambda told: told["job"]["choices"].update(limits="none"),
    "limits of no use": lambda told: told["job"]["choices"].update(limits={"time": "a", "memory": []}),
    "a number for overrides": lambda told: told["job"]["choices"].update(overrides=5),
    "tables for overrides": lambda told: told["job"]["choices"].update(overrides={"plant.WOB": {}}),
    "a number for isolate": lambda told: told["job"]["choices"].update(isolate=7),
    "a list for a source": lambda told: told["job"].update(source=["a"]),
    "a number for variants": lambda told: told["job"].update(variants=1),
    "numbers for labels": lambda told: told["job"].update(labels=[1]),
    "no labels": lambda told: told["job"].update(labels=[]),
    "labels that lead out": lambda told: told["job"].update(labels=["../a", "b"]),
    "text for strides": lambda told: told["job"]["streaming"].update(every="all"),
    "text for a format": lambda told: told["job"]["streaming"].update(csv="perhaps"),
    "text for an interval": lambda told: told["job"]["streaming"].update(checkpoint_interval="often"),
    "text for versions": lambda told: told.update(versions="new"),
    "a table for a commit": lambda told: told.update(commit={}),
    "no date": lambda told: told.pop("created"),
}


@pytest.mark.parametrize("way", MANIFESTS)
def test_a_manifest_that_was_made_up_is_one_sentence(way: str, tmp_path: Path) -> None:
    folder = interrupted(small(tmp_path, "light"), tmp_path / "run")
    told = report.read_content(folder)
    assert told is not None
    MANIFESTS[way](told)
    report.write_content(folder, {name: value for name, value in told.items() if name != "format"})
    before = content(tmp_path)
    done = CliRunner().invoke(app, ["resume", str(folder)])
    assert done.exit_code == 2, done.output
    assert done.stderr.count("\n") == 1
    assert content(tmp_path) == before


@pytest.mark.parametrize(
    "text", ["[" * 100_000, '{"format": ' + "[" * 900 + "]" * 900 + "}", "1" * 5000, "\0", '"\\ud800"']
)
def test_a_manifest_of_any_text_is_one_sentence(text: str, tmp_path: Path) -> None:
    (tmp_path / "manifest.json").write_text(text)
    done = CliRunner().invoke(app, ["resume", str(tmp_path)])
    assert done.exit_code == 2, done.output
    assert done.stderr.count("\n") == 1


def test_a_manifest_without_end_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "manifest.json").open("wb") as file:
        file.truncate(2**40)
    done = CliRunner().invoke(app, ["resume", str(tmp_path)])
    assert (done.exit_code, done.stderr.count("\n")) == (2, 1)
    assert "it has more than 100 MB" in done.stderr


def test_a_manifest_that_says_something_else_is_refused(tmp_path: Path) -> None:
    folder = interrupted(small(tmp_path, "light"), tmp_path / "run")
    path = folder / "manifest.json"
    path.write_text(path.read_text().replace('"csv": false', '"csv": true'))
    with pytest.raises(OutputError, match=r"manifest\.json is damaged: it does not say what was written"):
        resume_job(folder, lambda job: None, nothing)


@pytest.mark.parametrize("key", ["sha256", "sha356"])
def test_a_manifest_that_has_lost_its_digest_is_refused(key: str, tmp_path: Path) -> None:
    folder = interrupted(small(tmp_path, "light"), tmp_path / "run")
    path = folder / "manifest.json"
    told = json.loads(path.read_text())
    digest_of_all = told.pop("sha256")
    path.write_text(json.dumps(told if key == "sha256" else {**told, key: digest_of_all}))
    with pytest.raises(OutputError, match=r"manifest\.json is damaged"):
        resume_job(folder, lambda job: None, nothing)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
@pytest.mark.parametrize("name", ["manifest.json", "checkpoint.npz", "trajectory.csv"])
def test_a_pipe_in_a_folder_is_not_waited_for(name: str, tmp_path: Path) -> None:
    folder = interrupted(small(tmp_path, "light", csv=True), tmp_path / "run")
    (folder / name).unlink()
    os.mkfifo(folder / name)
    done = subprocess.run(
        [sys.executable, "-m", "cosim", "resume", str(folder)],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("step_size", [0.01, 0.1])
def test_measures_and_energy_do_not_depend_on_where_a_run_was_interrupted(step_size: float, tmp_path: Path) -> None:
    scenario = load_scenario("stick-slip")
    options = RunOptions(stop_time=200.0, step_size=step_size)
    job = Job(scenario, options, streaming=Streaming({"*": 100}), source="stick-slip")
    run_job(job, tmp_path / "whole", nothing)
    interrupted(job, tmp_path / "run", 0.13)
    for part in (0.35, 0.62, 0.83):

        def interrupt(label: str, done: float, part: float = part) -> None:
            if done > part:
                raise KeyboardInterrupt

        with pytest.raises(RunInterruptedError):
            resume_job(tmp_path / "run", lambda job: None, interrupt)
    go_on(job, tmp_path / "run")
    outcome(tmp_path / "run").assert_same(outcome(tmp_path / "whole"))
    assert manifest_of(tmp_path / "run")["variants"][0]["energy"]["since"] == pytest.approx(140.0)


@pytest.mark.parametrize("title", ["a $x_{$ b", "100 % \\frac{", "\x1b[31mred\x07", "\u202egnidae", "long " * 5000])
def test_any_title_is_drawn_as_it_stands(title: str, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    plant = Component("plant", "DrillstringNeutral")
    scenario = Scenario("any", System((plant,), inputs={"plant.WOB": Constant(5e4)}), 1.0, 0.01, title=title)
    run_job(Job(scenario), tmp_path / "run", nothing)
    assert (tmp_path / "run" / "figure.png").stat().st_size > 1000
    assert not caplog.messages


@pytest.mark.parametrize("streaming", [None, Streaming()])
def test_a_figure_that_fails_costs_a_warning_and_no_results(
    streaming: Streaming | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(*given: object) -> None:
        raise ValueError("mathematics\nthat nobody can read")

    monkeypatch.setattr("cosim.drilling.reporting.draw", fail)
    job = Job(load_scenario("stick-slip"), RunOptions(stop_time=1.0), streaming=streaming, source="stick-slip")
    with caplog.at_level(logging.WARNING):
        manifest = run_job(job, tmp_path / "run", nothing)
    assert "there is no figure figure.png" in caplog.messages[0]
    written = {path.relative_to(tmp_path / "run").parts[0] for path in (tmp_path / "run").rglob("*")}
    assert written == set(manifest.files) == {"manifest.json", f"trajectory.{'zarr' if streaming else 'csv'}"}
    with pytest.raises(OutputError, match="holds a finished streamed run") if streaming else nullcontext():
        run_job(Job(load_scenario("stick-slip"), RunOptions(stop_time=1.0)), tmp_path / "run", nothing)


def test_what_a_run_says_is_not_blamed_on_the_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*given: object, **options: object) -> None:
        raise BrokenPipeError(32, "Broken pipe")

    monkeypatch.setattr("cosim.run.job.run", fail)
    with pytest.raises(BrokenPipeError):
        run_job(Job(load_scenario("stick-slip")), tmp_path / "run", nothing)
    assert list(tmp_path.iterdir()) == []


def test_an_index_names_the_states_before_and_after_a_write(tmp_path: Path) -> None:
    folder = interrupted(small(tmp_path, "light"), tmp_path / "run")
    index = Index.read(folder / "trajectory.zarr")
    assert index.closed
    assert [len(column.last) for each in index.axes for column in each.columns] == [1, 1, 1, 1, 1]
    Outcome(rows_of(folder), {})
