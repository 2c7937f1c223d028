"""The commands that run sweeps and draw maps, and what they say of mistakes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cosim import open_series, open_sweep, sweep
from cosim.cli.app import app
from tests.cosim.sweeps.test_store import content

USUAL = ["sweep", "stick-slip", "--grid", "plant.Omega=6:14:3", "--grid", "plant.WOB=3e4,97347", "--workers", "1"]


def cosim(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, list(arguments))
    return result.exit_code, " ".join(result.output.split())


def test_a_sweep_is_run_and_its_map_is_drawn(tmp_path: Path) -> None:
    store, figure = str(tmp_path / "map.zarr"), str(tmp_path / "map.png")
    code, said = cosim(*USUAL, "--stop-time", "30", "--output", store)
    assert (code, said) == (0, f"6 points (3 x 2), 0 failed wrote {store}")
    assert open_sweep(store)["ssi"].shape == (3, 2)
    assert cosim("map", store, "--folds", "0") == (0, f"wrote {figure}")
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")
    again = str(tmp_path / "less.png")
    assert cosim("map", store, "--minus", store, "--units", "field", "--folds", "0", "--output", again)[0] == 0


def test_a_map_of_the_folder_one_is_in_lies_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code, _ = cosim(*USUAL, "--stop-time", "20", "--output", str(tmp_path / "map.zarr"))
    assert code == 0
    monkeypatch.chdir(tmp_path / "map.zarr")
    assert cosim("map", ".", "--folds", "0") == (0, f"wrote {tmp_path / 'map.png'}")


def test_samples_are_one_dimension(tmp_path: Path) -> None:
    store = str(tmp_path / "s.zarr")
    drawn = ["--sample", "plant.Omega=4:16", "--sample", "plant.c_b=0.01:0.1", "--count", "4", "--sampling", "sobol"]
    code, said = cosim("sweep", "stick-slip", *drawn, "--stop-time", "20", "--workers", "1", "--output", store)
    assert (code, said) == (0, f"4 points (4), 0 failed wrote {store}")
    assert open_sweep(store)["plant.c_b"].dims == ("sample",)
    code, said = cosim("map", store)
    assert (code, said) == (2, "error: the sweep is over sample; expected two axes of numbers for a map")


def test_parameters_are_taken_from_a_file(tmp_path: Path) -> None:
    file, store = tmp_path / "tuned.toml", tmp_path / "s.zarr"
    file.write_text('fmu = "WeightOnBitLaw"\n[parameters]\nK_w = 7.5\nWOB_max = 1.9e5\n')
    usual = ["--parameters", str(file), "--set", "law.WOB_max=1.8e5", "--stop-time", "20", "--workers", "1"]
    code, said = cosim("sweep", "wob-law", "--grid", "plant.Omega=9", *usual, "--output", str(store))
    assert (code, said) == (0, f"1 point (1), 0 failed wrote {store}")
    law = json.loads(open_sweep(store).attrs["record"])["components"]["law"]["parameters"]
    assert (law["K_w"], law["WOB_max"]) == (7.5, 1.8e5)


def test_outputs_are_kept_over_time(tmp_path: Path) -> None:
    kept = ["--keep", "plant.bit_speed", "--keep-every", "500 ms", "--keep-points", "4", "--stop-time", "20"]
    code, _ = cosim(*USUAL, *kept, "--output", str(tmp_path / "s.zarr"))
    assert code == 0
    found = open_series(tmp_path / "s.zarr")["plant.bit_speed"]
    assert found.shape == (2, 2, 41)
    assert cosim("map", str(tmp_path / "s.zarr"), "--folds", "0")[0] == 0


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--grid", "plant.Omga=6:14:3"], "plant: DrillstringNeutral has no variable 'Omga'; did you mean 'Omega'?"),
        (["--grid", "plant.Omega=14:6:3"], "plant.Omega=14:6:3: the range is reversed; expected 6:14:3"),
        (["--grid", "plant.Omega"], "--grid plant.Omega: expected the form component.variable=values"),
        (
            ["--grid", "plant.WOB=1,2", "--grid", "plant.WOB=3"],
            "--grid plant.WOB=3: plant.WOB is varied twice; expected each name once",
        ),
        ([], "there is nothing to vary; expected a grid or samples"),
        (
            ["--grid", "plant.WOB=1,2", "--stop-time", "5"],
            "points are run for 5 s; expected 20 s, which are measured, or more",
        ),
        (["--grid", "plant.WOB=1,2", "--branch", "sideways"], "there is no branch 'sideways'; known: down, rest, up"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_sentence(tmp_path: Path, arguments: list[str], sentence: str) -> None:
    code, said = cosim("sweep", "stick-slip", *arguments, "--output", str(tmp_path / "s.zarr"))
    assert (code, said) == (2, f"error: {sentence}")
    assert not (tmp_path / "s.zarr").exists()


def test_too_little_memory_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr("cosim.sweeps.sweep.sweep", full)
    code, said = cosim(*USUAL, "--output", str(tmp_path / "s.zarr"))
    assert (code, said) == (1, "error: there is not enough memory for what is asked for")


def test_the_first_failure_is_told(tmp_path: Path) -> None:
    grid = ["--grid", "plant.I_B=311,0.001"]
    code, said = cosim(
        "sweep", "stick-slip", *grid, "--stop-time", "20", "--workers", "1", "--output", str(tmp_path / "s.zarr")
    )
    assert code == 0
    assert said.startswith("2 points (2), 1 failed the first that failed: plant at t = 0.00 s: ")


@pytest.mark.slow
def test_a_sweep_is_interrupted_and_gone_on_with_by_the_same_command(tmp_path: Path) -> None:
    grid = ["--grid", "plant.Omega=4:16:20", "--grid", "plant.WOB=2e4:1.4e5:20", "--workers", "2"]

    command = [sys.executable, "-m", "cosim", "sweep", "stick-slip", *grid, "--output", str(tmp_path / "s.zarr")]
    interrupted = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    journal = tmp_path / "s.zarr" / ".journal"
    while interrupted.poll() is None and not (journal.exists() and journal.stat().st_size):
        time.sleep(0.02)
    os.kill(interrupted.pid, signal.SIGINT)
    _, said = interrupted.communicate()
    assert interrupted.returncode == 130
    assert said.startswith("interrupted after ")
    assert said.endswith(f" of 400 points, which are in {tmp_path / 's.zarr'}; the same command goes on with it\n")
    subprocess.run(command, check=True, capture_output=True)
    sweep(
        "stick-slip", tmp_path / "whole.zarr", grid={"plant.Omega": "4:16:20", "plant.WOB": "2e4:1.4e5:20"}, workers=1
    )
    assert content(tmp_path / "s.zarr") == content(tmp_path / "whole.zarr")
