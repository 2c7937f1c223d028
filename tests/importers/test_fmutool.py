"""The FMUs in the FMU Manipulation Toolbox: checked, listed, renamed, and coupled in containers that fmpy simulates."""

from __future__ import annotations

import csv
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from cosim.system.structure import System
from fmu_src.fmus import MODELS
from tests.importers.container import make_container
from tests.importers.loop import multiples, once_in_order, run
from tests.importers.systems import (
    LOOP,
    NATIVE,
    OPEN_START,
    assert_same_bits,
    ordered,
    our_run,
    outputs,
    system_of,
)

pytestmark = pytest.mark.slow

PLANT = NATIVE / "DrillstringNeutral.fmu"
FINE = 1.0 / 1024
"""A step [s] whose multiples are exact."""
STEPS = 5120


def fmutool(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """Run the command line tool."""
    command = [Path(sys.executable).with_name("fmutool"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def assert_check_is_clean(path: Path) -> None:
    done = fmutool("-input", path, "-check")
    assert [line for line in (done.stdout + done.stderr).splitlines() if not line.startswith("INFO")] == []
    assert done.returncode == 0
    assert "This FMU seems to be compliant with FMI-2.0." in done.stdout
    assert "No semantic error against the FMI-2 standard." in done.stdout


@pytest.mark.parametrize("packaging", ["native", "python"])
@pytest.mark.parametrize("model", MODELS)
def test_check_finds_nothing(model: str, packaging: str) -> None:
    assert_check_is_clean(NATIVE.parent / packaging / f"{model}.fmu")


def test_check_finds_a_fault(tmp_path: Path) -> None:
    spoiled = tmp_path / "Spoiled.fmu"
    with zipfile.ZipFile(PLANT) as source, zipfile.ZipFile(spoiled, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            if name == "modelDescription.xml":
                content = content.replace(b'causality="output"', b'causality="input"', 1)
            target.writestr(name, content)
    done = fmutool("-input", spoiled, "-check")
    assert done.returncode != 0
    assert "ERROR" in done.stdout


def test_all_variables_are_listed(tmp_path: Path) -> None:
    assert fmutool("-input", PLANT, "-dump-csv", tmp_path / "ports.csv").returncode == 0
    with (tmp_path / "ports.csv").open(newline="") as file:
        listed = [row[0] for row in csv.reader(file, delimiter=";")][1:]
    assert listed == [variable.name for variable in fmpy.read_model_description(PLANT).modelVariables]


def test_a_renamed_fmu_gives_the_same_bits(tmp_path: Path) -> None:
    with (tmp_path / "names.csv").open("w", newline="") as file:
        csv.writer(file, delimiter=";").writerows([("name", "newName"), ("bit_speed", "rpm.bit"), ("WOB", "load")])
    renamed = tmp_path / "Renamed.fmu"
    fmutool("-input", PLANT, "-rename-from-csv", tmp_path / "names.csv", "-output", renamed)
    assert_check_is_clean(renamed)
    found = fmpy.simulate_fmu(
        str(renamed), stop_time=10.0, output_interval=1 / 128, output=["rpm.bit"], start_values={"load": 31649.0}
    )
    ours = our_run("lower-wob", None, 1 / 128, 1280)
    assert_same_bits({"plant.bit_speed": np.ascontiguousarray(found["rpm.bit"])}, ours)


def test_outputs_that_are_not_real_can_be_removed(tmp_path: Path) -> None:
    description = fmpy.read_model_description(PLANT)
    unwanted = [v.name for v in description.modelVariables if v.causality == "output" and v.type != "Real"]
    assert "bit_stuck" in unwanted
    reduced = tmp_path / "DrillstringNeutral.fmu"
    fmutool("-input", PLANT, "-only-outputs", "-remove-regexp", "|".join(unwanted), "-output", reduced)
    assert_check_is_clean(reduced)
    assert validate_fmu(str(reduced)) == []
    left = {v.name for v in fmpy.read_model_description(reduced).modelVariables}
    assert left == {v.name for v in description.modelVariables} - set(unwanted)
    found = fmpy.simulate_fmu(str(reduced), stop_time=10.0, output_interval=1 / 128, output=["bit_speed"])
    ours = our_run("stick-slip", None, 1 / 128, 1280)
    assert_same_bits({"plant.bit_speed": np.ascontiguousarray(found["bit_speed"])}, ours)


def simulated(system: System, folder: Path, *, sequential: bool) -> dict[str, np.ndarray]:
    """Couple a system in a container, step that by fmpy, and return all outputs by ``component.variable``."""
    container = make_container(system, folder, FINE, sequential=sequential)
    assert_check_is_clean(container)
    assert validate_fmu(str(container)) == []
    names = [f"{component}.{v.name}" for component, variables in outputs(system).items() for v in variables]
    found = fmpy.simulate_fmu(str(container), stop_time=STEPS * FINE, output_interval=FINE, output=names)
    return {name: np.ascontiguousarray(found[name]) for name in names}


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize(("scenario", "variant"), OPEN_START)
def test_a_container_repeats_our_master(scenario: str, variant: str | None, algorithm: str, tmp_path: Path) -> None:
    ours = our_run(scenario, variant, FINE, STEPS, algorithm)
    system = ordered(system_of(scenario, variant), ours.record["order"])
    assert_same_bits(simulated(system, tmp_path, sequential=algorithm == "gauss-seidel"), ours)


@pytest.mark.parametrize("sequential", [False, True])
@pytest.mark.parametrize(("scenario", "variant"), LOOP)
def test_a_container_starts_a_loop_from_zero(
    scenario: str, variant: str | None, sequential: bool, tmp_path: Path
) -> None:
    system = ordered(system_of(scenario, variant), ("program", "plant", "law"))
    start = once_in_order(("program", "plant", "law"))
    found = simulated(system, tmp_path, sequential=sequential)
    assert_same_bits(found, run(system, multiples(FINE, STEPS), start, sequential=sequential))
