"""What is written after --set is read by the type of the variable."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from cosim import Component, Constant, Step, System
from cosim.cli.app import app
from cosim.run.options import RunOptions
from cosim.scenario.ssp.reading import open_ssp
from cosim.system.compatibility import Written, check_system, read_written
from cosim.system.description import Description, Variable
from cosim.system.signals import Value

ITEMS = {"slow": 1, "fast": 5, "7": 2}
VARIABLES = (
    Variable("x", 0, "Real", "parameter", "fixed", start="0"),
    Variable("n", 0, "Integer", "parameter", "fixed", start="0"),
    Variable("on", 0, "Boolean", "parameter", "fixed", start="false"),
    Variable("s", 0, "String", "parameter", "fixed", start=""),
    Variable("mode", 1, "Enumeration", "parameter", "fixed", start="1", items=ITEMS),
    Variable("u", 1, "Real", "input", start="0"),
)
KNOWN = {"a": Description("A", "A", "{1}", VARIABLES)}
BASE = System((Component("a", "a.fmu"),), inputs={"a.u": Step(0.0, 1.0, 0.5)})


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("x", ".5", 0.5), ("x", "5", 5.0), ("x", "-1e-3", -0.001), ("x", "007", 7.0), ("x", "1_000", 1000.0),
        ("n", "007", 7), ("n", "-3", -3), ("n", "+3", 3),
        ("on", "True", True), ("on", "false", False), ("on", "TRUE", True),
        ("s", "", ""), ("mode", "slow", 1),
        ("s", "123", "123"), ("s", "true", "true"), ("s", ".5", ".5"), ("s", '"a b"', "a b"), ("s", "it's'", "it's'"),
        ("mode", "fast", 5), ("mode", "5", 5), ("mode", "7", 2), ("mode", '"slow"', 1),
    ],
)  # fmt: skip
def test_a_value_is_read_by_the_type_of_its_variable(name: str, text: str, value: Value) -> None:
    system = read_written(BASE.with_values({f"a.{name}": Written(text)}), KNOWN)
    (read,) = check_system(system, KNOWN)["a"].values()
    assert read == value
    assert type(read) is type(value)


def test_a_value_of_an_input_takes_the_place_of_its_signal() -> None:
    system = read_written(BASE.with_values({"a.u": Written(".5")}), KNOWN)
    assert system.inputs == {"a.u": Constant(0.5)}


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ("a.gain=much", "a.gain is 'much'; expected a number"),
        ("a.gain=", "a.gain is ''; expected a number"),
        ("a.gain=inf", "a.gain is inf; expected a finite number >= 0 and <= 10"),
        ("a.n=1.5", "a.n is '1.5'; expected an integer"),
        ("a.flag=1", "a.flag is '1'; expected true or false"),
        ("a.mode=medium", "a.mode is 'medium'; expected one of 'slow' (1), 'fast' (5)"),
        ("a.gian=1", "a: Probe has no variable 'gian'; did you mean 'gain'?"),
    ],
)
def test_what_cannot_be_read_is_refused_by_type(probe: Path, given: str, sentence: str) -> None:
    result = run(probe, given)
    assert result.exit_code == 2
    assert sentence in " ".join(result.stderr.split())


def test_the_record_tells_what_was_read(probe: Path, make_probe: Callable[..., Path]) -> None:
    given = ("a.gain=.5", "a.n=007", "a.flag=True", "a.text=123", "a.mode=fast")
    result = run(probe, *given)
    assert result.exit_code == 0, result.output
    manifest = json.loads((probe.parent / "out" / "manifest.json").read_text())
    parameters = manifest["variants"][0]["run"] if "run" in manifest["variants"][0] else manifest["variants"][0]
    found = parameters["components"]["a"]["parameters"]
    assert {name: found[name] for name in ("gain", "n", "flag", "text", "mode")} == {
        "gain": 0.5, "n": 7, "flag": True, "text": "123", "mode": "fast"
    }  # fmt: skip


def run(probe: Path, *given: str) -> Any:
    """Run one probe by the command line."""
    path = probe.with_name("one.toml")
    path.write_text('stop_time = 0.5\nstep_size = 0.25\n[components.a]\nfmu = "probe.fmu"\n')
    options = [part for text in given for part in ("--set", text)]
    return CliRunner().invoke(app, ["run", str(path), *options, "--output", str(probe.parent / "out")])


def test_what_is_still_to_be_read_survives_a_manifest() -> None:
    options = RunOptions(overrides={"a.s": Written("123"), "a.x": 0.5, "a.mode": "fast"})
    again = RunOptions.from_json(json.loads(json.dumps(options.to_json())))
    assert again == options
    assert again.overrides is not None
    assert [type(value) for value in again.overrides.values()] == [Written, float, str]


def test_what_is_set_for_an_export_takes_the_place_of_a_signal(tmp_path: Path) -> None:
    path = tmp_path / "set.ssp"
    result = CliRunner().invoke(
        app, ["export", "stick-slip", str(path), "--set", "plant.WOB=5e4", "--set", "plant.L=2000"]
    )
    assert result.exit_code == 0, result.output
    with open_ssp(path) as scenario:
        assert scenario.system.inputs["plant.WOB"] == Constant(50000.0)
        assert next(part.parameters["L"] for part in scenario.system.components if part.name == "plant") == 2000.0


@pytest.mark.parametrize(("stop", "step"), [("0.05 min", "500 ms"), ("3s", "0.5"), ("3", ".5 s")])
def test_times_may_be_written_with_a_unit(stop: str, step: str, tmp_path: Path) -> None:
    arguments = ["run", "stick-slip", "--stop-time", stop, "--step-size", step, "--output", str(tmp_path / "run")]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0, done.output
    told = json.loads((tmp_path / "run" / "manifest.json").read_text())["variants"][0]
    assert (told["stop_time"], told["step_size"]) == (3.0, 0.5)


@pytest.mark.parametrize(("text", "sentence"), [("2kg", "in kg"), ("soon", "expected a number"), ("", "expected")])
def test_a_time_that_is_none_is_refused(text: str, sentence: str) -> None:
    done = CliRunner(env={"COLUMNS": "200"}).invoke(app, ["run", "stick-slip", "--stop-time", text])
    assert done.exit_code == 2
    assert sentence in done.output
