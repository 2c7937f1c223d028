"""A Python function as a component: the same bits as the FMU of the law, and a sentence for whatever is wrong."""

from __future__ import annotations

import csv
import functools
import json
import math
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim import (
    Component,
    Connection,
    Result,
    Scenario,
    Step,
    System,
    load_scenario,
    simulate,
    stream,
)
from cosim.errors import FmuFileError, FunctionError, InputError, SystemDefinitionError
from cosim.run.job import Job, run_job
from cosim.run.options import RunOptions, Streaming
from cosim.scenario.ssp.writing import export_ssp


def weight(bit_speed: float, K_w: float = 5000.0, WOB_0: float = 97347.0, WOB_max: float = 3e5) -> float:
    """Return the weight of eq. (22), by the operations of its FMU in their order."""
    return min(K_w * abs(bit_speed) + WOB_0, WOB_max)


def tracking(
    top_speed: float, bit_speed: float, bit_speed_ref: float = 10.0, bit_torque_ref: float = 0.0, c_1: float = 0.3
) -> Mapping[str, float]:
    """Return the speed of the tracking form with its default damping, by the operations of its FMU in their order."""
    omega = bit_speed_ref + bit_torque_ref / 2000.0
    omega = omega + c_1 * (top_speed - bit_speed_ref)
    return {"Omega": omega + 2.0 * math.sqrt(0.03 / 2000.0 * (1.0 - c_1)) * (bit_speed - bit_speed_ref)}


def run(function: Any, scenario: str | Scenario = "wob-law", **options: Any) -> Result:
    # within 5 s the bit comes loose, at 2.6 s
    return simulate(scenario, components={"law": function}, **{"stop_time": 5.0, **options})


def both(
    function: Callable[..., object], scenario: str, tolerance: float | None, **options: Any
) -> tuple[Result, Result]:
    """Run with FMU and function, and hold all that both record against each other; None asks for the same bits."""
    fmu, ours = simulate(scenario, **options), simulate(scenario, components={"law": function}, **options)
    assert set(ours) == set(fmu) - {"law.guard_active", "law.limit_active"}
    for name in ours:
        if tolerance is None:
            assert np.array_equal(ours[name], fmu[name]), name
        else:
            assert np.allclose(ours[name], fmu[name], rtol=tolerance, atol=tolerance), name
    return fmu, ours


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_the_weight_law_as_a_function_gives_the_bits_of_its_fmu(algorithm: str) -> None:
    fmu, ours = both(weight, "wob-law", None, stop_time=20.0, algorithm=algorithm)
    assert np.ptp(fmu["law.WOB"]) > 1e4
    assert (fmu.record["step_loop"], ours.record["step_loop"]) == ("compiled", "python")
    assert ours.units == fmu.units


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_the_tracking_law_as_a_function_gives_the_bits_of_its_fmu(algorithm: str) -> None:
    options = {"variant": "tracking", "stop_time": 5.0, "algorithm": algorithm}
    fmu, _ = both(tracking, "dissipative-law", None, **options)
    assert np.ptp(fmu["law.Omega"]) > 1.0


def test_in_loops_that_are_closed_it_agrees_to_the_tolerance_of_the_iteration() -> None:
    # the FMU follows its input along a slope and the function is given its end, which differ by rounding
    options = {"variant": "tracking", "stop_time": 2.0, "algorithm": "implicit", "step_size": 0.01}
    fmu, ours = both(tracking, "dissipative-law", 1e-6, **options)
    assert ours.record["iterations"]["most"] > 1
    assert fmu.record["unsolved"]["steps"] == ours.record["unsolved"]["steps"] == 0


def test_steps_of_varying_size_are_taken_back() -> None:
    result = run(weight, tolerance=1e-4, stop_time=3.0)
    assert result.record["rejected"] > 0
    assert np.array_equal(result["law.WOB"], [weight(each) for each in result["plant.bit_speed"]])


def test_time_is_the_communication_point_that_the_outputs_belong_to() -> None:
    def law(time: float) -> float:
        return 9e4 + 100.0 * time

    result = run(law, stop_time=0.5)
    assert np.allclose(result["law.WOB"], 9e4 + 100.0 * result.time, rtol=1e-15, atol=0.0)
    assert "law.time" not in result


