"""Laws, drive and driller of the console: what cosim makes of the same systems, to the bit."""

from __future__ import annotations

import base64
import json
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim import Component, Connection, Constant, Method, Scenario, System, load_scenario, simulate
from cosim.recording.result import Result
from fmu_src.console.core import CONSOLE_MODELS
from fmu_src.fmus import MODELS

pytestmark = [pytest.mark.slow]
HERE = Path(__file__).parent
PRESET_SECONDS = 80  # of which the law that is switched on acts for 20
SYSTEM_SECONDS = 2


@pytest.fixture(scope="module")
def coupled(node: str, console: Path) -> dict[str, dict[str, Any]]:
    """What tests/web/coupled.mjs has run."""
    outputs = {name: [variable.name for variable in MODELS[name].select("output")] for name in CONSOLE_MODELS}
    command = [node, HERE / "coupled.mjs", console, str(PRESET_SECONDS), str(SYSTEM_SECONDS)]
    run = subprocess.run(command, input=json.dumps(outputs), capture_output=True, text=True, check=True)
    return json.loads(run.stdout)


def _require_equal(found: dict[str, Any], result: Result) -> None:
    """Require the same outputs at every communication point; the last step of a run is one that is not compared."""
    rows = np.frombuffer(base64.b64decode(found["rows"]), "<f8").reshape(found["steps"] + 1, len(found["ports"]))
    for column, port in enumerate(found["ports"]):
        expected = np.asarray(result[port][: rows.shape[0]], dtype="<f8")
        different = np.flatnonzero(rows[:, column].astype("<f8").view("<i8") != expected.view("<i8"))
        assert different.size == 0, f"{port} differs at t = {result.time[different[0]]:g} s and {different.size} times"


def _value(model: str, name: str, number: float) -> float | int | bool:
    kind = next(variable.kind for variable in MODELS[model].variables if variable.name == name)
    return {"Boolean": bool, "Integer": int, "Enumeration": int}.get(kind, float)(number)


def _system(found: dict[str, Any]) -> System:
    models = {part["name"]: part["model"] for part in found["parts"]}
    parameters = {
        part["name"]: {
            name: _value(part["model"], name, number)
            for name, number in part["parameters"].items()
            if f"{part['name']}.{name}" not in found["signals"]
        }
        for part in found["parts"]
    }
    ports = {port: port.split(".") for port in found["signals"]}
    return System(
        components=tuple(Component(name, model, parameters[name]) for name, model in models.items()),
        connections=tuple(Connection(each["from"], each["to"]) for each in found["connections"]),
        inputs={
            port: Constant(_value(models[name], each, found["signals"][port])) for port, (name, each) in ports.items()
        },
    )


SCENARIOS = {
    "stick-slip", "lower-wob", "higher-speed", "wob-law", "soft-torque", "top-absorber", "speed-pid", "supervision",
    "top-supervision", "autodriller",
}  # fmt: skip


def test_presets_have_the_bits_of_the_scenarios_they_are(coupled: dict[str, dict[str, Any]]) -> None:
    assert set(coupled["presets"]) == SCENARIOS
    for name, found in coupled["presets"].items():
        scenario = load_scenario(name)
        assert scenario.step_size == found["step"]
        result = simulate(replace(scenario, stop_time=PRESET_SECONDS + found["step"]))
        bit_speed = result["plant.bit_speed"]
        assert np.ptp(bit_speed) > 1.0, "nothing happens in it"
        _require_equal(found, result)


def test_every_system_is_stepped_in_the_order_and_to_the_bits_of_cosim(coupled: dict[str, dict[str, Any]]) -> None:
    assert len(coupled["systems"]) == 34
    for name, found in coupled["systems"].items():
        method = Method(algorithm="gauss-seidel")
        stop = SYSTEM_SECONDS + found["step"]
        result = simulate(Scenario("console", _system(found), stop, found["step"], method=method))
        assert result.record["order"] == [part["name"] for part in found["parts"]], name
        _require_equal(found, result)
