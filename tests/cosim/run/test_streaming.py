"""Streamed runs: the same bits as runs in memory, wherever they were interrupted or killed."""

from __future__ import annotations

import json
import os
import random
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from cosim import Component, Constant, Scenario, Step, System, load_scenario, open_trajectory, ramp, simulate, stream
from cosim.cli.app import app
from cosim.drilling.oscillation import measure
from cosim.errors import CheckpointError, OutputError, RunInterruptedError, SlaveError
from cosim.recording.result import SECONDS, Result
from cosim.run import zarr_store

SHORT = {"stop_time": 3.0, "step_size": 0.01}
RUNS: dict[str, tuple[str, dict[str, Any]]] = {
    "jacobi": ("wob-law", SHORT | {"algorithm": "jacobi"}),
    "gauss-seidel": ("dissipative-law", SHORT | {"variant": "tracking", "algorithm": "gauss-seidel"}),
    "implicit": ("dissipative-law", SHORT | {"variant": "tracking", "algorithm": "implicit"}),
    "tolerance": ("dissipative-law", SHORT | {"variant": "tracking", "algorithm": "implicit", "tolerance": 1e-5}),
    "explicit tolerance": ("wob-law", SHORT | {"algorithm": "jacobi", "tolerance": 1e-3}),
    "ramp": ("ramp", SHORT),
    "tuned": ("tuned", SHORT),
    "python": ("wob-law", {"stop_time": 1.2, "step_size": 0.005, "packaging": "python"}),
    "isolated": ("wob-law", SHORT | {"stop_time": 2.0, "isolate": ["plant"]}),
}


def scenario_of(name: str) -> Scenario:
    """A scenario by name; the ramp goes on between communication points, and what is tuned are parameters."""
    if name not in ("ramp", "tuned"):
        return load_scenario(name)
    inputs = {"plant.Omega": ramp(5.0, 15.0, 0.503, 1.7), "plant.WOB": Constant(50e3)}
    if name == "tuned":
        inputs |= {"plant.c_b": ramp(0.03, 80.0, 0.2, 2.0), "plant.mu_sb": Step(0.8, 0.6, 1.234)}
    return Scenario(name, System((Component("plant", "DrillstringNeutral"),), inputs=inputs), 3.0, 0.01)


def assert_same_bits(folder: Path, whole: Result) -> None:
    """Compare what is on disk with a run in memory."""
    with open_trajectory(folder) as found:
        assert set(found.data_vars) == set(whole.names)
        np.testing.assert_array_equal(found.time.values, whole.time)
        for name in whole.names:
            assert found[name].values.dtype == whole[name].dtype
            assert found[name].values.tobytes() == whole[name].tobytes(), name


def told(record: Any) -> dict[str, Any]:
    """What a record tells, but for how long it took."""
    return {name: value for name, value in record.items() if name != "timings"}


def interrupt_at(part: float) -> Callable[[float], None]:
    """Send this process a Ctrl-C when a part of the run is done."""

    def progress(done: float) -> None:
        if done >= part:
            os.kill(os.getpid(), signal.SIGINT)

    return progress


@pytest.mark.slow
@pytest.mark.parametrize("name", RUNS)
def test_rows_on_disk_have_the_bits_of_rows_in_memory(name: str, tmp_path: Path) -> None:
    scenario, choices = scenario_of(RUNS[name][0]), RUNS[name][1]
    whole = simulate(scenario, **choices)
    end = stream(scenario, tmp_path / "run", **choices)
    assert_same_bits(tmp_path / "run", whole)
    assert told(end.record) == told(whole.record)
    assert all(end[column].tobytes() == whole[column].tobytes() for column in end.names)
    assert measure(end) == measure(whole)
    assert [entry.name for entry in (tmp_path / "run").iterdir()] == ["trajectory.zarr"]


@pytest.mark.slow
@pytest.mark.parametrize("name", RUNS)
def test_a_run_resumed_after_interrupts_has_the_bits_of_an_uninterrupted_one(name: str, tmp_path: Path) -> None:
    scenario, choices = scenario_of(RUNS[name][0]), RUNS[name][1]
    whole = simulate(scenario, **choices)
    for part in (0.1, 0.4, 0.7):
        with pytest.raises(RunInterruptedError, match=r"interrupted at t = [\d.]+ s; everything until then is in"):
            stream(scenario, tmp_path, progress=interrupt_at(part), resume=part > 0.1, **choices)
        with open_trajectory(tmp_path) as found:
            rows = found.sizes["time"]
            assert found.attrs["state"] == "interrupted"
            assert part <= found.time.values[-1] / choices["stop_time"] < 1.0
            assert all(found[name].values.tobytes() == whole[name][:rows].tobytes() for name in whole.names)
    end = stream(scenario, tmp_path, resume=True, **choices)
    assert_same_bits(tmp_path, whole)
    assert told(end.record) == told(whole.record)
    assert measure(end) == measure(whole)


