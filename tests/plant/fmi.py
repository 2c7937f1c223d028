"""Calls an FMU of dist/ through the C functions of FMI 2.0 and gives back what it answers: statuses and messages."""

from __future__ import annotations

import atexit
import ctypes
import itertools
import shutil
from collections.abc import Iterable, Mapping
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Self

import fmpy
from fmpy import fmi2
from fmpy.logging import addLoggerProxy

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
DIST = Path(__file__).parents[2] / "dist"

_INTEGERS, _REALS, _TEXTS, _REFERENCES = POINTER(c_int), POINTER(c_double), POINTER(c_char_p), POINTER(c_uint)
_ACCESS = {"Real": _REALS, "Integer": _INTEGERS, "Boolean": _INTEGERS, "String": _TEXTS}
_ARGUMENTS: dict[str, tuple[Any, ...]] = {
    "fmi2SetDebugLogging": (c_int, c_size_t, _TEXTS),
    "fmi2SetupExperiment": (c_int, c_double, c_double, c_int, c_double),
    "fmi2EnterInitializationMode": (),
    "fmi2ExitInitializationMode": (),
    "fmi2DoStep": (c_double, c_double, c_int),
    "fmi2CancelStep": (),
    "fmi2Terminate": (),
    "fmi2Reset": (),
    "fmi2GetFMUstate": (POINTER(c_void_p),),
    "fmi2SetFMUstate": (c_void_p,),
    "fmi2FreeFMUstate": (POINTER(c_void_p),),
    "fmi2SerializedFMUstateSize": (c_void_p, POINTER(c_size_t)),
    "fmi2SerializeFMUstate": (c_void_p, c_char_p, c_size_t),
    "fmi2DeSerializeFMUstate": (c_char_p, c_size_t, POINTER(c_void_p)),
    "fmi2SetRealInputDerivatives": (_REFERENCES, c_size_t, _INTEGERS, _REALS),
    "fmi2GetRealOutputDerivatives": (_REFERENCES, c_size_t, _INTEGERS, _REALS),
    "fmi2GetDirectionalDerivative": (_REFERENCES, c_size_t, _REFERENCES, c_size_t, _REALS, _REALS),
    "fmi2GetStatus": (c_int, _INTEGERS),
    "fmi2GetRealStatus": (c_int, _REALS),
    "fmi2GetIntegerStatus": (c_int, _INTEGERS),
    "fmi2GetBooleanStatus": (c_int, _INTEGERS),
    "fmi2GetStringStatus": (c_int, _TEXTS),
    **{f"fmi2{way}{kind}": (_REFERENCES, c_size_t, array) for kind, array in _ACCESS.items() for way in ("Get", "Set")},
}


class Message(NamedTuple):
    """A message of an FMU to its logger."""

    instance: str
    status: int
    category: str
    text: str


@dataclass(frozen=True)
class Library:
    """An extracted FMU with its functions loaded."""

    folder: str
    description: Any
    functions: Mapping[str, Any]
    variables: Mapping[str, Any]


@cache
def library(model: str, packaging: str) -> Library:
    """Extract and load an FMU once in a process."""
    folder = fmpy.extract(DIST / packaging / f"{model}.fmu")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    description = fmpy.read_model_description(folder)
    file = Path(folder, "binaries", fmpy.platform, model + fmpy.sharedLibraryExtension)
    loaded = ctypes.CDLL(str(file))
    functions = {name: getattr(loaded, name) for name in _ARGUMENTS}
    for name, arguments in _ARGUMENTS.items():
        functions[name].argtypes = (c_void_p, *arguments)
    functions["fmi2Instantiate"] = loaded.fmi2Instantiate
    loaded.fmi2Instantiate.argtypes = (c_char_p, c_int, c_char_p, c_char_p, c_void_p, c_int, c_int)
    loaded.fmi2Instantiate.restype = c_void_p
    functions["fmi2FreeInstance"] = loaded.fmi2FreeInstance
    loaded.fmi2FreeInstance.argtypes, loaded.fmi2FreeInstance.restype = (c_void_p,), None
    return Library(folder, description, functions, {v.name: v for v in description.modelVariables})


# fmpy's helper, which fills in the arguments of printf, keeps one callback for the whole process
_listeners: dict[int, list[Message]] = {}
_keys = itertools.count(1 << 32)


def _receive(environment: int | None, name: bytes, status: int, category: bytes, text: bytes) -> None:
    _listeners.get(environment or 0, []).append(Message(name.decode(), status, category.decode(), text.decode()))


_logger = fmi2.fmi2CallbackLoggerTYPE(_receive)


