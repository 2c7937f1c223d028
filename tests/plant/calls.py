"""The table of FMI 2.0.4, section 4.2.4: which function is allowed in which state, and arguments to call it with."""

from __future__ import annotations

import ctypes
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_void_p
from typing import Any, NamedTuple

from fmpy import fmi2

from fmu_src.fmus import MODELS
from fmu_src.schema import Model
from tests.plant.drive import PLANTS
from tests.plant.fmi import DISCARD, ERROR, OK, Instance, must


def _tunable(model: Model) -> str:
    """Return a variable that can be set to 0.5 at any time."""
    for variable in (*model.select("parameter"), *model.select("input")):
        low, high = variable.bounds
        if variable.kind == "Real" and variable.variability != "fixed" and low <= 0.5 <= high:
            return variable.name
    raise ValueError(f"{model.name} has no Real that can be set to 0.5 at any time")


def _output(model: Model) -> str:
    """Return a Real output, one that answers an input at once if there is any."""
    outputs = [variable for variable in model.select("output") if variable.kind == "Real"]
    return next((output.name for output in outputs if output.dependencies), outputs[0].name)


TUNABLE = {name: _tunable(model) for name, model in MODELS.items()}
OUTPUT = {name: _output(model) for name, model in MODELS.items()}
START: dict[str, dict[str, Any]] = {model: {"cells": 60} if model in PLANTS else {} for model in MODELS}

INSTANTIATED, INITIALIZATION, COMPLETE, FAILED, TERMINATED, IN_ERROR = (
    "instantiated",
    "initialization",
    "complete",
    "failed",
    "terminated",
    "error",
)
EVER = {INSTANTIATED, INITIALIZATION, COMPLETE, FAILED, TERMINATED, IN_ERROR}
READ = EVER - {INSTANTIATED}
RUN = {COMPLETE, FAILED, TERMINATED}
WRITE = {INSTANTIATED, INITIALIZATION, COMPLETE}
ALLOWED: dict[str, set[str]] = {
    "SetDebugLogging": EVER,
    "SetupExperiment": {INSTANTIATED},
    "EnterInitializationMode": {INSTANTIATED},
    "ExitInitializationMode": {INITIALIZATION},
    "Terminate": {COMPLETE, FAILED},
    "Reset": EVER,
    "GetReal": READ,
    "GetInteger": READ,
    "GetBoolean": READ,
    "GetString": READ,
    "SetReal": WRITE,
    "SetInteger": WRITE,
    "SetBoolean": WRITE,
    "SetString": WRITE,
    "GetFMUstate": EVER,
    "SetFMUstate": EVER,
    "FreeFMUstate": EVER,
    "SerializedFMUstateSize": EVER,
    "SerializeFMUstate": EVER,
    "DeSerializeFMUstate": EVER,
    "GetDirectionalDerivative": READ,
    "SetRealInputDerivatives": WRITE,
    "GetRealOutputDerivatives": RUN | {IN_ERROR},
    "DoStep": {COMPLETE},
    "CancelStep": set(),
    "GetStatus": RUN,
    "GetRealStatus": RUN,
    "GetIntegerStatus": RUN,
    "GetBooleanStatus": RUN,
    "GetStringStatus": RUN,
}
UNCHANGED = {FAILED, IN_ERROR}
"""Here the instance is as it was while stepping, and serves what it served then."""
WITHOUT_ANSWER = {"GetStatus", "GetIntegerStatus", "GetStringStatus"}
"""Allowed, but there is no such status to get: fmi2Discard."""
NULL = None


def served(function: str, state: str) -> bool:
    """Return whether a call must succeed."""
    return state in ALLOWED[function] or (state in UNCHANGED and COMPLETE in ALLOWED[function])


def bring(fmu: Instance, state: str) -> None:
    """Bring an instance into a state, at 0.5 s if it is stepping."""
    if state == INSTANTIATED:
        return
    must(fmu, fmu.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0))
    must(fmu, fmu.call("EnterInitializationMode"))
    if state == INITIALIZATION:
        return
    must(fmu, fmu.call("ExitInitializationMode"))
    must(fmu, fmu.step(0.0, 0.5))
    if state == TERMINATED:
        must(fmu, fmu.call("Terminate"))
    if state == FAILED:
        assert fmu.step(0.5, -0.1) == DISCARD
    if state == IN_ERROR:
        assert fmu.call("GetReal", (ctypes.c_uint * 1)(9999), 1, byref(c_double())) == ERROR


class Objects(NamedTuple):
    """Memory that arguments point to; kept alive by the test."""

    state: c_void_p
    content: bytes


def saved(fmu: Instance) -> Objects:
    """Return a state of an instance in memory and as bytes."""
    return Objects(fmu.saved(), fmu.serialized())


def arguments(fmu: Instance, model: str, objects: Objects) -> dict[str, tuple[Any, ...]]:
    """Return arguments that make every call legal in its states."""
    tunable, output, order = fmu.references([TUNABLE[model]]), fmu.references([OUTPUT[model]]), (c_int * 1)(1)
    inputs = [
        name for name, variable in fmu.variables.items() if variable.causality == "input" and variable.type == "Real"
    ]
    known = fmu.references(inputs), len(inputs), (c_double * len(inputs))()
    nothing = {f"{way}{kind}": (NULL, 0, NULL) for way in ("Get", "Set") for kind in ("Integer", "Boolean", "String")}
    size = len(objects.content)
    return dict.fromkeys(ALLOWED, ()) | nothing | {
        "SetDebugLogging": (0, 1, (c_char_p * 1)(b"logEvents")),
        "SetupExperiment": (0, 0.0, 0.0, 1, 100.0),
        "GetReal": (output, 1, (c_double * 1)()),
        "SetReal": (tunable, 1, (c_double * 1)(0.5)),
        "GetFMUstate": (byref(c_void_p()),),
        "SetFMUstate": (objects.state,),
        "FreeFMUstate": (byref(c_void_p()),),
        "SerializedFMUstateSize": (objects.state, byref(c_size_t())),
        "SerializeFMUstate": (objects.state, ctypes.create_string_buffer(size), size),
        "DeSerializeFMUstate": (objects.content, size, byref(c_void_p())),
        "GetDirectionalDerivative": (output, 1, *known, (c_double * 1)()),
        "SetRealInputDerivatives": (known[0], known[1], (c_int * len(inputs))(*[1] * len(inputs)), known[2]),
        "GetRealOutputDerivatives": (output, 1, order, (c_double * 1)()),
        "DoStep": (0.5, 0.25, 0),
        "GetStatus": (fmi2.fmi2DoStepStatus, byref(c_int())),
        "GetRealStatus": (fmi2.fmi2LastSuccessfulTime, byref(c_double())),
        "GetIntegerStatus": (fmi2.fmi2DoStepStatus, byref(c_int())),
        "GetBooleanStatus": (fmi2.fmi2Terminated, byref(c_int())),
        "GetStringStatus": (fmi2.fmi2PendingStatus, byref(c_char_p())),
    }  # fmt: skip


def due(model: str, function: str, state: str) -> int:
    """Return the status a call must have."""
    provided = function != "GetDirectionalDerivative" or MODELS[model].has_real_inputs
    if not (served(function, state) and provided):
        return ERROR
    return DISCARD if function in WITHOUT_ANSWER else OK
