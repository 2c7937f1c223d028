"""Each point of a sweep is what a run of its own would be, to the bit."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim import Constant, InputError, Scenario, Step, System, load_scenario, simulate, sweep
from cosim.system.structure import Component
from tests.cosim.sweeps.measuring import OUTPUTS, Last

SPEEDS, WEIGHTS = [4.0, 10.0, 16.0], [2e4, 97347.0]


def test_a_point_from_rest_is_a_run_of_its_own(tmp_path: Path) -> None:
    grid = {"plant.Omega": SPEEDS, "plant.WOB": WEIGHTS}
    found = sweep("stick-slip", tmp_path / "s.zarr", grid=grid, measures=Last(), workers=1, stop_time=12.0)
    for speed in SPEEDS:
        for weight in WEIGHTS:
            values = {"plant.Omega": speed, "plant.WOB": weight}
            alone = simulate("stick-slip", overrides=values, stop_time=12.0, step_size=1.0)
            point = found.sel(values)
            assert [float(point[name]) for name in OUTPUTS] == [alone[f"plant.{name}"][-1] for name in OUTPUTS]


def test_parameters_of_components_vary_as_well(tmp_path: Path) -> None:
    grid = {"plant.L": [1000.0, 2000.0], "plant.cells": "0,320"}
    found = sweep("stick-slip", tmp_path / "s.zarr", grid=grid, measures=Last(), workers=1, stop_time=8.0)
    assert found["plant.cells"].dtype.kind == "i"
    assert found["plant.L"].attrs["units"] == "m"
    for length in (1000.0, 2000.0):
        for cells in (0, 320):
            values = {"plant.L": length, "plant.cells": cells}
            alone = simulate("stick-slip", overrides=values, stop_time=8.0, step_size=1.0)
            assert float(found["energy"].sel(values)) == alone["plant.energy"][-1]


@pytest.mark.parametrize("measures", [Last(), Last(sampling=None)], ids=["measured anyhow", "in its own steps"])
def test_a_coupled_point_takes_the_steps_of_its_scenario(tmp_path: Path, measures: Last) -> None:
    values = {"law.K_w": [3.0, 9.0]}
    found = sweep("wob-law", tmp_path / "s.zarr", grid=values, measures=measures, workers=1, stop_time=6.0)
    assert found.attrs["steps"] == "scenario"
    for gain in values["law.K_w"]:
        alone = simulate("wob-law", overrides={"law.K_w": gain}, stop_time=6.0)
        assert float(found["bit_speed"].sel({"law.K_w": gain})) == alone["plant.bit_speed"][-1]


def stepped(name: str, speeds: list[float], every: float) -> Scenario:
    """Return a scenario whose drive speed takes these values one after the other."""
    scenario = load_scenario(name)
    signal: Constant | Step = Constant(speeds[0])
    if len(speeds) > 1:
        signal = Step(speeds[0], speeds[1], every)
    system = System(
        scenario.system.components,
        scenario.system.connections,
        {**scenario.system.inputs, "plant.Omega": signal},
    )
    return Scenario(name, system, every * len(speeds), scenario.step_size, method=scenario.method)


@pytest.mark.parametrize("branch", ["up", "down"])
@pytest.mark.parametrize("sampling", [1.0, None], ids=["long steps", "coupled steps"])
def test_a_continued_point_is_the_end_of_one_long_run(tmp_path: Path, branch: str, sampling: float | None) -> None:
    speeds = [9.0, 12.0]
    found = sweep(
        "stick-slip", tmp_path / "s.zarr", grid={"plant.Omega": speeds}, branch=branch, workers=1, stop_time=10.0,
        measures=Last(sampling=sampling), beginning=FromRest(), step_size=0.5,
    )  # fmt: skip
    order = speeds if branch == "up" else speeds[::-1]
    whole = simulate(stepped("stick-slip", order, 10.0), step_size=0.5)
    for number, speed in enumerate(order, 1):
        row = int(np.searchsorted(whole.time, 10.0 * number))
        point = found.sel({"plant.Omega": speed})
        assert [float(point[name]) for name in OUTPUTS] == [whole[f"plant.{name}"][row] for name in OUTPUTS]


class FromRest:
    """Begin lines as any run begins."""

    identity = "rest"

    def __call__(self, values: object) -> dict[str, float]:
        del values
        return {}


def test_components_take_the_place_of_each_other(tmp_path: Path) -> None:
    found = sweep(
        "stick-slip", tmp_path / "s.zarr", workers=1, stop_time=6.0, measures=Last(),
        grid={"plant": ["DrillstringNeutral", "DrillstringDistributed"], "plant.WOB": WEIGHTS},
    )  # fmt: skip
    assert found["plant"].values.tolist() == ["DrillstringNeutral", "DrillstringDistributed"]
    for name in ("DrillstringNeutral", "DrillstringDistributed"):
        system = System((Component("plant", name),), (), {"plant.Omega": 10.0, "plant.WOB": WEIGHTS[1]})
        alone = simulate(Scenario("alone", system, 6.0, 1.0))
        assert float(found["energy"].sel({"plant": name, "plant.WOB": WEIGHTS[1]})) == alone["plant.energy"][-1]


def test_a_point_does_not_depend_on_what_was_run_before_it(tmp_path: Path) -> None:
    both = sweep(
        "stick-slip", tmp_path / "both.zarr", grid={"plant.WOB": WEIGHTS, "plant.L": [800.0, 1200.0]},
        measures=Last(), workers=1, stop_time=6.0,
    )  # fmt: skip
    for weight in WEIGHTS:
        one = sweep(
            "stick-slip", tmp_path / f"{weight}.zarr", grid={"plant.WOB": [weight], "plant.L": [1200.0]},
            measures=Last(), workers=1, stop_time=6.0,
        )  # fmt: skip
        assert float(one["energy"][0, 0]) == float(both["energy"].sel({"plant.WOB": weight, "plant.L": 1200.0}))


def test_final_values_are_kept_of_a_system_without_a_bit(tmp_path: Path, probe: Path) -> None:
    system = System((Component("probe", probe),), (), {"probe.u": 2.0})
    scenario = Scenario("probe", system, 1.0, 0.125)
    found = sweep(scenario, tmp_path / "s.zarr", grid={"probe.u": [1.0, 3.0]}, workers=1)
    for value in (1.0, 3.0):
        alone = simulate(scenario, overrides={"probe.u": value})
        for name in found.data_vars:
            if name not in ("failed", "message"):
                assert float(found[name].sel({"probe.u": value})) == float(alone[str(name)][-1])


def test_values_may_have_units(tmp_path: Path) -> None:
    grid = {"plant.Omega": "60 rpm:120 rpm:3", "plant.WOB": "10 klbf,20 klbf"}
    found = sweep("stick-slip", tmp_path / "s.zarr", grid=grid, measures=Last(), workers=1, stop_time=3.0)
    assert found["plant.Omega"].values == pytest.approx([2.0 * np.pi, 3.0 * np.pi, 4.0 * np.pi], rel=1e-15)
    assert found["plant.WOB"].values.tolist() == [44482.216152605, 88964.43230521]
    samples = {"plant.Omega": "60 rpm:120 rpm"}
    drawn = sweep(
        "stick-slip", tmp_path / "d.zarr", samples=samples, count=8, measures=Last(), workers=1, stop_time=3.0
    )
    assert ((drawn["plant.Omega"] > 2.0 * np.pi) & (drawn["plant.Omega"] < 4.0 * np.pi)).all()


@pytest.mark.parametrize(
    ("grid", "sentence"),
    [
        ({"plant.Omga": [1.0]}, "plant: DrillstringNeutral has no variable 'Omga'; did you mean 'Omega'?"),
        ({"plnt.Omega": [1.0]}, "plnt.Omega: there is no component 'plnt'; did you mean 'plant'?"),
        ({"plnt": ["DrillstringNeutral"]}, "plnt.plnt: there is no component 'plnt'; did you mean 'plant'?"),
        ({"plant.WOB": [-1.0, 1.0]}, "plant.WOB is -1 N; expected a finite number >= 0 and <= 100000000 N"),
        ({"plant.WOB": "1,two"}, "plant.WOB is 'two'; expected a number"),
        (
            {"plant.WOB": "1 klbf,2 rpm"},
            "plant.WOB is '2 rpm', in rpm (= 0.10471975511966 s^-1 rad); expected N (= kg m s^-2)",
        ),
        ({"plant.cells": [1.5]}, "plant.cells is 1.5; expected an integer"),
        (
            {"plant.bit_speed": [1.0]},
            "plant.bit_speed is an output; expected a parameter, an input or a variable with a start value",
        ),
    ],
)  # fmt: skip
def test_a_grid_over_what_does_not_exist_or_fit_is_refused(tmp_path: Path, grid: object, sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        sweep("stick-slip", tmp_path / "s.zarr", grid=grid, workers=1)  # pyright: ignore[reportArgumentType]
    assert str(refused.value) == sentence
    assert not (tmp_path / "s.zarr").exists()


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"stop_time": 0.0}, "stop time is 0 s; expected a time after the start, 0.00 s"),
        ({"step_size": 0.0}, "step size is 0 s; expected a number > 0"),
        ({"step_size": math.nan}, "step size is nan s; expected a number > 0"),
        (
            {"grid": {}, "samples": {"plant": "1:2"}},
            "plant is a component, of which no samples are drawn; expected com",
        ),
    ],
)
def test_what_no_point_can_be_run_with_is_refused(tmp_path: Path, changes: dict[str, Any], sentence: str) -> None:
    given: dict[str, Any] = {"grid": {"plant.Omega": [8.0]}, "workers": 1, **changes}
    with pytest.raises(InputError) as refused:
        sweep("stick-slip", tmp_path / "s.zarr", **given)
    assert str(refused.value).startswith(sentence)
    assert not (tmp_path / "s.zarr").exists()


def test_what_a_connection_drives_is_not_varied(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^plant\.WOB is driven by law\.WOB; expected what nothing drives$"):
        sweep("wob-law", tmp_path / "s.zarr", grid={"plant.WOB": [1.0]}, workers=1)


def test_runs_are_continued_along_inputs_only(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^plant\.L is a parameter; runs are continued along an input only$"):
        sweep("stick-slip", tmp_path / "s.zarr", grid={"plant.L": [1.0, 2.0]}, branch="up", workers=1)


def test_a_point_that_fails_has_its_message_and_the_rest_goes_on(tmp_path: Path) -> None:
    # the plant refuses, at initialisation, what takes more than 50 times the usual work
    grid = {"plant.I_B": [311.0, 1e-3], "plant.WOB": WEIGHTS}
    found = sweep("stick-slip", tmp_path / "s.zarr", grid=grid, measures=Last(), workers=1, stop_time=6.0)
    assert found["failed"].values.tolist() == [[0.0, 0.0], [1.0, 1.0]]
    assert np.isnan(found["energy"].values[1]).all()
    assert np.isfinite(found["energy"].values[0]).all()
    assert found["message"].values[0].tolist() == ["", ""]
    with pytest.raises(Exception, match="plant at t = 0") as alone:
        simulate("stick-slip", overrides={"plant.I_B": 1e-3, "plant.WOB": WEIGHTS[0]}, stop_time=6.0)
    assert found["message"].values[1][0] == str(alone.value)[:300]
