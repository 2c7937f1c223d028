"""An illegal call is fmi2Error with memory intact: reset, restored states and steps work after it."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p

import pytest
from fmpy import fmi2

from tests.plant.drive import PLANT, Drive
from tests.plant.fmi import ERROR, OK, Instance, must

SLOW = {"cells": 60}
MODELS = [PLANT, "DissipativeLaw", "WeightOnBitLaw", "DrillingProgram"]
GET_SET = [f"{way}{kind}" for way in ("Get", "Set") for kind in ("Real", "Integer", "Boolean", "String")]
ARRAYS = {"Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p}
NULL = None


def kind_of(function: str) -> str:
    return function[3:]


def references(*numbers: int):
    return (c_uint * len(numbers))(*numbers)


def room(kind: str, count: int = 1):
    return (ARRAYS[kind] * count)()


def assert_usable(fmu: Instance) -> None:
    """Save, step, restore, reset, and step again."""
    state = fmu.serialized()
    assert fmu.restore(state) == OK
    must(fmu, fmu.call("Reset"))
    must(fmu, fmu.initialize(2.0))
    must(fmu, fmu.step(2.0, 0.25))
    must(fmu, fmu.call("Terminate"))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("function", GET_SET)
@pytest.mark.parametrize("number", [10000, 0x7FFFFFFF, 0xFFFFFFFF])
def test_unknown_value_reference_is_an_error(model, function, number):
    with Drive(model, {}) as fmu:
        assert fmu.call(function, references(number), 1, room(kind_of(function))) == ERROR
        assert f"there is no variable with value reference {number}" in fmu.messages[-1].text
        assert_usable(fmu)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("function", GET_SET)
def test_wrong_type_is_an_error(model, function):
    with Drive(model, {}) as fmu:
        for name in fmu.variables:
            if fmu.kind(name) != kind_of(function):
                assert fmu.call(function, fmu.references([name]), 1, room(kind_of(function))) == ERROR
                assert fmu.messages[-1].text.endswith(f"variable {name} is of type {fmu.kind(name)}")
        assert_usable(fmu)


@pytest.mark.parametrize("model", MODELS)
def test_setting_an_output_is_an_error_at_any_time(model):
    with Instance(model) as fmu:
        outputs = [name for name, variable in fmu.variables.items() if variable.causality == "output"]
        for _ in range(2):
            for name in outputs:
                assert fmu.set(**{name: 1}) == ERROR
                assert fmu.messages[-1].text.endswith(f"{name} is an output and cannot be set")
            must(fmu, fmu.initialize() if fmu.step(0.0, 1.0) == ERROR else OK)
        assert_usable(fmu)


@pytest.mark.parametrize("model", MODELS)
def test_setting_a_fixed_parameter_while_stepping_is_an_error_and_a_tunable_one_is_not(model):
    with Drive(model, {}) as fmu:
        for name, variable in fmu.variables.items():
            if variable.causality == "parameter" and fmu.kind(name) != "String":
                fixed = variable.variability == "fixed"
                assert fmu.set(**{name: fmu.get(name)}) == (ERROR if fixed else OK)
        assert_usable(fmu)


@pytest.mark.parametrize("function", GET_SET)
def test_null_pointers_are_an_error(function):
    with Drive("DrillingProgram", {}) as fmu:
        kind = kind_of(function)
        assert fmu.call(function, NULL, 1, room(kind)) == ERROR
        assert fmu.call(function, references(0), 1, NULL) == ERROR
        assert fmu.call(function, NULL, 0, NULL) == OK
        assert_usable(fmu)


def test_other_null_pointers_are_an_error():
    with Drive(PLANT, SLOW) as fmu:
        state = fmu.saved()
        omega = fmu.references(["Omega"])
        one, number, size = (c_int * 1)(1), c_double(), c_size_t()
        for call in (
            ("GetFMUstate", NULL),
            ("SetFMUstate", NULL),
            ("SerializedFMUstateSize", NULL, byref(size)),
            ("SerializedFMUstateSize", state, NULL),
            ("SerializeFMUstate", state, NULL, 10),
            ("SerializeFMUstate", NULL, b"", 0),
            ("DeSerializeFMUstate", NULL, 1000, byref(c_void_p())),
            ("DeSerializeFMUstate", b"x" * 99999, 99999, NULL),
            ("SetRealInputDerivatives", omega, 1, NULL, byref(number)),
            ("SetRealInputDerivatives", omega, 1, one, NULL),
            ("SetRealInputDerivatives", NULL, 1, one, byref(number)),
            ("GetRealOutputDerivatives", NULL, 1, one, byref(number)),
            ("SetDebugLogging", 1, 1, NULL),
        ):
            assert fmu.call(*call) == ERROR, call
        assert fmu.call("FreeFMUstate", NULL) == OK
        must(fmu, fmu.call("FreeFMUstate", byref(state)))
        assert_usable(fmu)


def test_an_instance_that_is_none_is_an_error():
    with Drive(PLANT, SLOW) as fmu:
        functions = fmu.library.functions
        number = c_double()
        assert functions["fmi2DoStep"](NULL, 0.0, 0.1, 0) == ERROR
        assert functions["fmi2GetReal"](NULL, references(0), 1, byref(number)) == ERROR
        assert functions["fmi2SetReal"](NULL, references(0), 1, byref(number)) == ERROR
        for name in ("Reset", "Terminate", "EnterInitializationMode", "ExitInitializationMode", "CancelStep"):
            assert functions[f"fmi2{name}"](NULL) == ERROR
        assert functions["fmi2GetFMUstate"](NULL, byref(c_void_p())) == ERROR
        assert functions["fmi2SetFMUstate"](NULL, NULL) == ERROR
        functions["fmi2FreeInstance"](NULL)


def before_initialization(fmu: Instance) -> None:
    """Leave the instance as it is after its instantiation."""


def in_initialization_mode(fmu: Instance) -> None:
    must(fmu, fmu.call("EnterInitializationMode"))


def stepping(fmu: Instance) -> None:
    must(fmu, fmu.initialize())
    must(fmu, fmu.step(0.0, 0.5))


def terminated(fmu: Instance) -> None:
    stepping(fmu)
    must(fmu, fmu.call("Terminate"))


CALLS = {
    "SetupExperiment": (0, 0.0, 0.0, 0, 0.0),
    "EnterInitializationMode": (),
    "ExitInitializationMode": (),
    "DoStep": (0.5, 0.1, 0),
    "Terminate": (),
    "GetReal": (references(2), 1, room("Real")),
    "SetReal": (references(0), 1, (c_double * 1)(3.0)),
    "SetRealInputDerivatives": (references(0), 1, (c_int * 1)(1), room("Real")),
}
PHASES: dict[Callable[[Instance], None], set[str]] = {
    before_initialization: {"SetupExperiment", "EnterInitializationMode", "SetReal", "SetRealInputDerivatives"},
    in_initialization_mode: {"ExitInitializationMode", "GetReal", "SetReal", "SetRealInputDerivatives"},
    stepping: {"DoStep", "Terminate", "GetReal", "SetReal", "SetRealInputDerivatives"},
    terminated: {"GetReal"},
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("phase", PHASES)
def test_call_in_the_wrong_phase_is_an_error(phase, call):
    with Instance(PLANT) as fmu:
        phase(fmu)
        status = fmu.call(call, *CALLS[call])
        if call in PHASES[phase]:
            assert status == OK
        else:
            assert status == ERROR
            assert f"fmi2{call} is not allowed while the instance is " in fmu.messages[-1].text
        must(fmu, fmu.call("Reset"))
        must(fmu, fmu.initialize())
        assert_usable(fmu)


@pytest.mark.parametrize("phase", PHASES)
def test_instance_can_be_freed_at_any_time(phase):
    with Instance(PLANT) as fmu:
        phase(fmu)


@pytest.mark.parametrize(("start", "stop"), [(float("nan"), None), (float("inf"), None), (5.0, 5.0), (5.0, 4.0)])
def test_experiment_without_a_time_to_live_is_an_error(start, stop):
    with Instance(PLANT) as fmu:
        assert fmu.call("SetupExperiment", 0, 0.0, start, int(stop is not None), stop or 0.0) == ERROR
        assert " time is " in fmu.messages[-1].text
        must(fmu, fmu.initialize())


def test_experiment_with_tolerance_and_stop_time_is_fine():
    with Instance(PLANT) as fmu:
        must(fmu, fmu.call("SetupExperiment", 1, 1e-6, 1.0, 1, 9.0))
        must(fmu, fmu.call("EnterInitializationMode"))
        must(fmu, fmu.call("ExitInitializationMode"))
        assert fmu.step(1.0, 0.5) == OK


def test_no_step_can_be_cancelled():
    with Drive(PLANT, SLOW) as fmu:
        assert fmu.call("CancelStep") == ERROR
        assert_usable(fmu)


def test_status_of_the_last_step_can_be_asked_for():
    with Drive(PLANT, SLOW) as fmu:
        fmu.go(0.75)
        fmu.step(0.75, -1.0)
        time, ended = c_double(), c_int(7)
        assert fmu.call("GetRealStatus", fmi2.fmi2LastSuccessfulTime, byref(time)) == OK
        assert fmu.call("GetBooleanStatus", fmi2.fmi2Terminated, byref(ended)) == OK
        assert (time.value, ended.value) == (0.75, 0)
        for name in ("Status", "IntegerStatus", "StringStatus"):
            assert fmu.call(f"Get{name}", fmi2.fmi2PendingStatus, NULL) != OK
        fmu.go(1.0)


def test_wrong_guid_name_and_kind_are_refused_at_the_instantiation():
    for options, reason in (
        ({"guid": "{00000000-0000-0000-0000-000000000000}"}, "the GUID is not that of this binary"),
        ({"name": ""}, "needs an instance name"),
        ({"kind": fmi2.fmi2ModelExchange}, "is for co-simulation only"),
    ):
        with Instance(PLANT, **options) as fmu:
            assert fmu.component is None
            assert reason in fmu.messages[-1].text
