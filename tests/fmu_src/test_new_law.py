"""A law of two files in a folder of its own is an FMU like every other: nothing else is told of it."""

from __future__ import annotations

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fmu_src import project
from tests.once import built_once
from tests.plant.drive import Drive

LAW = Path(__file__).with_name("LowPassLaw")
KEPT = ("build_fmu.py", "cosim", "fmu_src", "LICENSE", "models", "pyproject.toml", "README.md", "setup.py", "tests")
EVERY_FMU = ("fmu_src", "plant", "theory/test_apart_from_fmus.py", "test_import_rules.py", "cosim/check")
"""Where tests run over all FMUs."""


@pytest.fixture(scope="module")
def tree(run_folder: Path) -> Path:
    """A copy of the checkout with the folder of one more law in it, and its FMUs beside the others."""

    def build(folder: Path) -> None:
        skip = shutil.ignore_patterns("__pycache__", "built")
        for name in KEPT:
            copy = shutil.copytree if (project.ROOT / name).is_dir() else shutil.copy
            copy(project.ROOT / name, folder / name, **({"ignore": skip} if copy is shutil.copytree else {}))
        shutil.copytree(project.ROOT / "dist", folder / "dist")
        shutil.copytree(LAW, folder / "fmu_src" / "fmus" / LAW.name, ignore=skip)
        done = in_tree(folder, "build_fmu.py", LAW.name)
        assert done.returncode == 0, done.stderr

    return built_once(run_folder / "one-more-law", build)


def in_tree(tree: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python in the copy, which is then what is imported."""
    ours = {"PYTHONPATH": str(tree), "NO_COLOR": "1", "COLUMNS": "200"}
    ours["ZIG_GLOBAL_CACHE_DIR"] = str(project.ROOT / "build" / "zig" / "global")
    return subprocess.run(
        [sys.executable, *arguments], cwd=tree, env=os.environ | ours, capture_output=True, text=True, check=False
    )


def test_it_is_two_files() -> None:
    assert sorted(path.name for path in LAW.iterdir() if path.is_file()) == ["interface.py", "model.c"]


@pytest.mark.slow
def test_it_is_listed_with_the_others(tree: Path) -> None:
    done = in_tree(tree, "-m", "cosim", "fmus")
    assert done.returncode == 0, done.stderr
    assert LAW.name in done.stdout


@pytest.mark.slow
def test_it_passes_what_every_fmu_passes(tree: Path) -> None:
    places = [f"tests/{place}" for place in EVERY_FMU]
    options = ["-q", "-p", "no:cacheprovider", "-k", f"{LAW.name} and not test_new_law", "-m", "not cross_build"]
    done = in_tree(tree, "-m", "pytest", *options, *places)
    assert done.returncode == 0, done.stdout[-3000:]
    assert int(done.stdout.rsplit(" passed", 1)[0].split()[-1]) > 50, done.stdout[-300:]


@pytest.mark.slow
def test_both_packagings_give_the_same_bits(tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.plant.fmi.DIST", tree / "dist")
    random = np.random.default_rng(7)
    asked, sizes = random.uniform(-60.0, 60.0, 200), random.uniform(1e-4, 3.0, 200)
    rows = []
    for packaging in ("native", "python"):
        with Drive(LAW.name, {"speed_ref": 5.0}, packaging) as law:
            row = [law.outputs()]
            for speed, size in zip(asked.tolist(), sizes.tolist(), strict=True):
                law.put(speed_ref=speed)
                law.go(law.time + size)
                row.append(law.outputs())
        rows.append(np.array(row))
    assert rows[0].tobytes() == rows[1].tobytes()
    assert {0.0, 1.0} == set(rows[0][:, -1])


SCENARIO = f"""
title = "Rotation run up through a filter"
stop_time = 4.0
step_size = 0.01
algorithm = "gauss-seidel"

connections = [
    {{ from = "program.speed_ref", to = "law.speed_ref" }},
    {{ from = "program.WOB", to = "plant.WOB" }},
    {{ from = "law.Omega", to = "plant.Omega" }},
]

[components.program]
fmu = "DrillingProgram"
parameters = {{ speed_initial = 4.0, speed_final = 12.0, speed_start = 1.0 }}

[components.law]
fmu = "{LAW.name}"

[components.plant]
fmu = "DrillstringNeutral"
"""


@pytest.mark.slow
@pytest.mark.parametrize("packaging", ["native", "python"])
def test_it_couples_with_program_and_plant(tree: Path, tmp_path: Path, packaging: str) -> None:
    (tmp_path / "filter.toml").write_text(SCENARIO, encoding="utf-8")
    options = ["--packaging", packaging, "--output", str(tmp_path / "run")]
    done = in_tree(tree, "-m", "cosim", "run", str(tmp_path / "filter.toml"), *options)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "run" / "trajectory.csv").open(encoding="utf-8", newline="") as file:
        omega = {float(row["time"]): float(row["law.Omega"]) for row in csv.DictReader(file)}
    assert omega[0.5] == 4.0
    # the implicit rule of Euler takes a factor off what is left in every step
    assert (12.0 - omega[3.0]) / (12.0 - omega[2.0]) == pytest.approx((2.0 / 2.01) ** 100, rel=1e-12)
