"""The functions of FMI 2.0 for co-simulation: what they take and return, and how one is bound.

All calls of the master and of the check go through here. Pointers are plain addresses: ctypes then takes arrays,
references and numbers alike, and a step can be given addresses within the recording. fmpy's own functions are left
alone, as its wrappers build new arrays for each call, which costs more than many an FMU takes for a step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from ctypes import Array, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from dataclasses import dataclass
from typing import Any, cast

from cosim.recording.record import Section, Slopes
from cosim.system.description import Description

OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
STATUS = ("fmi2OK", "fmi2Warning", "fmi2Discard", "fmi2Error", "fmi2Fatal", "fmi2Pending")
ACCEPTED = (OK, WARNING)
LAST_SUCCESSFUL_TIME, TERMINATED = 2, 3
"""The fmi2StatusKinds that tell, after a discarded step, how far the FMU came and whether it wants to end."""
CO_SIMULATION = 1
"""The fmi2Type of an instance."""

ELEMENTS: Mapping[str, Any] = {"Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p}
"""The C type of the values of each base type."""

_ADDRESS = c_void_p
_ARGUMENTS: Mapping[str, tuple[Any, ...]] = {
    "SetDebugLogging": (c_int, c_size_t, _ADDRESS),
    "SetupExperiment": (c_int, c_double, c_double, c_int, c_double),
    "EnterInitializationMode": (),
    "ExitInitializationMode": (),
    "DoStep": (c_double, c_double, c_int),
    "Terminate": (),
    "Reset": (),
    "GetFMUstate": (_ADDRESS,),
    "SetFMUstate": (_ADDRESS,),
    "FreeFMUstate": (_ADDRESS,),
    "SerializedFMUstateSize": (_ADDRESS, _ADDRESS),
    "SerializeFMUstate": (_ADDRESS, _ADDRESS, c_size_t),
    "DeSerializeFMUstate": (_ADDRESS, c_size_t, _ADDRESS),
    "SetRealInputDerivatives": (_ADDRESS, c_size_t, _ADDRESS, _ADDRESS),
    "GetRealOutputDerivatives": (_ADDRESS, c_size_t, _ADDRESS, _ADDRESS),
    "GetDirectionalDerivative": (_ADDRESS, c_size_t, _ADDRESS, c_size_t, _ADDRESS, _ADDRESS),
    "GetRealStatus": (c_int, _ADDRESS),
    "GetBooleanStatus": (c_int, _ADDRESS),
    **{f"{way}{kind}": (_ADDRESS, c_size_t, _ADDRESS) for kind in ELEMENTS for way in ("Get", "Set")},
}
CALLS = tuple(_ARGUMENTS)
"""Functions that return a status, by their names without the prefix."""

_SIGNATURES: Mapping[str, tuple[tuple[Any, ...], Any]] = {
    **{name: ((c_void_p, *arguments), c_int) for name, arguments in _ARGUMENTS.items()},
    "Instantiate": ((c_char_p, c_int, c_char_p, c_char_p, _ADDRESS, c_int, c_int), c_void_p),
    "FreeInstance": ((c_void_p,), None),
    "GetVersion": ((), c_char_p),
    "GetTypesPlatform": ((), c_char_p),
}


def bind(library: Any, name: str) -> Callable[..., Any]:
    """Return fmi2<name>, a bare function of a library; indexing makes a new object, so fmpy's keeps its own types."""
    function = library[f"fmi2{name}"]
    function.argtypes, function.restype = _SIGNATURES[name]
    return cast("Callable[..., Any]", function)


def status_name(status: int) -> str:
    """Name a status."""
    return STATUS[status] if 0 <= status < len(STATUS) else f"the illegal status {status}"


def element(kind: str, value: object) -> Any:
    """Return a value of a base type as it is in C."""
    return ELEMENTS[kind](value.encode() if isinstance(value, str) else value)


def set_one(call: Callable[..., int], kind: str, reference: int, value: object) -> int:
    """Set one variable, by what calls a function with its arguments but the instance, and return the status."""
    return call(f"Set{kind}", byref(c_uint(reference)), 1, byref(element(kind, value)))


