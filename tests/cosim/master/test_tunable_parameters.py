"""Tunable parameters that signals drive: set between steps, as by hand, whatever takes the steps."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from cosim import Component, Connection, Result, Scenario, SlaveError, Step, System, load_scenario, ramp, simulate
from cosim.cli.app import app
from cosim.drilling.energy_growth import energy_growth
from cosim.errors import InputError, SspError
from cosim.scenario.scenario import Variant
from cosim.scenario.ssp.writing import export_ssp
from cosim.system.dependency import feedthrough_reach
from cosim.system.description import Variable
from tests.cosim.fakes import describe
from tests.plant.drive import PLANT, Drive

STOP, SIZE = 4.0, 0.01
TUNED = {"plant.c_b": ramp(0.03, 120.0, 2.65, 1.0), "plant.mu_sb": Step(0.8, 0.6, 2.0)}
"""While the bit sticks and while it slips: it breaks loose at 2 s, with less friction then."""


def tuned(algorithm: str = "gauss-seidel", *, compiled: bool = True) -> Scenario:
    inputs = {"plant.Omega": 10.0, "plant.WOB": 97347.0, **TUNED}
    scenario = Scenario("tuned", System((Component("plant", PLANT),), (), inputs), stop_time=STOP, step_size=SIZE)
    return replace(scenario, method=replace(scenario.method, algorithm=algorithm, compiled=compiled))


def assert_same(first: Result, second: Result) -> None:
    assert list(first.names) == list(second.names)
    for name in first.names:
        assert first[name].tobytes() == second[name].tobytes(), name


def test_a_parameter_changes_as_where_it_is_set_by_hand_between_steps() -> None:
    """Through calls of FMI that share no code with the master: each value is that at the beginning of its step."""
    result = simulate(tuned())
    with Drive(PLANT, {"c_b": 0.03}) as plant:
        rows = [plant.outputs()]
        for begin in result.time[:-1]:
            plant.put(c_b=min(max(0.03 + (begin - 2.65) * (120.0 - 0.03), 0.03), 120.0))
            plant.put(mu_sb=0.6 if begin >= 2.0 else 0.8)
            plant.go(float(begin) + SIZE)
            rows.append(plant.outputs())
    by_hand = dict(zip(plant.names, np.array(rows).T, strict=True))
    assert result["plant.c_b"][[0, 265, 366, 400]] == pytest.approx([0.03, 0.03, 120.0, 120.0])
    assert (result["plant.mu_sb"][[200, 201]] == [0.8, 0.6]).all()
    for name in ("bit_speed", "bit_torque", "top_torque"):
        # rounding in the ramp, of 1e-14, through a slip
        assert result[f"plant.{name}"] == pytest.approx(by_hand[name], abs=1e-7), name
    assert by_hand["slip_count"][-1] == 1


def test_all_that_takes_steps_gives_the_same_bits() -> None:
    result = simulate(tuned())
    assert result.record["step_loop"] == "compiled"
    assert_same(result, simulate(tuned(compiled=False)))
    assert_same(result, simulate(tuned(), isolate=True))
    implicit = simulate(tuned("implicit"))
    for name in ("plant.bit_speed", "plant.energy", "plant.c_b"):
        assert implicit[name].tobytes() == result[name].tobytes(), name


@pytest.mark.slow
def test_both_packagings_give_the_same_bits() -> None:
    assert_same(simulate(tuned()), simulate(tuned(), packaging="python"))


def test_a_constant_is_a_parameter_that_is_set_before_the_start() -> None:
    """`--set` and variants make a constant of a signal."""
    options = {"stop_time": 6.0, "step_size": 0.01}
    driven = simulate(load_scenario("mud"), overrides={"plant.c_b": 15.0}, **options)
    set_once = simulate(load_scenario("bit-damping"), variant="c_b=15", **options)
    for name in set_once.names:
        assert driven[name].tobytes() == set_once[name].tobytes(), name


@pytest.mark.slow
def test_a_manifest_tells_what_a_signal_drives_among_the_inputs(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    arguments = ["run", "downhole-tool", "--stop-time", "61", "--output", str(folder)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    told = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["variants"][0]
    assert told["inputs"]["plant.c_b"]["points"] == [0.03, 130.0, 130.0, 0.03]
    assert "c_b" not in told["components"]["plant"]["parameters"]
    assert told["components"]["plant"]["parameters"]["mu_sb"] == 0.8
    assert "plant.c_b" in (folder / "trajectory.csv").read_text(encoding="utf-8").splitlines()[0].split(",")


def test_what_an_fmu_refuses_is_told_with_the_time() -> None:
    scenario = tuned()
    crossing = {**scenario.system.inputs, "plant.mu_sb": Step(0.8, 0.4, 1.5)}
    with pytest.raises(SlaveError, match=r"plant at t = 1\.50 s: .*mu_cb"):
        simulate(replace(scenario, system=replace(scenario.system, inputs=crossing)))


def test_ssp_holds_a_constant_and_refuses_what_changes(tmp_path: Path) -> None:
    path = tmp_path / "mud.ssp"
    with pytest.raises(SspError, match=r"plant\.c_b is driven by a table; SSP can hold constants"):
        export_ssp(load_scenario("mud"), path)
    export_ssp(load_scenario("mud"), path, overrides={"plant.c_b": 15.0})
    found = simulate(path, stop_time=5.0)
    expected = simulate(load_scenario("bit-damping"), variant="c_b=15", stop_time=5.0)
    assert found["plant.bit_speed"].tobytes() == expected["plant.bit_speed"].tobytes()


def test_all_outputs_may_jump_with_a_parameter() -> None:
    """Descriptions do not tell what depends on one, so that inputs behind any output are taken to jump with it."""
    known = describe({"u": 0.0}, ("y", "z"), extra=(Variable("p", 9, "Real", "parameter", "tunable", start="1"),),
                     feedthrough={"y": ["u"], "z": []})  # fmt: skip
    system = System(
        (Component("a", "a.fmu"), Component("b", "b.fmu")),
        (Connection("a.z", "b.u"), Connection("b.y", "a.u")),
        {"a.p": Step(1.0, 2.0, 0.5)},
    )
    assert feedthrough_reach(system, {"a": known, "b": known})["a.p"] == {"b.u", "a.u"}


def test_an_account_by_parameters_refuses_one_that_changes() -> None:
    scenario = load_scenario("dissipative-law")
    inputs = {**scenario.system.inputs, "law.c_1": Step(0.3, 0.2, 0.5)}
    law = replace(scenario.system.components[2], parameters={"c_2": 2.0})
    system = replace(scenario.system, inputs=inputs, components=(*scenario.system.components[:2], law))
    result = simulate(replace(scenario, system=system, variants=(Variant("printed", {}),)), stop_time=1.0)
    with pytest.raises(InputError, match=r"law\.c_1 is driven by a signal; expected a parameter that does not change"):
        energy_growth(result)
