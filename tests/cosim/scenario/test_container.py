"""A scenario as one FMU, in another tool: the numbers of our master by the same algorithm."""

from __future__ import annotations

import zipfile
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from typer.testing import CliRunner

from cosim import Component, Scenario, Step, System, load_scenario, simulate
from cosim.cli.app import app
from cosim.errors import InputError
from cosim.fmi2.locate import locate_fmu
from cosim.fmi2.model_description import read_description
from cosim.recording.result import Result
from cosim.scenario.container import container_files, export_container
from cosim.system.method import Method

pytestmark = pytest.mark.slow

STEP = 1.0 / 512
"""A step [s] whose multiples are exact: importers that add up times meet ours."""
STEPS = 2560


def stepped(name: str, algorithm: str) -> Scenario:
    """A scenario in exact steps."""
    return replace(load_scenario(name), step_size=STEP, stop_time=STEPS * STEP, method=Method(algorithm))


def simulated(path: Path, **options: object) -> dict[str, np.ndarray]:
    """Run a container by fmpy, and return its outputs."""
    outputs = [variable.name for variable in read_description(path).with_causality("output")]
    found = fmpy.simulate_fmu(str(path), stop_time=STEPS * STEP, output_interval=STEP, output=outputs, **options)
    return {name: np.ascontiguousarray(found[name]) for name in outputs}


def assert_outputs(found: dict[str, np.ndarray], expected: Result) -> None:
    assert found
    for name, values in found.items():
        assert values.astype(expected[name].dtype).tobytes() == expected[name].tobytes(), name


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize(
    ("name", "variant"), [("stick-slip", None), ("bit-damping", "c_b=65"), ("wob-law", None)]
)  # fmt: skip
def test_a_container_gives_the_bits_of_our_master(
    name: str, variant: str | None, algorithm: str, tmp_path: Path
) -> None:
    scenario = stepped(name, algorithm)
    export_container(scenario, tmp_path / "Whole.fmu", variant=variant)
    assert validate_fmu(str(tmp_path / "Whole.fmu")) == []
    assert_outputs(simulated(tmp_path / "Whole.fmu"), simulate(scenario, variant=variant))


def test_inputs_of_a_container_are_those_nothing_drives(tmp_path: Path) -> None:
    scenario = stepped("wob-law", "gauss-seidel")
    export_container(scenario, tmp_path / "Whole.fmu")
    description = read_description(tmp_path / "Whole.fmu")
    (omega,) = description.with_causality("input")
    assert (omega.name, omega.start) == ("Omega", "10.0")
    assert omega.unit == read_description(locate_fmu("DrillstringNeutral", "native")).by_name["Omega"].unit
    faster = np.array([(0.0, 20.0)], dtype=[("time", float), ("Omega", float)])
    found = simulated(tmp_path / "Whole.fmu", input=faster)
    assert_outputs(found, simulate(scenario, overrides={"plant.Omega": 20.0}))


def test_inputs_set_before_initialization_mode_are_overwritten(tmp_path: Path) -> None:
    """What the toolbox's library does; the documentation says so."""
    export_container(stepped("wob-law", "gauss-seidel"), tmp_path / "Whole.fmu")
    found = simulated(tmp_path / "Whole.fmu", start_values={"Omega": 20.0})
    assert_outputs(found, simulate(stepped("wob-law", "gauss-seidel")))


def test_signals_that_change_are_inside(tmp_path: Path) -> None:
    """A step at a communication point takes effect there, by Jacobi; "far" is driven by its own program."""
    system = System(
        (Component("near", "DrillstringNeutral"), Component("far", "DrillstringNeutral", {"L": 2000.0})),
        inputs={"near.WOB": Step(20000.0, 97347.0, 1.0), "far.WOB": Step(97347.0, 20000.0, 2.0)},
    )
    scenario = Scenario("two", system, STEPS * STEP, STEP)
    export_container(scenario, tmp_path / "Whole.fmu")
    inputs = read_description(tmp_path / "Whole.fmu").with_causality("input")
    assert [variable.name for variable in inputs] == ["near.Omega", "far.Omega"]
    found, expected = simulated(tmp_path / "Whole.fmu"), simulate(scenario)
    for name in expected.names:
        if name in found:
            assert found[name].astype(expected[name].dtype).tobytes() == expected[name].tobytes(), name


def test_a_loop_starts_from_zero_and_is_named(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    scenario = stepped("dissipative-law", "gauss-seidel")
    export_container(scenario, tmp_path / "Whole.fmu", variant="tracking")
    (record,) = caplog.records
    assert record.getMessage() == (
        "a container starts the loop plant.Omega -> plant.top_speed -> law.top_speed -> law.Omega -> plant.Omega "
        "from zero, and does not settle it"
    )
    found = fmpy.simulate_fmu(str(tmp_path / "Whole.fmu"), stop_time=60.0, output_interval=STEP)
    assert found["plant.top_speed"][0] == 0.0
    assert found["plant.bit_speed"][-1] == pytest.approx(10.0, abs=1e-6)


def test_the_same_scenario_gives_the_same_bytes(tmp_path: Path) -> None:
    scenario = stepped("wob-law", "jacobi")
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        export_container(scenario, tmp_path / name / "Whole.fmu")
    assert (tmp_path / "a" / "Whole.fmu").read_bytes() == (tmp_path / "b" / "Whole.fmu").read_bytes()


def test_a_container_has_the_platforms_of_all_its_fmus(tmp_path: Path) -> None:
    scenario = stepped("wob-law", "jacobi")
    export_container(scenario, tmp_path / "Whole.fmu")
    with zipfile.ZipFile(tmp_path / "Whole.fmu") as archive:
        names = archive.namelist()
    assert names[0] == "modelDescription.xml"
    outer = {name.split("/")[1] for name in names if name.startswith("binaries/")}
    inner = {name.split("/")[3] for name in names if name.startswith("resources/00/binaries/")}
    assert outer
    assert outer <= inner


def test_repeated_steps_are_refused() -> None:
    scenario = stepped("stick-slip", "implicit")
    with pytest.raises(InputError, match=r"^a container couples by jacobi or gauss-seidel; the algorithm is implicit$"):
        container_files(scenario, "Whole", "native")


def test_steps_of_variable_size_are_refused() -> None:
    scenario = replace(stepped("stick-slip", "jacobi"), method=Method(tolerance=1e-3))
    with pytest.raises(InputError, match=r"^a container takes steps of one size; the tolerance is 0\.001$"):
        container_files(scenario, "Whole", "native")


def test_the_command_writes_a_container(tmp_path: Path) -> None:
    arguments = ["export", "bit-damping", "--container", str(tmp_path / "65 Nms.fmu"), "--set", "plant.c_b=65"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert read_description(tmp_path / "65 Nms.fmu").model_identifier == "_65_Nms"
    result = CliRunner().invoke(app, ["export", "bit-damping"])
    assert result.exit_code == 2
    assert result.stderr.strip() == "error: nothing to write; expected FILE.ssp or --container FILE.fmu"
