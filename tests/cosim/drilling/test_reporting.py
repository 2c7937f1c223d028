"""A measure is one entry of a registry: manifest, table and streaming follow from it."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from cosim import load_scenario, simulate
from cosim.cli.app import app
from cosim.drilling import reporting
from cosim.drilling.oscillation import MEASURES, BitMotion, Measure, Measures, measure

RUN = ["run", "wob-law", "--stop-time", "30", "--output"]


def greatest_top_torque(motion: BitMotion) -> float:
    return float(motion.outputs["top_torque"][motion.window.first : motion.window.last + 1].max())


@pytest.fixture
def new_measure(monkeypatch: pytest.MonkeyPatch) -> Measure:
    """One more measure, of an output that no other takes."""
    new = Measure("top_torque", "N.m", "top torque", greatest_top_torque, 1, ("top_torque",))
    monkeypatch.setitem(MEASURES, new.name, new)
    return new


@pytest.mark.parametrize("way", [[], ["--stream"]])
def test_a_measure_that_is_registered_is_told_everywhere(way: list[str], new_measure: Measure, tmp_path: Path) -> None:
    shown = CliRunner().invoke(app, [*RUN, str(tmp_path / "run"), *way])
    assert shown.exit_code == 0, shown.output
    (variant,) = json.loads((tmp_path / "run" / "manifest.json").read_text())["variants"]
    told: dict[str, Any] = variant["measures"]
    assert list(told) == ["component", "window", "start", "end", *MEASURES]
    result = simulate(load_scenario("wob-law"), stop_time=30.0)
    first, last = np.searchsorted(result.time, [told["start"], told["end"]])
    assert told["top_torque"] == result["plant.top_torque"][first : last + 1].max() > 0.0
    heads, numbers = shown.stdout.splitlines()[1:3]
    assert heads.endswith("top torque [N.m]")
    assert numbers.split()[-1] == f"{told['top_torque']:.1f}"
    found = measure(result)
    assert found is not None
    assert found.top_torque == told["top_torque"]


def test_a_plant_without_an_output_lacks_the_measure_of_it_alone(new_measure: Measure) -> None:
    result = simulate(load_scenario("stick-slip"), stop_time=5.0)
    whole = reporting.find(result)
    columns = {name: values for name, values in result.columns.items() if name != "plant.top_torque"}
    found = reporting.find(type(result)(result.time, columns, result.units))
    assert whole.measures is not None
    assert found.measures is not None
    assert dict(found.measures.values) == {**whole.measures.values, "top_torque": None}
    assert found.cells() == (*whole.cells()[:-1], "-")


def test_findings_come_back_from_a_manifest(tmp_path: Path) -> None:
    held = simulate(load_scenario("stick-slip"), stop_time=5.0, overrides={"plant.Omega": 0.0})
    found = reporting.find(held)
    assert found.measures is not None
    assert found.measures.ssi == math.inf
    written = json.loads(json.dumps(found.to_json() | {"measures": {**found.measures.to_json(), "ssi": "inf"}}))
    assert reporting.Findings.from_json(written) == found
    nothing = reporting.Findings(None, None)
    assert reporting.Findings.from_json(nothing.to_json()) == nothing
    assert nothing.cells() == ("-",) * len(reporting.headings())


def test_an_unknown_measure_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="there is no measure 'pek'"):
        _ = Measures("plant", "", 0.0, 1.0, {"peak": 1.0}).pek
