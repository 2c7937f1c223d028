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
from cosim.drilling.energy import EnergyBalance, energy_balance, folding_sentence
from cosim.drilling.reporting import find
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
    # rounding of what is added up, which grows with the pieces that there are: 2000 a second
    bar = max(1e-12, 1e-14 * float(result.time[-1]))
    assert np.abs(through - result["plant.work_in"]).max() <= bar * result["plant.drive_work"].max()
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


@pytest.mark.parametrize(("name", "variant"), [("wob-law", None), ("dissipative-law", "tracking")])
def test_folded_breaks_change_the_bit_speed_by_less_than_the_waves_they_say(name: str, variant: str | None) -> None:
    """Against four or eight times the cells, in which fewer are folded or none."""
    scenario = load_scenario(name)
    run, finer = (
        simulate(scenario, variant=variant, stop_time=20.0, overrides=cells) for cells in (None, {"plant.cells": 4096})
    )
    told, less = (find(result).energy for result in (run, finer))
    assert told is not None
    assert less is not None
    assert told["breaks_folded"] == run["plant.breaks_folded"][-1] > 0
    assert less.get("wave_change", 0.0) < 0.1 * told["wave_change"]
    difference = run["plant.bit_speed"] - finer["plant.bit_speed"]
    assert 0.0 < np.sqrt(np.mean(difference**2)) < told["wave_change"] < 1e-4
    assert find(run).sentence().endswith("rad/s in the root mean square")


def test_nothing_is_said_of_folds_where_there_are_none() -> None:
    found = find(simulate(load_scenario("stick-slip"), stop_time=5.0))
    assert found.energy is not None
    assert not {"breaks_folded", "wave_change"} & set(found.energy)
    assert "folded" not in found.sentence()


def test_the_change_of_the_waves_is_that_of_the_energy_taken() -> None:
    """A string of impedance 4 N.m.s from which folding took 1 J in 100 s: sqrt(1 / 400) rad/s."""
    time = np.array([0.0, 100.0])
    outputs = ("energy", "work_in", "drive_work", "top_loss", "bit_loss")
    columns = {f"plant.{name}": np.zeros(2) for name in outputs}
    columns |= {"plant.folded_energy": np.array([0.0, 1.0]), "plant.breaks_folded": np.array([0, 3], dtype=np.int32)}
    record = {"components": {"plant": {"parameters": {"I": 2.0, "G": 8.0, "J": 1.0}}}}
    result = Result(time, columns, dict.fromkeys(columns, ""), record)
    balance = energy_balance(result)
    assert balance is not None
    assert (balance.folds, balance.wave_change) == (3, pytest.approx(0.05))
    bare = energy_balance(Result(time, columns, dict.fromkeys(columns, "")))
    assert bare is not None
    assert bare.wave_change is None
    assert folding_sentence(bare.summary()) == "3 breaks folded, which took 1 J of the 0 J that the drive gave"
