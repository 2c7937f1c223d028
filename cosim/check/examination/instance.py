"""Call an FMU through the bare functions of FMI 2.0, so that every status can be seen and every rule tried.

`cosim.fmi2.fmu_slave` is for runs that should succeed; this is for finding out what an FMU does. Many variables are got
or set at once, on memory laid out beforehand. The last function called is known even after a crash.
"""

from __future__ import annotations

import mmap
from collections.abc import Callable, Mapping, Sequence
from ctypes import byref, c_double, c_int, c_size_t, c_uint, c_void_p, create_string_buffer
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple

from cosim.errors import format_time
from cosim.fmi2.functions import (
    ACCEPTED,
    CALLS,
    CO_SIMULATION,
    DISCARD,
    ELEMENTS,
    ERROR,
    FATAL,
    asks_to_end,
    bind,
    get_one,
    set_one,
    status_name,
)
from cosim.fmi2.log import Journal
from cosim.recording.record import BASE_TYPES, base_type
from cosim.system.description import Description, Variable
from cosim.system.signals import Value


class CallTrace:
    """The name of the last function called, in a file that survives a crash of this process.

    Parameters
    ----------
    path : Path
        The file; it is made.
    """

    _LENGTH = 64

    def __init__(self, path: Path) -> None:
        path.write_bytes(bytes(self._LENGTH))
        with path.open("r+b") as file:
            self._memory = mmap.mmap(file.fileno(), self._LENGTH)

    def mark(self, name: bytes) -> None:
        """Note a function, its name padded by `padded`."""
        self._memory[:] = name

    @classmethod
    def padded(cls, name: str) -> bytes:
        """Return a name as `mark` takes it."""
        return name.encode()[: cls._LENGTH].ljust(cls._LENGTH, b"\0")

    @staticmethod
    def read(path: Path) -> str:
        """Return the function noted last; empty if there is none."""
        return path.read_bytes().rstrip(b"\0").decode() if path.is_file() else ""


class Library:
    """The functions of a loaded FMU.

    Parameters
    ----------
    loaded : fmpy.fmi2.FMU2Slave
        From `cosim.fmi2.library.loaded_fmu`.
    description : Description
        Of the FMU.
    trace : CallTrace
        Told of every call.
    """

    def __init__(self, loaded: Any, description: Description, trace: CallTrace) -> None:
        self.description = description
        self.folder = str(loaded.unzipDirectory)
        self._library = loaded.dll
        self._trace = trace
        self.functions = {name: self._traced(name) for name in CALLS}
        self.instantiate = self._traced("Instantiate")
        self.free = self._traced("FreeInstance")
        self.version = self._traced("GetVersion")
        self.types_platform = self._traced("GetTypesPlatform")

    def _traced(self, name: str) -> Callable[..., Any]:
        """Return a function of the library that notes its name before each call."""
        function = bind(self._library, name)
        label, mark = CallTrace.padded(f"fmi2{name}"), self._trace.mark

        def traced(*arguments: Any) -> Any:
            mark(label)
            return function(*arguments)

        return traced


class CallError(Exception):
    """A call that had to succeed and did not; its text is what a table says of it."""

    def __init__(self, function: str, status: int, time: float, reason: str) -> None:
        self.function = function
        self.status = status
        sentence = f"fmi2{function} returned {status_name(status)} at t = {format_time(time)} s"
        super().__init__(f"{sentence}: {reason}" if reason else sentence)


class Message(NamedTuple):
    """Hold a message that an FMU gave its logger."""

    status: int
    category: str
    text: str


class _Listener(Journal):
    """A journal that keeps every message."""

    def __init__(self, instance: str) -> None:
        super().__init__(instance)
        self.messages: list[Message] = []

    def take(self, status: int, category: str, message: str) -> None:
        """Keep one message."""
        self.messages.append(Message(status, category, message))
        super().take(status, category, message)