def test_an_interrupt_at_the_very_end_comes_too_late(tmp_path: Path) -> None:
    end = stream(load_scenario("wob-law"), tmp_path, progress=interrupt_at(1.0), **SHORT)
    assert end.record["steps"] == 300
    assert not (tmp_path / "checkpoint.npz").exists()


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "cosim", *arguments]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_a_run_killed_at_random_moments_is_resumed_with_the_same_bits(seed: int, tmp_path: Path) -> None:
    moments = random.Random(seed)
    folder, choices = tmp_path / "run", ("--stop-time", "400", "--step-size", "0.001")
    arguments = command("run", "wob-law", "--stream", "--checkpoint", "0.05", *choices, "--output", str(folder))
    kills = 0
    while True:
        process = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        if kills < 4:
            wait_until_written(process, folder / "checkpoint.npz")
            time.sleep(moments.uniform(0.0, 0.15))
            process.kill()
        _, errors = process.communicate()
        if not (folder / "checkpoint.npz").exists():
            break  # it had come to its end, whether or not its figure was drawn before it died
        assert process.returncode == -signal.SIGKILL, errors
        kills += 1
        arguments = command("resume", str(folder))
    assert kills
    assert_same_bits(folder, simulate(load_scenario("wob-law"), stop_time=400.0, step_size=0.001))


def wait_until_written(process: subprocess.Popen[Any], path: Path) -> None:
    """Wait until the process itself has written a file, which may be there from one before it."""
    before = written_at(path)
    while process.poll() is None and written_at(path) in (None, before):
        time.sleep(0.002)


def written_at(path: Path) -> int | None:
    try:
        return path.stat().st_mtime_ns
    except FileNotFoundError:
        return None


def test_what_a_killed_run_has_left_can_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = simulate(load_scenario("wob-law"), **SHORT)
    written = zarr_store.replace_file
    chunks: list[str] = []

    def killed(path: Path, content: bytes, *, durable: bool = True) -> None:
        if path.name == "0":
            chunks.append(path.parent.name)
        if len(chunks) > 40:
            raise KeyboardInterrupt
        written(path, content, durable=durable)

    monkeypatch.setattr(zarr_store, "replace_file", killed)
    with pytest.raises(KeyboardInterrupt):
        stream(load_scenario("wob-law"), tmp_path, checkpoint_interval=0.0, **SHORT)
    assert len(set(chunks)) < 41, "expected the death within the second checkpoint"
    with open_trajectory(tmp_path) as found:
        assert 0 < found.sizes["time"] < 301
        for name in whole.names:
            assert found[name].values.tobytes() == whole[name][: found.sizes["time"]].tobytes()


def test_measures_of_a_long_run_are_those_of_its_end(tmp_path: Path) -> None:
    choices = {"stop_time": 200.0, "step_size": 0.01}
    end = stream(load_scenario("stick-slip"), tmp_path, **choices)
    assert SECONDS <= end.time[-1] - end.time[0] < SECONDS + 2.0
    assert measure(end) == measure(simulate(load_scenario("stick-slip"), **choices))


def test_columns_are_stored_as_far_apart_as_asked_for(tmp_path: Path) -> None:
    scenario = load_scenario("stick-slip")
    whole = simulate(scenario, **SHORT)
    every = {"*": 10, "plant.bit_speed": 1, "plant.energy": 0}
    with pytest.raises(RunInterruptedError):
        stream(scenario, tmp_path, every=every, progress=interrupt_at(0.4), **SHORT)
    stream(scenario, tmp_path, resume=True, **SHORT)
    with open_trajectory(tmp_path) as found:
        assert found["plant.bit_speed"].dims == ("time",)
        assert found["plant.bit_torque"].dims == ("time_10",)
        assert "plant.energy" not in found
        assert found["plant.bit_torque"].attrs["units"] == "N.m"
        np.testing.assert_array_equal(found["plant.bit_torque"].values, whole["plant.bit_torque"][::10])
        np.testing.assert_array_equal(found.time_10.values, whole.time[::10])
        assert json.loads(found.attrs["components"])["plant"]["parameters"]["I_B"] > 0.0