def test_an_override_or_a_signal_reaches_a_parameter_by_its_name() -> None:
    assert run(weight, overrides={"law.WOB_0": 6e4})["law.WOB"][0] == weight(0.0, WOB_0=6e4)
    scenario = load_scenario("wob-law")
    inputs = {**scenario.system.inputs, "law.K_w": Step(1000.0, 9000.0, 4.0)}
    system = System(scenario.system.components, scenario.system.connections, inputs)
    result = run(weight, Scenario("steps", system, stop_time=5.0, step_size=0.01))
    gains = np.where(result.time <= 4.0, 1000.0, 9000.0)
    assert np.array_equal(result["law.K_w"], gains)
    given = zip(result["law.bit_speed"], gains, strict=True)
    assert np.array_equal(result["law.WOB"], [weight(speed, gain) for speed, gain in given])


def test_what_the_scenario_gives_a_law_reaches_the_function_that_has_a_parameter_for_it() -> None:
    # of wob-law's parameters it takes WOB_0 = 97347, and leaves out the rest
    assert run(lambda bit_speed, WOB_0: WOB_0)["law.WOB"][-1] == 97347.0
    seen: list[dict[str, Any]] = []

    def anything(**given: Any) -> float:
        seen.append(given)
        return 9e4

    run(anything)
    assert set(seen[-1]) == {"bit_speed", "WOB_0"}


def test_a_new_component_is_what_connections_name() -> None:
    connections = [
        Connection("plant.top_speed", "damper.top_speed"),
        Connection("damper.Omega", "plant.Omega"),
    ]

    def damper(top_speed: float, speed: float = 10.0) -> dict[str, float]:
        return {"Omega": speed + 7573.0 / 2000.0 + 0.5 * (top_speed - speed)}

    result = simulate(
        "stick-slip", components={"damper": damper}, connections=connections, step_size=0.001, stop_time=60.0
    )
    # what docs/researchers.md finds with the same law without the master
    assert result["plant.bit_speed"][-1] == pytest.approx(10.0, abs=1e-3)
    assert result.units["damper.Omega"] == "rad/s"


def test_a_system_in_python_takes_a_function_as_it_takes_an_fmu(tmp_path: Path) -> None:
    system = System(
        (Component("plant", "DrillstringNeutral"), Component("law", weight, {"K_w": 1000.0})),
        (Connection("plant.bit_speed", "law.bit_speed"), Connection("law.WOB", "plant.WOB")),
        {"plant.Omega": 10.0},
    )
    scenario = Scenario("mine", system, stop_time=5.0, step_size=0.01)
    result = simulate(scenario)
    assert np.ptp(result["law.WOB"]) > 0.0
    assert result.record["components"]["law"]["parameters"] == {"K_w": 1000.0, "WOB_0": 97347.0, "WOB_max": 3e5}
    with pytest.raises(FmuFileError, match="weight is a Python function; expected an FMU, which is a file"):
        export_ssp(scenario, tmp_path / "mine.ssp")


def test_the_record_says_that_it_is_a_function_and_where_from(tmp_path: Path) -> None:
    told = run(weight, overrides={"law.K_w": 4000.0}).record["components"]["law"]
    assert told["python_function"] == f"{__name__}.weight"
    assert told["file"] == f"{__file__}:{weight.__code__.co_firstlineno}"
    assert re.fullmatch("[0-9a-f]{64}", told["sha256"])
    assert told["parameters"] == {"WOB_0": 97347.0, "K_w": 4000.0, "WOB_max": 3e5}
    job = Job(load_scenario("wob-law"), RunOptions(components={"law": weight}, stop_time=1.0))
    run_job(job, tmp_path / "run", lambda label, part: None)
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["variants"][0]["components"]["law"]["python_function"] == told["python_function"]