def get_one(call: Callable[..., object], kind: str, reference: int) -> Any:
    """Get one variable, by what calls a function or raises; None for a String that is a null pointer."""
    value = ELEMENTS[kind]()
    call(f"Get{kind}", byref(c_uint(reference)), 1, byref(value))
    if kind == "String":
        return None if value.value is None else value.value.decode("utf-8", "replace")
    return bool(value.value) if kind == "Boolean" else value.value


_NEVER_ENDS = "drillstring-cosim"
"""Exporter whose FMUs never ask for the end; but in their python packaging, the library of pythonfmu says that of every
step that is refused."""


def asks_to_end(call: Callable[..., int], description: Description) -> bool:
    """Tell whether a step was discarded because the FMU wants no more of them (FMI 2.0.4, section 4.2.2)."""
    if description.generation_tool.startswith(_NEVER_ENDS):
        return False
    wanted = c_int()
    return call("GetBooleanStatus", TERMINATED, byref(wanted)) in ACCEPTED and bool(wanted.value)


@dataclass(frozen=True)
class SectionExchange:
    """One getter or setter on a column range of a section; a row's values begin at `base` + row * `stride`."""

    function: Callable[[c_void_p, c_void_p, c_size_t, int], int]
    name: str
    references: c_void_p
    count: c_size_t
    base: int
    stride: int


@dataclass(frozen=True)
class StringExchange:
    """The getter or setter of the first `count` columns of a section of strings."""

    function: Callable[[c_void_p, c_void_p, c_size_t, Any], int]
    name: str
    section: Section
    count: int

    def get(self, instance: c_void_p, row: int) -> int:
        """Get the strings into a row, copied before the FMU is called again, and return the status."""
        texts = (c_char_p * self.count)()
        status = self._call(instance, texts)
        if status in ACCEPTED:
            self.section.values[row, : self.count] = [(text or b"").decode("utf-8", "replace") for text in texts]
        return status

    def set(self, instance: c_void_p, row: int) -> int:
        """Set the strings of a row, and return the status."""
        return self._call(instance, (c_char_p * self.count)(*(text.encode() for text in self._row(row))))

    def _call(self, instance: c_void_p, texts: Array[c_char_p]) -> int:
        return self.function(instance, c_void_p(self.section.references.ctypes.data), c_size_t(self.count), texts)

    def _row(self, row: int) -> list[str]:
        return self.section.values[row, : self.count].tolist()


@dataclass(frozen=True)
class SlopeExchange:
    """The setter or getter of first derivatives, and where those of a row are, as in `SectionExchange`."""

    function: Callable[[c_void_p, c_void_p, c_size_t, c_void_p, int], int]
    name: str
    references: c_void_p
    count: c_size_t
    orders: c_void_p
    base: int
    stride: int


@dataclass(frozen=True)
class StepCalls:
    """Hold what a step calls: bare functions of the library, on addresses within the recording."""

    instance: c_void_p
    do_step: Callable[[c_void_p, float, float, c_int], int]
    writes: tuple[SectionExchange, ...]
    reads: tuple[SectionExchange, ...]
    input_slopes: SlopeExchange | None
    output_slopes: SlopeExchange | None


def exchange(library: Any, verb: str, kind: str, section: Section, count: int) -> SectionExchange:
    """Bind a getter or setter to the first `count` columns of a section."""
    return SectionExchange(
        bind(library, f"{verb}{kind}"),
        f"fmi2{verb}{kind}",
        c_void_p(section.references.ctypes.data),
        c_size_t(count),
        section.values.ctypes.data,
        section.values.strides[0],
    )


def string_exchange(library: Any, verb: str, section: Section, count: int) -> StringExchange | None:
    """Bind the getter or setter of strings to the first `count` columns of a section, if there are any."""
    if not count:
        return None
    return StringExchange(bind(library, f"{verb}String"), f"fmi2{verb}String", section, count)


def slope_exchange(library: Any, name: str, slopes: Slopes | None) -> SlopeExchange | None:
    """Bind the setter or getter of derivatives, if there are any."""
    if slopes is None:
        return None
    return SlopeExchange(
        bind(library, name),
        f"fmi2{name}",
        c_void_p(slopes.references.ctypes.data),
        c_size_t(slopes.references.size),
        c_void_p(slopes.orders.ctypes.data),
        slopes.values.ctypes.data,
        slopes.values.strides[0],
    )
