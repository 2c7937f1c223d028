"""What Python hands over and does with what it gets: numbers of NumPy, copies, names, and results as mappings."""

from __future__ import annotations

import copy
import json
import pickle
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim import (
    Component,
    Constant,
    Result,
    RunOptions,
    Scenario,
    Step,
    System,
    Table,
    Variant,
    load_scenario,
    ramp,
    simulate,
    stream,
)
from cosim.errors import InputError, ScenarioError, SystemDefinitionError


def probing(path: Path, **changes: Any) -> Scenario:
    """One probe, which gives back its input."""
    given = {"parameters": {}, "inputs": {"probe.u": 2.0}, "stop_time": 1.0, "step_size": 0.125} | changes
    system = System((Component("probe", path, given.pop("parameters")),), inputs=given.pop("inputs"))
    return Scenario("probing", system, **given)


@pytest.fixture
def result() -> Result:
    columns = {"plant.speed": np.array([1.0, np.nan]), "plant.stuck": np.array([True, False])}
    return Result(np.array([0.0, 1.0]), columns, {"plant.speed": "rad/s", "plant.stuck": ""}, {"scenario": "mine"})


@pytest.mark.parametrize("number", [np.float32(0.5), np.float64(0.5), np.array(0.5), np.array(1), np.int64(1), 1])
def test_numbers_of_numpy_are_numbers_wherever_a_value_is_given(number: Any, probe: Path) -> None:
    plain = float(number)
    variant = Variant("one", {"probe.gain": number})
    scenario = probing(probe, inputs={"probe.u": number}, variants=(variant,), stop_time=np.float32(1.0))
    expected = probing(probe, inputs={"probe.u": Constant(plain)}, variants=(Variant("one", {"probe.gain": plain}),))
    assert simulate(scenario) == simulate(expected)
    assert simulate(scenario, overrides={"probe.gain": number}) == simulate(expected)
    json.dumps(RunOptions(overrides={"probe.gain": number}, step_size=number).to_json())


def test_integers_and_booleans_of_numpy_fit_variables_of_their_types(probe: Path) -> None:
    given = {"probe.n": np.int32(3), "probe.on": np.bool_(True)}
    system = System((Component("probe", probe),)).with_values(given)
    assert [(value, type(value)) for value in system.components[0].parameters.values()] == [(3, int), (True, bool)]


def test_signals_hold_numbers_of_python() -> None:
    one = np.float32(1.0)
    signals = (Constant(one), Step(one, np.int64(2), at=one), ramp(one, one, one, one), Table((one,), (np.array(2),)))
    assert signals == (Constant(1.0), Step(1.0, 2, at=1.0), ramp(1.0, 1.0, 1.0, 1.0), Table((1.0,), (2.0,)))
    for signal in signals:
        json.dumps(signal.record())


def test_what_is_no_signal_is_refused_where_it_is_given() -> None:
    with pytest.raises(
        SystemDefinitionError, match=r"plant\.u is \[1, 2\]; expected a number, true, false or a signal"
    ):
        System((Component("plant", "Plant"),), inputs={"plant.u": [1, 2]})  # pyright: ignore[reportArgumentType]


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda each: pickle.loads(pickle.dumps(each))])
def test_scenarios_and_results_are_copied_whole(copied: Callable[[Any], Any], probe: Path) -> None:
    scenario = probing(probe, variants=(Variant("one", {"probe.gain": 2.0}),), parameters={"gain": 1.0})
    twin = copied(scenario)
    assert twin == scenario
    assert copied(load_scenario("bit-damping")) == load_scenario("bit-damping")
    result = simulate(twin)
    again = copied(result)
    assert again == result
    assert again.record == result.record
    assert again.time is not result.time
    with pytest.raises(ValueError, match="read-only"):
        again["probe.u"][0] = 1.0
    with pytest.raises(TypeError):
        again.columns["probe.u"] = again.time


def test_a_scenario_may_be_given_by_name_or_path(tmp_path: Path, probe: Path) -> None:
    path = tmp_path / "probing.toml"
    path.write_text(
        f'stop_time = 1\nstep_size = 0.125\n[components.probe]\nfmu = "{probe.name}"\n[inputs]\n"probe.u" = 2.0\n'
    )
    expected = simulate(probing(probe))
    assert simulate(path) == simulate(str(path)) == expected
    assert stream(path, tmp_path / "run")["time"][-1] == 1.0
    with pytest.raises(ScenarioError, match="there is no scenario 'stik-slip'; did you mean 'stick-slip'"):
        simulate("stik-slip")
    with pytest.raises(ScenarioError, match="scenario is 5; expected a Scenario, or a name or path of one"):
        simulate(5)  # pyright: ignore[reportArgumentType]


