"""A run of two variants and 10,001 rows, a sweep of six points, and a league of two laws, each in its folder."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from cosim import RunOptions, load_scenario
from cosim.cli.app import app
from cosim.run.job import Job, run_job
from cosim.run.report import write_content
from tests.cosim.run.jobs import nothing, sketch

SCENARIO = """
title = "Two weights"
stop_time = 100.0
step_size = 0.01
components.plant.fmu = "DrillstringNeutral"

[[variants]]
name = "light"
set = { "plant.WOB" = 3e4, "plant.Omega" = 10.0 }

[[variants]]
name = "heavy"
set = { "plant.WOB" = 97347.0, "plant.Omega" = 10.0 }
"""
ABOUT = {
    "title": "A small league", "versions": {"python": "3.11.7"}, "commit": None, "settle": 60.0, "judge": 90.0,
    "step_size": 0.01, "conditions": {"nominal": "10 rad/s", "slow": "7 rad/s"},
    "laws": {
        "ordinary": {"title": "holds its speed", "fmu": "", "parameters": {}},
        "soft": {"title": "SoftTorque", "fmu": "SoftTorque", "parameters": {"law.P": 450.0}},
    },
}  # fmt: skip
SCORES = """\
law,condition,time_to_free,stuck_fraction,ssi,mean_bit_speed,mean_top_speed,peak_bit_speed,least_bit_speed,\
greatest_torque,drive_swing,dip,penetration,energy_per_turn,switched,failure
ordinary,nominal,inf,0.46,1.64,5.7,5.9,18.8,0.0,13258.0,0.0,,9.2,90.8,True,
ordinary,slow,inf,0.7,2.8,3.0,3.1,15.0,0.0,12900.0,0.0,,5.1,120.0,True,
soft,nominal,2.7,0.0,4e-07,10.0,10.0,11.0,0.5,11000.0,2.0,,16.0,50.0,True,
soft,slow,,,,,,,,,,,,,True,the motor burnt
"""


@pytest.fixture(scope="session")
def run_of_two(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    scenario = folder / "weights.toml"
    scenario.write_text(SCENARIO, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cosim.drilling.reporting.draw", sketch)
        run_job(Job(load_scenario(scenario), RunOptions(), (), None), folder / "run", nothing)
    return folder / "run"


@pytest.fixture(scope="session")
def sweep_of_six(tmp_path_factory: pytest.TempPathFactory) -> Path:
    store = tmp_path_factory.mktemp("sweep") / "map.zarr"
    grids = ("--grid", "plant.Omega=5,15", "--grid", "plant.WOB=2e4:1e5:3")
    done = CliRunner().invoke(app, ["sweep", "stick-slip", *grids, "--workers", "1", "--output", str(store)])
    assert done.exit_code == 0, done.output
    return store


SWEEPS = {
    "plane": ["--grid", "plant.Omega=9,13", "--grid", "plant.WOB=6e4,97347"],
    "line": ["--grid", "plant.Omega=5,15"],
    "cube": ["--grid", "plant.c_b=60,0.03", "--grid", "plant.Omega=5:15:3", "--grid", "plant.WOB=2e4,1e5"],
    "refused": ["--grid", "plant.mu_sb=0.1,0.8", "--grid", "plant.Omega=5,15", "--grid", "plant.WOB=2e4,1e5"],
    "samples": ["--sample", "plant.mu_sb=0.6:1", "--count", "8"],
    "maybe": [
        "--grid",
        "plant.Omega=5,15",
        "--grid",
        "plant.WOB=2e4,1e5",
        "--sample",
        "plant.mu_sb=0.6:1",
        "--count",
        "4",
    ],
    "linemaybe": ["--grid", "plant.Omega=5,15", "--sample", "plant.mu_sb=0.6:1", "--count", "4"],
    "kept": [
        "--grid",
        "plant.Omega=5:17:4",
        "--grid",
        "plant.WOB=2e4,1e5",
        "--keep",
        "plant.bit_speed",
        "--keep",
        "plant.bit_torque",
        "--keep-points",
        "4",
    ],
    "keptline": [
        "--grid",
        "plant.Omega=5,15",
        "--sample",
        "plant.mu_sb=0.6:1",
        "--count",
        "4",
        "--keep",
        "plant.bit_speed",
    ],
    "long": ["--grid", "plant.Omega=9,13", "--keep", "plant.bit_speed", "--keep-points", "1", "--keep-every", "0.0006"],
    "failing": ["--grid", "plant.I_B=311,1e-3", "--grid", "plant.WOB=2e4,1e5"],
    "packagings": ["--grid", "plant=DrillstringNeutral,DrillstringDistributed", "--grid", "plant.WOB=2e4,1e5"],
}


@pytest.fixture(scope="session")
def sweeps(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Return what runs one of `SWEEPS`, once, with more words of the command perhaps."""
    folder = tmp_path_factory.mktemp("sweeps")

    def run(name: str, *more: str) -> Path:
        store = folder / f"{'-'.join([name, *more]).replace('--', '')}.zarr"
        words = [*SWEEPS[name], *more, "--stop-time", "40", "--workers", "1", "--output", str(store)]
        done = CliRunner().invoke(app, ["sweep", "stick-slip", *words])
        assert done.exit_code == 0, done.output
        return store

    return run


@pytest.fixture
def league(tmp_path: Path) -> Path:
    folder = tmp_path / "league"
    folder.mkdir()
    (folder / "league.json").write_text(json.dumps(ABOUT))
    (folder / "scores.csv").write_text(SCORES)
    (folder / "limits.csv").write_text("law,search,value,beyond\nordinary,lag,,False\nsoft,lag,0.4,True\n")
    return folder


def changed(run: Path, folder: Path, change: Any) -> Path:
    """Copy a run, with what its manifest tells changed."""
    content = json.loads((run / "manifest.json").read_text())
    for variant in content["variants"]:
        target = folder / variant["trajectory"]
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes((run / variant["trajectory"]).read_bytes())
    change(content)
    write_content(folder, {name: value for name, value in content.items() if name not in ("sha256", "format")})
    return folder