def test_whatever_can_be_called_is_a_component() -> None:
    class Gain:
        def __init__(self, gain: float) -> None:
            self.gain = gain

        def __call__(self, bit_speed: float, /) -> np.float64:
            return np.float64(weight(bit_speed, self.gain))

    expected = run(weight, overrides={"law.K_w": 2000.0})
    for law in (Gain(2000.0), functools.partial(weight, K_w=2000.0), lambda bit_speed: weight(bit_speed, 2000.0)):
        assert np.array_equal(run(law)["law.WOB"], expected["law.WOB"])
    assert run(Gain(2000.0)).record["components"]["law"]["model"].endswith("Gain")


def test_booleans_are_passed_as_such() -> None:
    def law(enabled: bool, top_speed: float) -> dict[str, object]:
        assert isinstance(enabled, bool)
        return {"WOB": 6e4 if enabled else 9e4}

    scenario = load_scenario("wob-law")
    connections = (Connection("plant.top_speed", "law.top_speed"), *scenario.system.connections[1:])
    inputs = {"plant.Omega": 10.0, "law.enabled": Step(False, True, 0.5)}
    system = System(scenario.system.components, connections, inputs)
    result = run(law, Scenario("switched", system, stop_time=5.0, step_size=0.01))
    assert np.array_equal(result["law.WOB"], np.where(result.time <= 0.5, 9e4, 6e4))


def test_a_streamed_run_goes_on_with_the_same_function_only(tmp_path: Path) -> None:
    whole = run(weight, stop_time=20.0)

    def stop(part: float) -> None:
        if part > 0.5:
            raise KeyboardInterrupt

    options: dict[str, Any] = {"csv": True, "stop_time": 20.0}
    with pytest.raises(KeyboardInterrupt):
        stream("wob-law", tmp_path, components={"law": weight}, progress=stop, **options)
    with pytest.raises(InputError, match=r"components\.law"):
        stream("wob-law", tmp_path, components={"law": lambda bit_speed: 1e5}, resume=True, **options)
    stream("wob-law", tmp_path, components={"law": weight}, resume=True, **options)
    with (tmp_path / "trajectory.csv").open(encoding="utf-8", newline="") as file:
        assert [float(row["law.WOB"]) for row in csv.DictReader(file)] == whole["law.WOB"].tolist()


def test_a_job_with_a_function_is_not_written_down_to_be_resumed(tmp_path: Path) -> None:
    job = Job(load_scenario("wob-law"), RunOptions(components={"law": weight}), streaming=Streaming(), source="wob-law")
    with pytest.raises(InputError, match="a run with Python functions cannot be written down"):
        run_job(job, tmp_path / "run", lambda label, part: None)
    assert not (tmp_path / "run").exists()


def test_one_that_remembers_is_refused_where_steps_are_repeated() -> None:
    calls: list[float] = []

    def remembering(bit_speed: float) -> float:
        calls.append(bit_speed)
        return 9e4 + len(calls)

    assert np.all(np.diff(run(remembering, stop_time=0.1)["law.WOB"]) == 1.0), "once for each step"
    for options in ({"algorithm": "implicit"}, {"tolerance": 1e-4}):
        with pytest.raises(FunctionError, match=r"remembering gave WOB = .*, and then .* from the same arguments"):
            run(remembering, **options)


@pytest.mark.parametrize("options", [{"algorithm": "implicit"}, {"tolerance": 1e-4}])
def test_a_filter_in_a_closure_is_refused_when_it_begins_to_move(options: dict[str, Any]) -> None:
    seen = [0.0]

    def smoothed(bit_speed: float) -> float:
        seen[0] += 0.1 * (bit_speed - seen[0])
        return 97347.0 + 5000.0 * seen[0]

    # the bit, at rest until 2.6 s, gives it nothing to filter
    with pytest.raises(FunctionError, match=r"law at t = 2\.6.* smoothed gave WOB = .* from the same arguments"):
        run(smoothed, **options)


def missing(bit_speed: float, bit_sped: float) -> float:
    return bit_speed + bit_sped


def failing(bit_speed: float, time: float) -> float:
    if time > 0.495:
        raise KeyError("gain")
    return 9e4


def switching(bit_speed: float, time: float) -> object:
    return 9e4 if time < 0.295 else {"wob": 9e4}


