"""Eq. (8) along the runs of all scenarios: nothing comes from nowhere, whatever drives the string."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from cosim import load_scenario, simulate
from cosim.cli.app import app
from cosim.drilling.energy import EnergyBalance, energy_balance
from cosim.recording.result import Result
from cosim.scenario.file import scenario_names

BAR = 1e-9
"""Of the energy put in until then."""
GRID_BAR = 3e-6
"""The same where damping along the string is computed on a grid of cells."""
RUNS = [
    (name, variant.name if variant else None)
    for name in scenario_names()
    for variant in (load_scenario(name).variants or [None])
]


@cache
def run(name: str, variant: str | None) -> Result:
    return simulate(load_scenario(name), variant=variant)


def balance(name: str, variant: str | None) -> EnergyBalance:
    found = energy_balance(run(name, variant))
    assert found is not None
    return found


@pytest.mark.parametrize(("name", "variant"), RUNS)
def test_what_the_drive_gives_is_stored_or_lost(name: str, variant: str | None) -> None:
    found = balance(name, variant)
    assert found.put_in[-1] > 1e3
    distributed, damped = name == "string-damping", name == "string-damping" and variant != "beta=0"
    assert 0.0 < found.worst <= (GRID_BAR if damped else BAR)
    assert set(found.losses) == {"top_loss", "bit_loss"} | ({"string_loss"} if distributed else set())


@pytest.mark.parametrize(("name", "variant"), RUNS)
def test_what_the_drive_gives_and_the_sliding_takes_goes_into_the_string(name: str, variant: str | None) -> None:
    result = run(name, variant)
    through = result["plant.drive_work"] - result["plant.top_loss"]
    assert np.abs(through - result["plant.work_in"]).max() <= 1e-12 * result["plant.drive_work"].max()
    for lost in ("top_loss", "bit_loss"):
        assert np.diff(result[f"plant.{lost}"]).min() >= -1e-12 * result[f"plant.{lost}"][-1]


@pytest.mark.parametrize(("name", "variant"), RUNS)
def test_drive_gives_what_angle_and_speed_of_a_held_drive_say(name: str, variant: str | None) -> None:
    """With Omega held over a step h, c_a Omega (Omega h - dy) and no less: y is accumulated by itself."""
    result = run(name, variant)
    c_a, omega = 2000.0, result["plant.Omega"][1:]
    steps = c_a * omega * (omega * np.diff(result.time) - np.diff(result["plant.top_angle"]))
    given = np.concatenate([[0.0], np.cumsum(steps)])
    assert np.abs(given - result["plant.drive_work"]).max() <= 1e-9 * np.abs(steps).sum()


def test_steady_drilling_loses_all_that_the_drive_gives_in_proportion_to_the_speeds() -> None:
    """T w at the bit and T (Omega - w) in the sliding top, T Omega in all."""
    result = run("lower-wob", None)
    torque, speed = result["plant.bit_torque"][-1], 8.768644096751
    rate = {
        name: float(result[f"plant.{name}"][-1] - result[f"plant.{name}"][-1001])
        / float(result.time[-1] - result.time[-1001])
        for name in ("bit_loss", "top_loss", "drive_work")
    }
    assert rate == pytest.approx(
        {"bit_loss": torque * speed, "top_loss": torque * (10.0 - speed), "drive_work": torque * 10.0}, rel=1e-6
    )


def test_energy_from_nowhere_is_seen() -> None:
    result = run("stick-slip", None)
    columns = dict(result.columns)
    columns["plant.energy"] = columns["plant.energy"] + np.where(result.time > 50.0, 0.1, 0.0)
    found = energy_balance(Result(result.time, columns, result.units))
    assert found is not None
    assert found.worst > BAR
    assert found.residual[-1] == pytest.approx(0.1, abs=1e-6)


def test_manifest_tells_where_the_energy_went(tmp_path: Path) -> None:
    arguments = ["run", "stick-slip", "--stop-time", "10", "--output", str(tmp_path / "run")]
    assert CliRunner().invoke(app, arguments).exit_code == 0
    (variant,) = json.loads((tmp_path / "run" / "manifest.json").read_text())["variants"]
    told = variant["energy"]
    assert told["drive_work"] > told["bit_loss"] > 1e5
    spent = told["top_loss"] + told["bit_loss"] + told["folded"]
    assert told["stored"] == pytest.approx(told["stored_at_start"] + told["drive_work"] - spent, rel=1e-9)
    assert told["worst_residual"] <= BAR


def test_what_is_no_string_has_no_balance() -> None:
    result = run("dissipative-law", "tracking")
    assert energy_balance(result, "law") is None
    assert energy_balance(result, "nobody") is None