class Instance:
    """One instance, freed at the end of a with statement.

    Parameters
    ----------
    library : Library
        The FMU.
    name : str
        Its name.
    guid : str, optional
        Other than that of the FMU.
    logging : bool
        Whether debug logging is on from the start.

    Attributes
    ----------
    component : int or None
        None if the FMU refused to be instantiated.
    time : float
        Communication point reached, for messages [s].
    """

    def __init__(
        self, library: Library, name: str = "checked", *, guid: str | None = None, logging: bool = False
    ) -> None:
        self._library = library
        self._listener = _Listener(name)
        self.time = 0.0
        self._fatal = False
        description = library.description
        resources = Path(library.folder, "resources").as_uri().encode()
        identity = (description.guid if guid is None else guid).encode()
        callbacks = byref(self._listener.callbacks)
        self.component: int | None = library.instantiate(
            name.encode(), CO_SIMULATION, identity, resources, callbacks, 0, int(logging)
        )

    @property
    def messages(self) -> list[Message]:
        """Return the messages that the FMU has logged."""
        return self._listener.messages

    @property
    def reason(self) -> str:
        """Return the FMU's messages about its failures, in one line."""
        return self._listener.failure()

    def call(self, function: str, *arguments: Any) -> int:
        """Call fmi2<function> and return its status."""
        status: int = self._library.functions[function](self.component, *arguments)
        self._fatal = self._fatal or status == FATAL
        return status

    def must(self, function: str, *arguments: Any) -> None:
        """Call fmi2<function>; CallError unless it returns fmi2OK or fmi2Warning."""
        self.judge(function, self.call(function, *arguments))

    def judge(self, function: str, status: int) -> None:
        """Raise CallError unless a status is fmi2OK or fmi2Warning."""
        if status not in ACCEPTED:
            raise CallError(function, status, self.time, self.reason)

    def set_up(self, start: float) -> None:
        """Set up the experiment from a time [s] on, with the tolerance of the FMU's default experiment, as in a run."""
        tolerance = self._library.description.tolerance
        self.must("SetupExperiment", int(tolerance is not None), tolerance or 0.0, start, 0, 0.0)

    def initialise(self, start: float = 0.0, prepare: Callable[[], None] | None = None) -> None:
        """Go from instantiated to the first communication point [s]; CallError if that fails.

        `prepare` sets values once the experiment is set up: there are FMUs that put back then what was set before.
        """
        if self.component is None:
            raise CallError("Instantiate", ERROR, start, self.reason or "no instance was returned")
        self.time = start
        self.set_up(start)
        if prepare is not None:
            prepare()
        self.must("EnterInitializationMode")
        self.must("ExitInitializationMode")

    def step(self, time: float, size: float) -> None:
        """Do a step from a communication point [s]; CallError if that fails."""
        self.time = time
        self.must("DoStep", time, size, 0)
        self.time = time + size

    def wants_to_end(self, error: CallError) -> bool:
        """Return whether a step was discarded because the FMU asks for the simulation to end (FMI 2.0.4, 4.2.2)."""
        return (
            error.function == "DoStep" and error.status == DISCARD and asks_to_end(self.call, self._library.description)
        )

    def get(self, variable: Variable) -> Value:
        """Return the value of one variable; CallError if that fails, ValueError for a null pointer as a String."""
        value: Value | None = get_one(self.must, base_type(variable), variable.reference)
        if value is None:
            raise ValueError(f"{variable.name}: fmi2GetString gave a null pointer")
        return value

    def set(self, variable: Variable, value: Value) -> int:
        """Set one variable and return the status."""
        return set_one(self.call, base_type(variable), variable.reference, value)

    def must_set(self, variable: Variable, value: Value) -> None:
        """Set one variable; CallError if that fails."""
        self.judge(f"Set{base_type(variable)}", self.set(variable, value))

    def set_slopes(self, slopes: Mapping[Variable, float]) -> int:
        """Set first derivatives of inputs for the next step and return the status."""
        count = len(slopes)
        orders, values = (c_int * count)(*[1] * count), (c_double * count)(*slopes.values())
        return self.call("SetRealInputDerivatives", references(list(slopes)), count, orders, values)

    def output_derivatives(self, variables: Sequence[Variable], order: int = 1) -> tuple[int, list[float]]:
        """Return the status and the derivatives of outputs."""
        count = len(variables)
        orders, values = (c_int * count)(*[order] * count), (c_double * count)()
        status = self.call("GetRealOutputDerivatives", references(variables), count, orders, values)
        return status, list(values)

    def directional_derivative(self, unknown: Variable, known: Variable) -> tuple[int, float]:
        """Return the status and the partial derivative of one variable by another."""
        seed, value = c_double(1.0), c_double()
        arguments = references([unknown]), 1, references([known]), 1, byref(seed), byref(value)
        return self.call("GetDirectionalDerivative", *arguments), value.value

    def save(self) -> c_void_p:
        """Return a copy of the state; CallError if that fails."""
        state = c_void_p()
        self.must("GetFMUstate", byref(state))
        return state

    def restore(self, state: c_void_p) -> None:
        """Go back to a state; CallError if that fails."""
        self.must("SetFMUstate", state)

    def discard(self, state: c_void_p) -> None:
        """Free a state; CallError if that fails or leaves its pointer."""
        self.must("FreeFMUstate", byref(state))

    def serialise(self, state: c_void_p) -> bytes:
        """Return a state as bytes; CallError if that fails."""
        size = c_size_t()
        self.must("SerializedFMUstateSize", state, byref(size))
        content = create_string_buffer(size.value)
        self.must("SerializeFMUstate", state, content, size)
        return content.raw

    def deserialise(self, content: bytes) -> tuple[int, c_void_p]:
        """Return the status, and the state made from bytes."""
        state = c_void_p()
        buffer = create_string_buffer(content, len(content))
        return self.call("DeSerializeFMUstate", buffer, len(content), byref(state)), state

    def free(self) -> None:
        """Free the instance; after fmi2Fatal nothing may be called any more."""
        if self.component is not None and not self._fatal:
            self._library.free(self.component)
        self.component = None
        self._listener.close()

    def __enter__(self) -> Instance:
        """Return the instance itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Free it."""
        self.free()


def references(variables: Sequence[Variable]) -> Any:
    """Return an array of value references."""
    return (c_uint * len(variables))(*(variable.reference for variable in variables))


class VariableExchange:
    """Variables of one base type, got or set together on memory laid out once.

    Parameters
    ----------
    kind : str
        One of `BASE_TYPES`.
    variables : sequence of Variable
        All of that type.
    """

    def __init__(self, kind: str, variables: Sequence[Variable]) -> None:
        self.kind = kind
        self.variables = tuple(variables)
        self._references = references(self.variables)
        self._values: Any = (ELEMENTS[kind] * len(self.variables))()

    def get(self, instance: Instance) -> list[Any]:
        """Return the values; CallError if that fails."""
        instance.must(f"Get{self.kind}", self._references, len(self.variables), self._values)
        return list(self._values)

    def set(self, instance: Instance, values: Sequence[Any]) -> None:
        """Set the values; CallError if that fails."""
        self._values[:] = values
        instance.must(f"Set{self.kind}", self._references, len(self.variables), self._values)


def exchanges(variables: Sequence[Variable]) -> tuple[VariableExchange, ...]:
    """Return variables grouped by base type, those without any left out."""
    groups = {kind: [v for v in variables if base_type(v) == kind] for kind in BASE_TYPES}
    return tuple(VariableExchange(kind, group) for kind, group in groups.items() if group)