def test_csv_on_request_is_what_a_run_in_memory_writes(tmp_path: Path) -> None:
    scenario = load_scenario("wob-law")
    with pytest.raises(RunInterruptedError):
        stream(scenario, tmp_path, csv=True, progress=interrupt_at(0.4), **SHORT)
    stream(scenario, tmp_path, resume=True, **SHORT)
    simulate(scenario, **SHORT).to_csv(tmp_path / "whole.csv")
    assert (tmp_path / "trajectory.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def peak_memory(stop_time: str, folder: Path) -> int:
    """Greatest resident memory of a streamed run, in the units of the system."""
    arguments = command("run", "wob-law", "--stream", "--every", "100", "--step-size", "0.001")
    script = (
        "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True);"
        "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
    )
    asked = [sys.executable, "-c", script, *arguments, "--stop-time", stop_time, "--output", str(folder)]
    return int(subprocess.run(asked, check=True, capture_output=True, text=True).stdout.splitlines()[-1])


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="there is no getrusage")
def test_memory_does_not_grow_with_the_length_of_a_run(tmp_path: Path) -> None:
    short, long = peak_memory("200", tmp_path / "short"), peak_memory("4000", tmp_path / "long")
    assert long < 1.1 * short, "3.8 million rows of 23 columns more would be 600 MB"


def test_a_checkpoint_of_another_run_is_refused(tmp_path: Path) -> None:
    scenario = load_scenario("wob-law")
    with pytest.raises(RunInterruptedError):
        stream(scenario, tmp_path, progress=interrupt_at(0.4), **SHORT)
    for other, message in (
        (SHORT | {"step_size": 0.02}, r"step_size is 0\.02 now; expected 0\.01"),
        (SHORT | {"overrides": {"plant.I_B": 90.0}}, r"components\.plant\.parameters\.I_B is 90\.0 now; expected"),
        (SHORT | {"tolerance": 1e-3}, r"method\.tolerance is 0\.001 now; expected None"),
        (SHORT | {"packaging": "python"}, "packaging is 'python' now; expected 'native'"),
    ):
        with pytest.raises(CheckpointError, match=r"checkpoint\.npz is of another run: " + message):
            stream(scenario, tmp_path, resume=True, **other)
    stream(scenario, tmp_path, resume=True, **SHORT)
    with pytest.raises(CheckpointError, match="there is no such file"):
        stream(scenario, tmp_path, resume=True, **SHORT)


def test_another_run_is_not_written_over(tmp_path: Path) -> None:
    stream(load_scenario("wob-law"), tmp_path, **SHORT)
    with pytest.raises(OutputError, match=r"trajectory\.zarr is there already"):
        stream(load_scenario("wob-law"), tmp_path, **SHORT)


def guest(fmu: Path, **parameters: float) -> Scenario:
    system = System((Component("guest", fmu, parameters),), inputs={"guest.u": Constant(2.0)})
    return Scenario("guest", system, stop_time=10.0, step_size=0.1)