def test_an_ssp_file_is_not_loaded_but_run() -> None:
    with pytest.raises(ScenarioError, match=r"x\.ssp: the FMUs of an \.ssp file are unpacked .* simulate or stream"):
        load_scenario("x.ssp")


@pytest.mark.parametrize("given", [["plant.WOB=6e4"], [("plant.WOB", 6e4)], "plant.WOB=6e4"])
def test_overrides_that_are_no_mapping_are_refused(given: Any) -> None:
    with pytest.raises(InputError, match=r"expected a mapping by component\.variable"):
        simulate("stick-slip", overrides=given)


@pytest.mark.parametrize(
    ("stop", "step", "points"), [("1 s", "250 ms", 5), ("1", 0.5, 3), (np.float32(1.0), np.array(0.5), 3)]
)
def test_times_are_numbers_or_have_a_unit(stop: Any, step: Any, points: int) -> None:
    assert simulate("stick-slip", stop_time=stop, step_size=step).time.size == points
    system = load_scenario("stick-slip").system
    assert simulate(Scenario("timed", system, stop, step)).time.size == points


@pytest.mark.parametrize(
    ("mistake", "message"),
    [
        (
            lambda: simulate("stick-slip", stop_time="soon"),
            r"^stop_time is 'soon'; expected a number, with a unit or in s",
        ),
        (lambda: simulate("stick-slip", stop_time=True), r"^stop_time is True; expected a number of seconds"),
        (lambda: simulate("stick-slip", step_size=[1]), r"^step_size is \[1\]; expected a number of seconds"),
        (
            lambda: simulate("stick-slip", stop_time=10**400),
            r"^stop_time is an integer of 1329 bits; expected a number",
        ),
        (lambda: simulate("stick-slip", variant=3), r"^stick-slip: there is no variant '3'"),
        (
            lambda: simulate("stick-slip", overrides={"plant.WOB": 10**400}),
            r"^plant\.WOB is an integer of 1329 bits; expected a finite number",
        ),
        (lambda: Component("p", "P", [1]), r"^component 'p': parameters are \[1\]; expected a mapping"),
        (lambda: Variant("v", [1]), r"^variant 'v': values are \[1\]; expected a mapping"),
        (
            lambda: System((Component("p", "P"),), (("p.y", "p.u"),)),
            r"^connections hold \('p\.y', 'p\.u'\); expected Connection\(source, target\)",
        ),
        (lambda: load_scenario(None), r"^scenario is None; expected a name or path"),
    ],
)
def test_a_mistake_in_python_is_a_sentence(mistake: Callable[[], Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        mistake()


def test_a_result_is_a_mapping(result: Result) -> None:
    assert isinstance(result, Mapping)
    assert list(result) == list(result.keys()) == ["time", "plant.speed", "plant.stuck"]
    assert len(result) == len(result.values()) == 3
    assert dict(result.items())["plant.stuck"].tolist() == [True, False]
    assert "time" in result
    assert "plant.sped" not in result
    assert result.get("plant.sped") is None
    with pytest.raises(KeyError, match=r"'plant\.sped' was not recorded; did you mean") as unknown:
        result["plant.sped"]
    assert isinstance(unknown.value, InputError)
    assert str(unknown.value).startswith("'plant.sped' was")
    with pytest.raises(InputError, match="0 is no name of what was recorded"):
        result[0]  # pyright: ignore[reportArgumentType]


def test_results_are_equal_if_their_values_are(result: Result) -> None:
    assert result == Result(result.time.copy(), dict(result.columns), dict(result.units), {"timings": {"step": 1.0}})
    other = {**result.columns, "plant.speed": np.array([1.0, 2.0])}
    assert result != Result(result.time, other, result.units)
    assert result != Result(result.time, result.columns, dict.fromkeys(result.units, "m"))
    assert result != Result(result.time[:1], {name: each[:1] for name, each in result.columns.items()}, result.units)
    assert result != dict(result)


def test_the_repr_of_a_result_is_one_short_line(result: Result) -> None:
    assert repr(result) == "<Result of mine: 2 columns, 2 points, 0 s to 1 s>"
    assert repr(Result(np.zeros(0), {}, {})) == "<Result: 0 columns, 0 points>"
