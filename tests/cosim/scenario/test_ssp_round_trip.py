"""Scenarios through .ssp files and back: nothing is lost, in our master or under the standard's schemas."""

from __future__ import annotations

import importlib.resources
import re
import zipfile
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
import xmlschema
from typer.testing import CliRunner

from cosim import (
    Component,
    Connection,
    Constant,
    PowerBond,
    Ramp,
    Scenario,
    Step,
    System,
    Table,
    load_scenario,
    ramp,
    simulate,
)
from cosim.cli.app import app
from cosim.errors import SspError
from cosim.fmi2.locate import locate_fmu
from cosim.fmi2.model_description import read_description
from cosim.recording.result import Result
from cosim.scenario.file import scenario_names
from cosim.scenario.ssp.program import as_components, as_signals
from cosim.scenario.ssp.reading import open_ssp
from cosim.scenario.ssp.writing import export_ssp
from cosim.system.method import Method
from cosim.system.signals import Signal

pytestmark = pytest.mark.slow

SCHEMAS = importlib.resources.files("fmpy") / "ssp" / "schema"


def changing(scenario: Scenario) -> list[str]:
    """Return what changes in it that a system description has no room for: switches, and parameters."""
    asked = ("Omega", "WOB", "speed_ref", "bit_speed_ref")
    inputs = scenario.system.inputs
    return [port for port, signal in inputs.items() if port.variable not in asked and signal.held is None]


ALL = [load_scenario(name) for name in scenario_names()]
LOADED = [scenario for scenario in ALL if not changing(scenario)]
CHANGING = [scenario for scenario in ALL if changing(scenario)]
RUNS = [(scenario.name, variant.name) for scenario in LOADED for variant in scenario.variants]
RUNS += [(scenario.name, None) for scenario in LOADED if not scenario.variants]
SHORT = 6.0
"""Long enough [s] for releases and stops of the bit in every scenario."""


def assert_equal_runs(actual: Result, expected: Result) -> None:
    assert actual.names == expected.names
    for name in ("time", *expected.names):
        assert actual[name].tobytes() == expected[name].tobytes(), name


def described(scenario: Scenario) -> tuple[object, ...]:
    """All a scenario says of its system and run, FMUs by the name of their file."""
    components = {part.name: (Path(part.fmu).stem, dict(part.parameters)) for part in scenario.system.components}
    run = (scenario.start_time, scenario.stop_time, scenario.step_size, scenario.method, scenario.signals)
    texts = (scenario.title, scenario.description)
    coupling = (scenario.system.connections, scenario.system.guards, scenario.system.power_bonds)
    return list(components), components, coupling, dict(scenario.system.inputs), run, texts


def validate(path: Path) -> int:
    """Check every document of an archive against the schemas of the standard, by another library than the product."""
    count = 0
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            kind = {".ssd": "Description", ".ssv": "ParameterValues"}.get(Path(name).suffix)
            if kind is not None:
                with importlib.resources.as_file(SCHEMAS) as folder:
                    xmlschema.XMLSchema(folder / f"SystemStructure{kind}.xsd").validate(archive.read(name).decode())
                count += 1
    return count


def driven(inputs: dict[str, Signal], **settings: object) -> Scenario:
    """A plant under signals."""
    system = System((Component("plant", "DrillstringNeutral"),), inputs=inputs)
    return Scenario("driven", system, 4.0, 0.01, **settings)


@pytest.mark.parametrize("scenario", CHANGING, ids=lambda scenario: scenario.name)
def test_what_changes_during_a_run_but_references_and_weight_is_refused_by_name(
    scenario: Scenario, tmp_path: Path
) -> None:
    variant = scenario.variants[0].name if scenario.variants else None
    with pytest.raises(SspError, match=rf"{changing(scenario)[0]} is driven by a (step|table); SSP can hold constants"):
        export_ssp(scenario, tmp_path / "written.ssp", variant=variant)


