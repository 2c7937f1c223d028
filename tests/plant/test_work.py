"""The work a second takes is bounded for all legal values: what takes more is refused by a sentence on what to set.

What parameters ask for all the time is refused before the start, what the motion asks for in the step that shows it.
"""

from __future__ import annotations

import json
import re
from importlib import import_module
from typing import Any

import pytest

from fmu_src.python.slave import TableSlave
from tests.plant.drive import DAMPED, PLANT, PLANTS, Drive
from tests.plant.fmi import DISCARD, ERROR, OK, Instance

TOO_MUCH: dict[str, tuple[str, dict[str, float], str, str]] = {
    "stiff bit": (PLANT, {"I_B": 1e-3}, "4791", "a greater I_B or a lower c_b"),
    "viscous bit": (PLANT, {"c_b": 1e6}, "179.8", "a greater I_B or a lower c_b"),
    "many cells": (PLANT, {"cells": 200000}, "268.9", "fewer cells or a longer L"),
    "short string": (PLANT, {"L": 1.0}, "50.43", "fewer cells or a longer L"),
    "strong damping": (DAMPED, {"beta": 6161.8}, "2.503e+05", "a lower beta or a shorter L"),
    "damped cells": (DAMPED, {"beta": 0.1, "cells": 20000}, "674.5", "a lower beta or a shorter L"),
    "damped length": (DAMPED, {"beta": 1e-3, "L": 1e5}, "79.42", "a lower beta or a shorter L"),
}

WILD = {"v_f": 1e-6, "mu_cb": 0.0, "mu_sb": 1.0, "I_B": 1.0}
"""A light bit on rock whose friction falls at once: a wave of 1e4 rad/s throws it about faster than can be followed."""

SPENT = (
    r"plant at t = 0\.01 s: at t = 0\.38\d+ s the bit moves so fast that a second takes more than 50 times the work of "
    "the start values: set a greater I_B, or change torque and weight less"
)


def slave_of(model: str, values: dict[str, Any]) -> TableSlave:
    """Return a slave of the python packaging in this process, initialised at 0 s."""
    slave = getattr(import_module(f"fmu_src.fmus.{model}.slave"), model)(instance_name="fmu")
    for name, value in values.items():
        variable = next(variable for variable in slave.model.variables if variable.name == name)
        getattr(slave, f"set_{variable.kind.lower()}")([slave.model.value_reference(name)], [value])
    slave.setup_experiment(0.0, None, None)
    slave.enter_initialization_mode()
    slave.exit_initialization_mode()
    return slave


@pytest.mark.parametrize("name", TOO_MUCH)
def test_parameters_that_take_too_much_work_are_refused_before_the_start(name: str) -> None:
    model, parameters, times, remedy = TOO_MUCH[name]
    expected = f"a second takes {times} times the work of the start values; expected at most 40: set {remedy}"
    slave = slave_of(model, parameters)
    assert [message.msg for message in slave.log_queue] == [f"fmu at t = 0.0 s: {expected}"]
    assert not slave.do_step(0.0, 0.01)
    with Instance(model) as plant:
        for parameter, value in parameters.items():
            assert plant.set(**{parameter: value}) == OK
        assert plant.initialize(0.0) == ERROR
        assert plant.messages[-1].text == f"plant at t = 0 s: {expected}"


def test_as_many_cells_as_are_allowed_give_the_cycle_of_fig_2() -> None:
    with Drive(PLANT, {"cells": 29744}) as plant:
        plant.go(3.0)
        assert plant.get("last_release_time") == pytest.approx(2.603019251, abs=1e-8)


@pytest.mark.parametrize("model", PLANTS)
def test_damping_of_the_bit_that_becomes_too_great_is_refused_and_the_old_kept(model: str) -> None:
    with Drive(model, {}) as plant, Drive(model, {}) as other:
        plant.go(3.0)
        other.go(3.0)
        assert plant.set(c_b=1e6) == OK
        assert plant.step(3.0, 1.0) == DISCARD
        assert "set a greater I_B or a lower c_b" in plant.messages[-1].text
        plant.put(c_b=0.03)
        plant.go(4.0)
        other.go(4.0)
        assert plant.outputs() == other.outputs()


@pytest.mark.parametrize("model", PLANTS)
@pytest.mark.parametrize("tuned", [{}, {"mu_sb": 0.9}], ids=["held", "tuned"])
def test_a_step_in_which_the_bit_is_too_fast_to_be_followed_leaves_no_trace(
    model: str, tuned: dict[str, float]
) -> None:
    damped = {"beta": 1e-3} if model == DAMPED else {}
    with Drive(model, WILD | damped) as plant, Drive(model, WILD | damped) as other:
        plant.go(0.01)
        other.go(0.01)
        plant.put(Omega=1e4, **tuned)
        other.put(Omega=1e4, **tuned)
        before = plant.serialized()
        assert plant.step(0.01, 1.0) == DISCARD
        assert re.fullmatch(SPENT, plant.messages[-1].text)
        assert plant.serialized() == before
        plant.go(0.3)  # the wave is not there yet
        other.go(0.3)
        assert plant.outputs() == other.outputs()


@pytest.mark.parametrize("model", PLANTS)
def test_both_packagings_refuse_the_same_step_and_go_on_alike(model: str) -> None:
    values = WILD | ({"beta": 1e-3} if model == DAMPED else {"cells": 92})
    slave = slave_of(model, values)
    reference = slave.model.value_reference
    with Drive(model, values) as plant:
        assert slave.do_step(0.0, 0.01)
        plant.go(0.01)
        slave.set_real([reference("Omega")], [1e4])
        plant.put(Omega=1e4)
        untouched = json.dumps(slave._get_fmu_state())
        assert not slave.do_step(0.01, 1.0)
        assert plant.step(0.01, 1.0) == DISCARD
        assert slave.log_queue[-1].msg.partition(": ")[2] == plant.messages[-1].text.partition(": ")[2]
        assert json.dumps(slave._get_fmu_state()) == untouched
        assert slave.do_step(0.01, 0.2)
        plant.go(0.21)
        assert slave.get_real([reference("bit_speed")]) == [plant.get("bit_speed")]