@pytest.mark.parametrize(
    ("function", "error", "sentence"),
    [
        (
            missing,
            SystemDefinitionError,
            "law: nothing feeds the parameter 'bit_sped' of missing, which has no default; expected a connection, a "
            "signal or a value; did you mean 'bit_speed'?",
        ),
        (failing, FunctionError, "law at t = 0.50 s: failing raised KeyError: 'gain'"),
        (switching, FunctionError, "law at t = 0.30 s: switching gave no 'WOB', which is connected; known: wob"),
        (max, InputError, "max does not tell its parameters; expected a function written in Python around it"),
        (5, InputError, "components: 'law' is 5; expected a function"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_function_is_one_sentence(function: Any, error: type[Exception], sentence: str) -> None:
    with pytest.raises(error) as caught:
        run(function)
    assert str(caught.value) == sentence


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (math.nan, "gave WOB = nan; expected a finite number"),
        (math.inf, "gave WOB = inf; expected a finite number"),
        (None, "gave WOB = None; expected a finite number"),
        ("9e4", "gave WOB = '9e4'; expected a finite number"),
        (True, "gave WOB = True; expected a finite number"),
        (np.zeros(2), "gave WOB = array([0., 0.]); expected a finite number"),
    ],
)
def test_an_output_that_is_no_number_is_one_sentence(answer: object, said: str) -> None:
    with pytest.raises(FunctionError) as caught:
        run(lambda bit_speed, time: answer if time > 0.1 else 9e4)
    assert str(caught.value).endswith(f"<lambda> {said}")
    assert "law at t = 0.11 s" in str(caught.value)


def test_a_number_is_no_answer_where_several_outputs_are_connected() -> None:
    connections = [Connection("law.WOB", "plant.WOB"), Connection("law.Omega", "plant.Omega")]
    with pytest.raises(FunctionError, match=r"gave 5\.0; expected a mapping with 'WOB', 'Omega'"):
        run(lambda bit_speed: 5.0, connections=connections)


def test_names_that_do_not_exist_are_refused() -> None:
    with pytest.raises(
        SystemDefinitionError, match=r"there is no component 'lwa' to be a function.*did you mean 'law'"
    ):
        simulate("wob-law", components={"lwa": weight})
    with pytest.raises(SystemDefinitionError, match="there is no component 'low'"):
        run(weight, connections=[Connection("plant.bit_speed", "low.bit_speed")])
    with pytest.raises(SystemDefinitionError, match="law: weight has no variable 'bit_sped'; did you mean 'bit_speed'"):
        run(weight, connections=[Connection("plant.bit_speed", "law.bit_sped")])
    with pytest.raises(SystemDefinitionError, match="law: weight has no variable 'K_v'; did you mean 'K_w'"):
        run(weight, overrides={"law.K_v": 1.0})
    with pytest.raises(SystemDefinitionError, match="law is the Python function weight; expected an FMU to isolate"):
        run(weight, isolate=["law"])
    with pytest.raises(InputError, match=r"connections hold 'a -> b'; expected Connection"):
        run(weight, connections=["a -> b"])
    with pytest.raises(InputError, match=r"components is \['law'\]; expected a mapping"):
        simulate("wob-law", components=["law"])  # pyright: ignore[reportArgumentType]


def test_fmus_beside_it_may_be_isolated() -> None:
    result = run(weight, isolate=True)
    assert result.record["isolated"] == ["plant"]
    assert np.array_equal(result["law.WOB"], run(weight)["law.WOB"])


def test_one_that_cannot_answer_before_values_at_the_start_are_known_is_asked_again() -> None:
    # the plant starts at rest, so this one is first asked at no speed at all, and then at WOB_0 = 97347
    result = run(lambda bit_speed, WOB_0: 1e10 / WOB_0, overrides={"plant.Omega": 10.0})
    assert result["law.WOB"][0] == 1e10 / 97347.0
    with pytest.raises(FunctionError, match=r"law at t = 0.00 s: <lambda> raised ZeroDivisionError"):
        run(lambda bit_speed: 1.0 / bit_speed)