@pytest.mark.parametrize(("name", "variant"), RUNS)
def test_a_scenario_runs_as_before(name: str, variant: str | None, tmp_path: Path) -> None:
    scenario = load_scenario(name)
    export_ssp(scenario, tmp_path / "out.ssp", variant=variant)
    expected = simulate(scenario, variant=variant, stop_time=SHORT)
    with open_ssp(tmp_path / "out.ssp") as read:
        assert_equal_runs(simulate(read, stop_time=SHORT), expected)


@pytest.mark.parametrize(("name", "variant"), RUNS)
def test_files_are_valid_by_the_schemas(name: str, variant: str | None, tmp_path: Path) -> None:
    export_ssp(load_scenario(name), tmp_path / "out.ssp", variant=variant)
    assert validate(tmp_path / "out.ssp") >= 2


@pytest.mark.parametrize(("name", "variant"), RUNS)
def test_the_same_scenario_gives_the_same_bytes_and_so_does_what_was_read(
    name: str, variant: str | None, tmp_path: Path
) -> None:
    first, second, third = (tmp_path / f"{number}.ssp" for number in range(3))
    export_ssp(load_scenario(name), first, variant=variant)
    export_ssp(load_scenario(name), second, variant=variant)
    with open_ssp(first) as read:
        export_ssp(read, third)
    assert first.read_bytes() == second.read_bytes() == third.read_bytes()


def test_system_and_run_are_read_as_they_were(tmp_path: Path) -> None:
    inputs: dict[str, Signal] = {
        "near.Omega": ramp(0.0, 12.0, 0.1, 0.7),
        "near.WOB": Step(20000.0, 97347.0, 1.005),
        "far.Omega": ramp(0.0, 12.0, 0.1, 0.7),
    }
    system = System(
        (
            Component("far", "DrillstringNeutral", {"L": 2000.0, "cells": 512}),
            Component("near", "DrillstringNeutral", {"c_b": 0.1}),
            Component("law", "DissipativeLaw", {"form": "tracking"}),
            Component("weight & <mud>", "WeightOnBitLaw", {"K_w": 1.0 / 3.0}),
        ),
        (Connection("far.bit_speed", "weight & <mud>.bit_speed"), Connection("weight & <mud>.WOB", "far.WOB")),
        inputs,
        guards=("law.limit_active",),
        power_bonds=(),
    )
    scenario = Scenario(
        "two", system, 3.0, 0.01, -1.0, Method("gauss-seidel", ("law", "far", "weight & <mud>", "near")),
        "Two strings", "One is long;\nboth are slow.", signals=("far.bit_speed", "near.WOB"),
    )  # fmt: skip
    export_ssp(scenario, tmp_path / "two.ssp")
    assert validate(tmp_path / "two.ssp") == 6
    with open_ssp(tmp_path / "two.ssp") as read:
        assert described(read) == described(scenario)
        assert read.name == "two"
        assert_equal_runs(simulate(read), simulate(scenario))


def test_guards_and_power_bonds_are_read_as_they_were(tmp_path: Path) -> None:
    scenario = load_scenario("dissipative-law")
    bond = PowerBond("plant.Omega", "plant.top_torque")
    for guards, bonds in ((None, None), ((), (bond,)), (("law.guard_active",), ())):
        system = replace(scenario.system, guards=guards, power_bonds=bonds)
        export_ssp(replace(scenario, system=system), tmp_path / "law.ssp")
        with open_ssp(tmp_path / "law.ssp") as read:
            assert (read.system.guards, read.system.power_bonds) == (guards, bonds)


