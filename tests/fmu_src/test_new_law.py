"""A law of two files in a folder of its own is an FMU like every other: nothing else is told of it."""

from __future__ import annotations

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from fmu_src import project
from tests.once import built_once
from tests.plant.drive import Drive
from tests.plant.fmi import Instance, must

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
    # tests in the copy are a run of their own, not part of that of the worker that starts them
    inherited = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    return subprocess.run(
        [sys.executable, *arguments], cwd=tree, env=inherited | ours, capture_output=True, text=True, check=False
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
    options = ["-p", "no:cacheprovider", "-k", f"{LAW.name} and not test_new_law", "-m", "not cross_build"]
    done = in_tree(tree, "-m", "pytest", *options, *places)
    assert done.returncode == 0, done.stdout[-3000:]
    assert int(done.stdout.rsplit(" passed", 1)[0].split()[-1]) > 50, done.stdout[-300:]


@pytest.mark.slow
def test_its_derivatives_are_those_of_its_filter(tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tests.plant.fmi.DIST", tree / "dist")
    with Instance(LAW.name) as law:
        must(law, law.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0))
        must(law, law.call("EnterInitializationMode"))
        assert law.sensitivity("Omega", speed_ref=1.0) == 1.0
    with Drive(LAW.name, {"speed_ref": 10.0, "time_constant": 4.0}) as law:
        law.put(speed_ref=30.0)
        law.go(1.0)
        # one step of 1 s takes it a fifth of the way from 10 to 30
        assert (law.get("Omega"), law.rate("Omega")) == (14.0, 4.0)
        assert law.sensitivity("Omega", speed_ref=1.0) == 0.0
        must(law, law.set_slopes(speed_ref=10.0))
        law.go(2.0)
        assert (law.get("Omega"), law.rate("Omega")) == (pytest.approx(19.2, rel=1e-14), pytest.approx(5.2, rel=1e-14))
        law.put(Omega_max=5.0)
        law.go(3.0)
        assert (law.get("Omega"), law.rate("Omega"), law.get("limit_active")) == (5.0, 0.0, 1)


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
