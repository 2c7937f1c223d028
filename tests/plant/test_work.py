"""Parameters that take too much work all the time are refused before the start, by a sentence on what to set."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import pytest

from fmu_src.python.slave import TableSlave
from tests.plant.drive import DAMPED, PLANT, PLANTS, Drive
from tests.plant.fmi import DISCARD, ERROR, OK, Instance

TOO_MUCH: dict[str, tuple[str, dict[str, float], str, str]] = {
    "stiff bit": (PLANT, {"I_B": 1e-3}, "2396", "a greater I_B or a lower c_b"),
    "viscous bit": (PLANT, {"c_b": 1e6}, "89.91", "a greater I_B or a lower c_b"),
    "many cells": (PLANT, {"cells": 200000}, "268.9", "fewer cells or a longer L"),
    "short string": (PLANT, {"L": 1.0}, "50.43", "fewer cells or a longer L"),
    "strong damping": (DAMPED, {"beta": 6161.8}, "2.503e+05", "a lower beta or a shorter L"),
    "damped cells": (DAMPED, {"beta": 0.1, "cells": 20000}, "674.5", "a lower beta or a shorter L"),
    "damped length": (DAMPED, {"beta": 1e-3, "L": 1e5}, "79.42", "a lower beta or a shorter L"),
}


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
    expected = f"a second takes {times} times the work of the start values; expected at most 50: set {remedy}"
    slave = slave_of(model, parameters)
    assert [message.msg for message in slave.log_queue] == [f"fmu at t = 0.0 s: {expected}"]
    assert not slave.do_step(0.0, 0.01)
    with Instance(model) as plant:
        for parameter, value in parameters.items():
            assert plant.set(**{parameter: value}) == OK
        assert plant.initialize(0.0) == ERROR
        assert plant.messages[-1].text == f"plant at t = 0 s: {expected}"


def test_as_many_cells_as_are_allowed_give_the_cycle_of_fig_2() -> None:
    with Drive(PLANT, {"cells": 37184}) as plant:
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