def test_no_setting_of_the_method_is_lost(tmp_path: Path) -> None:
    method = Method("implicit", ("plant",), 1e-4, "halve", 1e-8, compiled=False)
    usual = Method()
    assert all(getattr(method, one.name) != getattr(usual, one.name) for one in fields(Method))
    export_ssp(replace(load_scenario("stick-slip"), method=method), tmp_path / "out.ssp")
    with open_ssp(tmp_path / "out.ssp") as read:
        assert read.method == method


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("algorithm", "1", "a string"),
        ("order", "&quot;plant&quot;", "a list of strings"),
        ("order", "[1]", "a list of strings"),
        ("tolerance", "&quot;small&quot;", "a number"),
        ("iteration_tolerance", "null", "a number"),
        ("compiled", "0", "true or false"),
    ],
)
def test_a_setting_of_another_type_is_refused(name: str, value: str, expected: str, tmp_path: Path) -> None:
    export_ssp(load_scenario("stick-slip"), tmp_path / "out.ssp")
    pattern = rf'(name="{name}" value=")[^"]*'.encode()
    replace_in_description(tmp_path / "out.ssp", pattern, rf"\g<1>{value}".encode())
    message = rf"the method's {name} is .*; expected {expected}$"
    with pytest.raises(SspError, match=message), open_ssp(tmp_path / "out.ssp"):
        pass


@pytest.mark.parametrize(
    "signal",
    [Constant(97347.0), Step(20000.0, 97347.0, 1.005), ramp(20000.0, 97347.0, 0.1, 0.7)],
    ids=["constant", "step", "ramp"],
)
def test_signals_come_back_equal(signal: Signal, tmp_path: Path) -> None:
    scenario = driven({"plant.WOB": signal})
    export_ssp(scenario, tmp_path / "out.ssp")
    with open_ssp(tmp_path / "out.ssp") as read:
        assert dict(read.system.inputs) == dict(scenario.system.inputs)
        assert_equal_runs(simulate(read), simulate(scenario))


def test_a_table_of_two_points_comes_back_as_the_ramp_that_it_is(tmp_path: Path) -> None:
    scenario = driven({"plant.WOB": Table((0.1, 0.8), (1e4, 9e4))})
    export_ssp(scenario, tmp_path / "out.ssp")
    with open_ssp(tmp_path / "out.ssp") as read:
        signal = read.system.inputs["plant.WOB"]
        assert isinstance(signal, Ramp)
        assert signal.breakpoints == (0.1, 0.8)
        assert_equal_runs(simulate(read), simulate(scenario))


def test_the_end_of_a_ramp_comes_back_to_the_last_bit() -> None:
    description = read_description(locate_fmu("DrillingProgram", "native"))
    generator = np.random.default_rng(20240229)
    for begin, duration in generator.uniform((0.0, 1e-3), (100.0, 1e3), (2000, 2)).tolist():
        expected = ramp(0.0, 12.0, begin, duration)
        for signal in (expected, Table(expected.breakpoints, (0.0, 12.0))):
            system, marked = as_components(driven({"plant.Omega": signal}).system)
            found = as_signals(system, dict.fromkeys(marked, description)).inputs["plant.Omega"]
            assert found.breakpoints == expected.breakpoints
            assert found == expected or signal is not expected


@pytest.mark.parametrize("name", ["stick-slip", "wob-law"])
def test_without_the_annotation_the_program_drives_the_plant_to_the_same_bits(name: str, tmp_path: Path) -> None:
    export_ssp(load_scenario(name), tmp_path / "out.ssp")
    strip_annotation(tmp_path / "out.ssp", "drillstring-cosim.signals")
    expected = simulate(load_scenario(name), stop_time=SHORT)
    with open_ssp(tmp_path / "out.ssp") as read:
        found = simulate(read, stop_time=SHORT)
    assert read.system.components[0].name == "program"
    assert not read.system.inputs
    for column in expected.names:
        assert found[column].tobytes() == expected[column].tobytes(), column


def test_without_the_annotation_a_step_is_passed_on_at_its_time_by_jacobi_and_one_step_early_by_gauss_seidel(
    tmp_path: Path,
) -> None:
    scenario = driven({"plant.WOB": Step(20000.0, 97347.0, 1.0)})
    export_ssp(scenario, tmp_path / "out.ssp")
    strip_annotation(tmp_path / "out.ssp", "drillstring-cosim.signals")
    expected = simulate(scenario)
    with open_ssp(tmp_path / "out.ssp") as read:
        jacobi, seidel = (simulate(read, algorithm=algorithm) for algorithm in ("jacobi", "gauss-seidel"))
    for column in expected.names:
        assert jacobi[column].tobytes() == expected[column].tobytes(), column
    assert (seidel["plant.WOB"][1:-1] == expected["plant.WOB"][2:]).all()