class Instance:
    """An instance of an FMU, freed at the end of a with statement.

    Attributes
    ----------
    component : int or None
        None if the FMU refused to be instantiated.
    messages : list of Message
        What it has logged.
    """

    def __init__(
        self,
        model: str,
        packaging: str = "native",
        name: str = "plant",
        *,
        logging: bool = False,
        guid: str | None = None,
        kind: int = fmi2.fmi2CoSimulation,
    ) -> None:
        self.library = library(model, packaging)
        self.variables = self.library.variables
        self.messages: list[Message] = []
        self._key = next(_keys)
        _listeners[self._key] = self.messages
        self._callbacks = fmi2.fmi2CallbackFunctions(
            _logger, fmi2.defaultCallbacks.allocateMemory, fmi2.defaultCallbacks.freeMemory
        )
        self._callbacks.componentEnvironment = self._key
        addLoggerProxy(byref(self._callbacks))
        resources = Path(self.library.folder, "resources").as_uri().encode()
        guid = self.library.description.guid if guid is None else guid
        self.component = self.library.functions["fmi2Instantiate"](
            name.encode(), kind, guid.encode(), resources, byref(self._callbacks), 0, int(logging)
        )

    def call(self, function: str, *arguments: Any) -> int:
        """Call fmi2<function> and return its status."""
        return self.library.functions[f"fmi2{function}"](self.component, *arguments)

    def initialize(self, start: float = 0.0) -> int:
        """Go from the instantiation to the first communication point; return the status of the last call."""
        setup = self.call("SetupExperiment", 0, 0.0, start, 0, 0.0)
        return setup or self.call("EnterInitializationMode") or self.call("ExitInitializationMode")

    def step(self, point: float, size: float) -> int:
        """Take a step from a communication point [s]."""
        return self.call("DoStep", point, size, 0)

    def set(self, **values: float | str) -> int:
        """Set variables of one type in one call."""
        kind = self.kind(next(iter(values)))
        convert = {"Boolean": int, "String": lambda value: str(value).encode()}.get(kind, lambda value: value)
        elements = [convert(value) for value in values.values()]
        array = (_ACCESS[kind]._type_ * len(elements))(*elements)
        return self.call(f"Set{kind}", self.references(values), len(elements), array)

    def set_slopes(self, **slopes: float) -> int:
        """Set the derivatives of inputs for the next step."""
        n = len(slopes)
        return self.call(
            "SetRealInputDerivatives",
            self.references(slopes),
            n,
            (c_int * n)(*[1] * n),
            (c_double * n)(*slopes.values()),
        )

    def rate(self, name: str) -> float:
        """Return the first derivative of an output by time; an error is raised."""
        value = c_double()
        arguments = self.references([name]), 1, (c_int * 1)(1), byref(value)
        must(self, self.call("GetRealOutputDerivatives", *arguments))
        return value.value

    def sensitivity(self, name: str, **seeds: float) -> float:
        """Return the derivative of an output in a direction of inputs and parameters; an error is raised."""
        change, n = c_double(), len(seeds)
        known = self.references(seeds), n, (c_double * n)(*seeds.values())
        must(self, self.call("GetDirectionalDerivative", self.references([name]), 1, *known, byref(change)))
        return change.value

    def get(self, name: str) -> float:
        """Return the value of a variable; an error is raised."""
        kind = self.kind(name)
        value = _ACCESS[kind]._type_()
        must(self, self.call(f"Get{kind}", self.references([name]), 1, byref(value)))
        return value.value

    def kind(self, name: str) -> str:
        """Return the type of a variable as the functions of FMI name it."""
        declared = self.variables[name].type
        return "Integer" if declared == "Enumeration" else declared

    def references(self, names: Iterable[str]) -> Any:
        """Return an array of value references."""
        numbers = [self.variables[name].valueReference for name in names]
        return (c_uint * len(numbers))(*numbers)

    def saved(self) -> c_void_p:
        """Return the state, to be given back by `call("FreeFMUstate", byref(state))`."""
        state = c_void_p()
        must(self, self.call("GetFMUstate", byref(state)))
        return state

    def serialized(self) -> bytes:
        """Return the state as bytes."""
        state, size = self.saved(), c_size_t()
        must(self, self.call("SerializedFMUstateSize", state, byref(size)))
        content = ctypes.create_string_buffer(size.value)
        must(self, self.call("SerializeFMUstate", state, content, size))
        must(self, self.call("FreeFMUstate", byref(state)))
        return content.raw

    def restore(self, content: bytes) -> int:
        """Deserialise a state and go to it; return the status of the first call that fails."""
        state = c_void_p()
        status = self.call("DeSerializeFMUstate", content, len(content), byref(state))
        if status == OK:
            status = self.call("SetFMUstate", state)
        self.call("FreeFMUstate", byref(state))
        return status

    def free(self) -> None:
        """Free the instance."""
        if self.component is not None:
            self.library.functions["fmi2FreeInstance"](self.component)
            self.component = None
        _listeners.pop(self._key, None)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.free()


def must(instance: Instance, status: int) -> None:
    """Raise what the instance has logged unless a call went well."""
    if status != OK:
        raise RuntimeError(f"status {status}: {[message.text for message in instance.messages]}")
