"""An illegal call is fmi2Error with memory intact: reset, restored states and steps work after it."""

from __future__ import annotations

import ctypes
from ctypes import byref, c_char_p, c_double, c_int, c_uint
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy import fmi2

from fmu_src.fmus import MODELS
from tests.plant.calls import ALLOWED, NULL, START, arguments, saved
from tests.plant.drive import PLANT, Drive
from tests.plant.fmi import DISCARD, ERROR, OK, Instance, must

SLOW = {"cells": 60}
GET_SET = [f"{way}{kind}" for way in ("Get", "Set") for kind in ("Real", "Integer", "Boolean", "String")]
ARRAYS = {"Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p}
MODEL_EXCHANGE = (
    "EnterEventMode", "NewDiscreteStates", "EnterContinuousTimeMode", "CompletedIntegratorStep", "SetTime",
    "SetContinuousStates", "GetDerivatives", "GetEventIndicators", "GetContinuousStates",
    "GetNominalsOfContinuousStates",
)  # fmt: skip


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
                assert fmu.messages[-1].text.endswith(f"variable {name} is of type {fmu.variables[name].type}")
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


POINTERS: dict[str, tuple[int, ...]] = {
    # places of the arguments that must not be null
    "SetDebugLogging": (2,),
    "GetReal": (0, 2),
    "SetReal": (0, 2),
    "GetFMUstate": (0,),
    "SetFMUstate": (0,),
    "SerializedFMUstateSize": (0, 1),
    "SerializeFMUstate": (0, 1),
    "DeSerializeFMUstate": (0, 2),
    "GetDirectionalDerivative": (0, 2, 4, 5),
    "SetRealInputDerivatives": (0, 2, 3),
    "GetRealOutputDerivatives": (0, 2, 3),
    "GetStatus": (1,),
    "GetRealStatus": (1,),
    "GetIntegerStatus": (1,),
    "GetBooleanStatus": (1,),
    "GetStringStatus": (1,),
}


@pytest.mark.parametrize("model", MODELS)
def test_a_null_pointer_is_refused_without_a_trace(model):
    with Drive(model, START[model]) as fmu:
        fmu.go(0.5)
        objects = saved(fmu)
        for function, places in POINTERS.items():
            for place in places:
                given = list(arguments(fmu, model, objects)[function])
                if (
                    function in ("SetRealInputDerivatives", "GetDirectionalDerivative")
                    and not MODELS[model].has_real_inputs
                ):
                    continue  # without inputs there is nothing to point to
                given[place] = NULL
                fmu.messages.clear()
                assert fmu.call(function, *given) == ERROR, (function, place)
                (message,) = fmu.messages
                assert message.text.startswith("plant at t = 0.5 s: ")
                assert fmu.serialized() == objects.content
        assert fmu.call("FreeFMUstate", NULL) == OK
        fmu.go(1.0)


@pytest.mark.parametrize("model", MODELS)
def test_arrays_of_no_length_may_be_null(model):
    with Drive(model, START[model]) as fmu:
        for kind in ("Real", "Integer", "Boolean", "String"):
            for way in ("Get", "Set"):
                assert fmu.call(f"{way}{kind}", NULL, 0, NULL) == OK
        assert fmu.call("SetRealInputDerivatives", NULL, 0, NULL, NULL) == OK
        assert fmu.call("GetRealOutputDerivatives", NULL, 0, NULL, NULL) == OK
        assert fmu.call("SetDebugLogging", 0, 0, NULL) == OK
        fmu.go(0.5)


def test_no_instance_is_an_error_of_every_function():
    with Drive(PLANT, START[PLANT]) as fmu:
        objects = saved(fmu)
        for function, given in arguments(fmu, PLANT, objects).items():
            assert fmu.library.functions[f"fmi2{function}"](NULL, *given) == ERROR, function
        fmu.library.functions["fmi2FreeInstance"](NULL)
        assert fmu.messages == []
        assert fmu.serialized() == objects.content


@pytest.mark.parametrize("model", MODELS)
def test_the_library_has_all_functions_of_co_simulation_and_none_of_model_exchange(model):
    with Instance(model) as fmu:
        folder = Path(fmu.library.folder, "binaries", fmpy.platform)
        (file,) = folder.glob(f"{model}.*")
    library = ctypes.CDLL(str(file))
    for function in (*ALLOWED, "Instantiate", "FreeInstance", "GetVersion", "GetTypesPlatform"):
        assert hasattr(library, f"fmi2{function}"), function
    for function in MODEL_EXCHANGE:
        assert not hasattr(library, f"fmi2{function}"), function
    for function, text in (("GetVersion", b"2.0"), ("GetTypesPlatform", b"default")):
        call = getattr(library, f"fmi2{function}")
        call.restype = c_char_p
        assert call() == text


_unheard = fmi2.fmi2CallbackLoggerTYPE(lambda *_: None)


def instantiated(model: str, name: bytes = b"x", resources: bytes | None = None, logger: bool = False) -> Any:
    """Return what fmi2Instantiate returns for bare callbacks."""
    with Instance(model) as fmu:
        functions, guid = fmu.library.functions, fmu.library.description.guid
    callbacks = fmi2.fmi2CallbackFunctions()
    if logger:
        callbacks.logger = _unheard
    return functions["fmi2Instantiate"](name, fmi2.fmi2CoSimulation, guid.encode(), resources, byref(callbacks), 0, 1)


@pytest.mark.parametrize("logger", [False, True])
@pytest.mark.parametrize("model", MODELS)
def test_callbacks_environment_and_resources_may_be_null(model, logger):
    component = instantiated(model, logger=logger)
    assert component is not None
    with Instance(model) as fmu:
        functions = fmu.library.functions
    assert functions["fmi2DoStep"](component, 0.0, 0.1, 0) == ERROR
    assert functions["fmi2SetupExperiment"](component, 0, 0.0, 0.0, 0, 0.0) == OK
    assert functions["fmi2EnterInitializationMode"](component) == OK
    assert functions["fmi2ExitInitializationMode"](component) == OK
    assert functions["fmi2DoStep"](component, 0.0, -0.1, 0) == DISCARD
    assert functions["fmi2DoStep"](component, 0.0, 5.0, 0) == OK
    assert functions["fmi2Terminate"](component) == OK
    functions["fmi2FreeInstance"](component)


@pytest.mark.parametrize("name", [b"", b" ", b"\t\n"])
def test_a_name_of_nothing_but_blanks_is_refused(name):
    assert instantiated(PLANT, name) is None


def test_null_arguments_of_the_instantiation_are_refused():
    with Instance(PLANT) as fmu:
        instantiate, guid = fmu.library.functions["fmi2Instantiate"], fmu.library.description.guid.encode()
        callbacks = byref(fmi2.fmi2CallbackFunctions())
        assert instantiate(NULL, fmi2.fmi2CoSimulation, guid, NULL, callbacks, 0, 0) is None
        assert instantiate(b"x", fmi2.fmi2CoSimulation, NULL, NULL, callbacks, 0, 0) is None
        assert instantiate(b"x", fmi2.fmi2CoSimulation, guid, NULL, NULL, 0, 0) is None


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