def strip_annotation(path: Path, kind: str) -> None:
    """Take an annotation out of a description, as a tool may that does not know it."""
    annotation = rf'<ssd:Annotations>\s*<ssc:Annotation type="{kind}" />\s*</ssd:Annotations>'
    replace_in_description(path, annotation.encode(), b"")


def replace_in_description(path: Path, pattern: bytes, text: bytes) -> None:
    """Replace the one place in the description of an archive that matches a pattern."""
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    files["SystemStructure.ssd"], count = re.subn(pattern, text, files["SystemStructure.ssd"])
    assert count == 1
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)


@pytest.mark.parametrize(
    ("inputs", "sentence"),
    [
        (
            {"plant.WOB": Table((0.0, 1.0, 2.0), (0.0, 1.0, 5.0))},
            "plant.WOB is driven by a table; SSP can hold constants, and for the inputs Omega, speed_ref, "
            "bit_speed_ref, WOB steps and ramps as well",
        ),
    ],
)
def test_what_ssp_cannot_say_is_refused(inputs: dict[str, Signal], sentence: str, tmp_path: Path) -> None:
    with pytest.raises(SspError, match=f"^{re.escape(sentence)}$"):
        export_ssp(driven(inputs), tmp_path / "out.ssp")
    assert list(tmp_path.iterdir()) == []


def test_a_table_of_a_program_would_stay_behind(tmp_path: Path) -> None:
    table = tmp_path / "table.csv"
    table.write_text("time,speed,WOB\n0,10,97347\n")
    scenario = driven({})
    program = Component("program", "DrillingProgram", {"table": str(table)})
    scenario = replace(scenario, system=System((*scenario.system.components, program)))
    with pytest.raises(SspError, match=r"^program.table is the file .*table.csv; expected no files"):
        export_ssp(scenario, tmp_path / "out.ssp")


def test_values_given_at_export_are_in_the_file(tmp_path: Path) -> None:
    values = {"plant.WOB": 31649.0, "plant.c_b": 3.0}
    export_ssp(load_scenario("stick-slip"), tmp_path / "out.ssp", overrides=values)
    with open_ssp(tmp_path / "out.ssp") as read:
        expected = simulate(load_scenario("stick-slip"), overrides=values, stop_time=SHORT)
        assert_equal_runs(simulate(read, stop_time=SHORT), expected)


def test_the_commands_export_and_run(tmp_path: Path) -> None:
    file, folder = tmp_path / "new" / "loaded.ssp", tmp_path / "run"
    exported = CliRunner().invoke(
        app, ["export", "bit-damping", str(file), "--variant", "c_b=65", "--set", "plant.WOB=31649"]
    )
    assert exported.exit_code == 0, exported.output
    assert [path.name for path in file.parent.iterdir()] == ["loaded.ssp"]
    done = CliRunner().invoke(
        app, ["run", str(file), "--stop-time", "6", "--set", "plant.Omega=12", "--output", str(folder)]
    )
    assert done.exit_code == 0, done.output
    assert (folder / "manifest.json").exists()
    values = {"plant.WOB": 31649.0, "plant.Omega": 12.0}
    simulate(load_scenario("bit-damping"), variant="c_b=65", overrides=values, stop_time=SHORT).to_csv(tmp_path / "a")
    assert (folder / "trajectory.csv").read_bytes() == (tmp_path / "a").read_bytes()


def test_a_file_of_another_kind_is_not_written(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["export", "stick-slip", str(tmp_path / "out.zip")])
    assert result.exit_code == 2
    assert result.stderr.strip().endswith("out.zip: expected a name that ends in .ssp")
    assert list(tmp_path.iterdir()) == []