def test_an_fmu_without_serialised_states_is_named_and_can_be_streamed(
    probe: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with pytest.raises(RunInterruptedError) as interrupted:
        stream(guest(probe), tmp_path / "run", progress=interrupt_at(0.4))
    assert not interrupted.value.can_resume
    assert "no checkpoints, as guest cannot give a state, which lacks canSerializeFMUstate" in caplog.messages
    with open_trajectory(tmp_path / "run") as found:
        assert found.sizes["time"] > 40


def test_a_component_that_fails_leaves_the_rows_before(probe: Path, tmp_path: Path) -> None:
    scenario = guest(probe, fail_at=8.0, fail_status=3)
    with pytest.raises(SlaveError):
        stream(scenario, tmp_path / "run")
    with open_trajectory(tmp_path / "run") as found:
        assert found.attrs["state"].startswith("failed: guest at t = ")
        assert 0 < found.sizes["time"] <= 81


def test_a_thread_can_stream(tmp_path: Path) -> None:
    ends: list[Result] = []
    worker = threading.Thread(target=lambda: ends.append(stream(load_scenario("wob-law"), tmp_path, **SHORT)))
    worker.start()
    worker.join()
    assert ends[0].time[-1] == 3.0


@pytest.mark.slow
def test_the_command_line_says_how_to_resume_and_does(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    begin = command("run", "dissipative-law", "--stream", "--step-size", "0.0002", "--output", str(folder))
    process = subprocess.Popen(begin, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_until_written(process, folder / "tracking" / "trajectory.zarr" / ".zattrs")
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate()
    assert process.returncode == 130
    assert re.search(
        rf"interrupted at t = [\d.]+ s; .*; go on with: cosim resume {re.escape(str(folder))}$", errors, re.M
    )
    held = CliRunner().invoke(app, ["run", "dissipative-law", "--output", str(folder)])
    assert held.exit_code == 2
    assert "holds an unfinished run; go on with it by 'cosim resume" in held.stderr
    done = CliRunner().invoke(app, ["resume", str(folder)])
    assert done.exit_code == 0, done.output
    assert "wrote " in done.stdout
    assert "printed" in done.stdout
    manifest = json.loads((folder / "manifest.json").read_text())
    assert "state" not in manifest
    whole = simulate(load_scenario("dissipative-law"), variant="tracking", step_size=0.0002)
    assert_same_bits(folder / "tracking", whole)
    again = CliRunner().invoke(app, ["resume", str(folder)])
    assert again.exit_code == 2
    assert "holds no unfinished run" in again.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--every", "3"], "--every is for streamed runs; expected --stream as well"),
        (["--stream", "--every", "plant.*"], "--every plant.*: expected a number of rows, or the form pattern=number"),
        (["--stream", "--every", "plat.*=2"], "every: there is no 'plat.*'"),
    ],
)
def test_options_that_make_no_sense_are_refused(arguments: list[str], message: str, tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["run", "stick-slip", *arguments, "--output", str(tmp_path / "run")])
    assert result.exit_code == 2
    assert message in result.stderr
    assert "Traceback" not in result.output
    assert list(tmp_path.iterdir()) == [], "what was refused leaves nothing behind"


def test_a_folder_that_holds_no_unfinished_run_is_not_resumed(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "manifest.json").write_text("{")
    for name, message in (
        ("nowhere", "nowhere holds no unfinished run"),
        ("file", "cannot be read: Not a directory"),
        ("broken", "manifest.json is not JSON"),
    ):
        result = CliRunner().invoke(app, ["resume", str(tmp_path / name)])
        assert result.exit_code == 2
        assert message in result.stderr


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda told: told.pop("created"), "'created' is missing"),
        (lambda told: told["job"].pop("choices"), "'choices' is missing"),
        (lambda told: told["job"]["choices"].update(colour="red"), "colour"),
        (lambda told: told.update(variants=3), "not iterable"),
        (lambda told: told.update(job="resume me"), "job: Input should be a valid dictionary"),
        (lambda told: told.update(variants=[{}]), "is missing"),
    ],
)
def test_a_damaged_manifest_is_a_sentence(damage: Callable[[Any], Any], message: str, tmp_path: Path) -> None:
    job = {"source": "stick-slip", "choices": {"limits": None, "overrides": None}, "variants": [], "labels": []}
    job["streaming"] = {"every": {}, "csv": False, "checkpoint_interval": 1.0}
    head = {"scenario": "a", "title": "", "created": "", "versions": {}, "commit": None}
    told: dict[str, Any] = {"format": "cosim-run-1", **head, "state": "unfinished", "job": job, "variants": []}
    damage(told)
    (tmp_path / "manifest.json").write_text(json.dumps(told))
    result = CliRunner().invoke(app, ["resume", str(tmp_path)])
    assert result.exit_code == 2, result.output
    assert "manifest.json is damaged: " in result.stderr
    assert message in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_streamed_run_that_fails_at_its_start_leaves_nothing(
    make_probe: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_probe(replace={'guid="': 'guid="not '})
    (tmp_path / "probing.toml").write_text(
        'stop_time = 1.0\nstep_size = 0.125\n[components.probe]\nfmu = "probe.fmu"\n[inputs]\n"probe.u" = 2.0\n'
    )
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.iterdir())
    result = CliRunner().invoke(app, ["run", "probing.toml", "--stream", "--output", "new/run"])
    assert result.exit_code != 0
    assert sorted(tmp_path.iterdir()) == before


def test_a_store_that_cannot_be_begun_leaves_no_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*given: object) -> None:
        raise OutputError("the disk is full")

    monkeypatch.setattr("cosim.run.stream.create_zarr", fail)
    with pytest.raises(OutputError, match="the disk is full"):
        stream(load_scenario("stick-slip"), tmp_path / "new" / "run", stop_time=1.0)
    assert list(tmp_path.iterdir()) == []


def test_a_streamed_run_follows_a_link_and_stays_when_it_is_complete(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("runs").symlink_to("disk")
    arguments = ["run", "stick-slip", "--stop-time", "1", "--output", "runs"]
    assert CliRunner().invoke(app, [*arguments, "--stream"]).exit_code == 0
    assert Path("runs").is_symlink()
    again = CliRunner().invoke(app, arguments)
    assert again.exit_code == 2
    assert "holds a finished streamed run" in again.stderr
    assert Path("disk", "trajectory.zarr").is_dir()
