"""Run an FMI 2.0 co-simulation FMU as a slave.

Before and after stepping, calls go through fmpy. The three that every step needs do not: they are the bare functions of
the library, on addresses within the recording, because fmpy's wrappers build new arrays for each call, which costs more
than many an FMU takes for a step. States that a master may return to are kept by number.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from ctypes import byref, c_char, c_double, c_int, c_size_t, c_void_p
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from fmpy.fmi1 import FMICallException  # pyright: ignore[reportMissingTypeStubs]

from cosim.errors import RunError, SlaveError
from cosim.fmi2.library import Calls, Exchange, SlopeExchange, bound, exchange, loaded_fmu, slope_exchange
from cosim.fmi2.log import Journal
from cosim.recording.record import BASE_TYPES, Block, base_type
from cosim.system.description import Description, Variable
from cosim.system.signals import Value

_STATUS = ("fmi2OK", "fmi2Warning", "fmi2Discard", "fmi2Error", "fmi2Fatal", "fmi2Pending")
_WARNING, _DISCARD, _FATAL = 1, 2, 4
_TRANSIT = -1  # slot of a state on its way to or from bytes
_TERMINATED = 3  # fmi2StatusKind fmi2Terminated


class FmuSlave:
    """A loaded FMU; made by `open_fmu`, which takes care of its end.

    Parameters
    ----------
    name : str
        Name of the instance, in every message.
    description : Description
        Of the FMU.
    fmu : fmpy.fmi2.FMU2Slave
        Loaded, not instantiated.

    Raises
    ------
    RunError
        If the FMU cannot be instantiated.
    """

    def __init__(self, name: str, description: Description, fmu: Any) -> None:
        self.name = name
        self._description = description
        self._fmu = fmu
        self._journal = Journal(name)
        self._no_rollback = c_int(True)
        self._time = 0.0
        self._worst = 0
        self._started = False
        self._block: Block
        self._reads: tuple[Exchange, ...] = ()
        self._writes: tuple[Exchange, ...] = ()
        self._slopes: SlopeExchange | None = None
        self._output_slopes: SlopeExchange | None = None
        self._states: KeptStates | None = None
        self._times: dict[int, float] = {}
        self._asked: dict[Variable, Value] = {}
        self._instantiate()
        self._instance = c_void_p(fmu.component)
        self._do_step = bound(self._fmu.dll, "fmi2DoStep", (c_void_p, c_double, c_double, c_int))

    @property
    def description(self) -> Description:
        """Variables and capabilities."""
        return self._description

    def setup(self, block: Block, start_values: Mapping[Variable, Value], start_time: float, stop_time: float) -> None:
        """Set start values and bind the getters and setters to the recording; times in s.

        The experiment is set up first: FMI 2.0 (section 4.2.1) allows both orders, and there are exporters whose
        fmi2SetupExperiment puts back what was set before.
        """
        self._time = start_time
        self._block = block  # whose memory the calls use
        self._call(self._fmu.setupExperiment, None, start_time, stop_time)
        for variable, value in start_values.items():
            self._call(getattr(self._fmu, f"set{_getter(variable)}"), [variable.reference], [value])
        self._asked = {variable: value for variable, value in start_values.items() if variable.causality == "parameter"}
        library = self._fmu.dll
        self._reads = tuple(
            exchange(library, "Get", kind, section, len(section.variables))
            for kind, section in ((kind, block.outputs[kind]) for kind in BASE_TYPES)
            if section.variables
        )
        self._writes = tuple(
            exchange(library, "Set", kind, section, section.driven)
            for kind, section in ((kind, block.inputs[kind]) for kind in BASE_TYPES)
            if section.driven
        )
        self._slopes = slope_exchange(library, "fmi2SetRealInputDerivatives", block.slopes)
        self._output_slopes = slope_exchange(library, "fmi2GetRealOutputDerivatives", block.output_slopes)

    def enter_initialization(self) -> None:
        """Enter initialization mode; a driven input that declares no start value begins with what it is in the FMU."""
        self._call(self._fmu.enterInitializationMode)
        for section in self._block.inputs.values():
            for index, variable in enumerate(section.variables[: section.driven]):
                if variable.start is None:
                    section.values[0, index] = self._get(variable)

    def exit_initialization(self) -> None:
        """Exit initialization mode, and say which parameters are not what they were set to."""
        self._call(self._fmu.exitInitializationMode)
        self._started = True
        for variable, asked in self._asked.items():
            value = self._get(variable)
            if value != asked:
                self._journal.logger.warning(
                    "%s was set to %s, but the FMU has %s after initialisation", variable.name, asked, value
                )

    def write(self, row: int) -> None:
        """Set the driven inputs from a row of the block, and from row 1 on their derivatives."""
        for call in self._writes:
            status = call.function(self._instance, call.references, call.count, call.base + row * call.stride)
            if status:
                self._judge(call.name, status)
        if self._slopes is not None and row:
            self._exchange_slopes(self._slopes, row)

    def step(self, time: float, size: float) -> None:
        """Do one step from the communication point `time` [s] of the communication step size `size` [s]."""
        self._time = time
        status = self._do_step(self._instance, time, size, self._no_rollback)
        if status:
            self._judge("fmi2DoStep", status)
        self._time = time + size

    def read(self, row: int) -> None:
        """Get the outputs straight into a row of the block."""
        for call in self._reads:
            status = call.function(self._instance, call.references, call.count, call.base + row * call.stride)
            if status:
                self._judge(call.name, status)

        if self._output_slopes is not None and self._started:
            self._exchange_slopes(self._output_slopes, row)

    def calls(self) -> Calls:
        """Return what a step calls; once initialised."""
        return Calls(self._instance, self._do_step, self._writes, self._reads, self._slopes, self._output_slopes)

    def arrive(self, time: float) -> None:
        """Take note of the time [s] that others have stepped the FMU to."""
        self._time = time

    def failure(self, function: str, status: int) -> SlaveError:
        """Return the exception that tells why a call failed, its status being worse than a warning."""
        self._worst = max(self._worst, status)
        name = _STATUS[status] if 0 <= status < len(_STATUS) else f"the illegal status {status}"
        reason = self._journal.failure()
        if function == "fmi2DoStep" and status == _DISCARD and self._asks_to_end():
            reason = f"{reason}; the FMU asks to end the simulation".removeprefix("; ")
        return SlaveError(self.name, self._time, function, name, reason)

    def save(self, slot: int) -> None:
        """Keep the present state under a number; from then on the FMU is told that it may have to go back."""
        self._no_rollback = c_int(False)
        self._kept().save(slot)
        self._times[slot] = self._time

    def restore(self, slot: int) -> None:
        """Return to the state that was kept under a number, as if nothing had happened since."""
        self._kept().restore(slot)
        self._time = self._times[slot]
        self._journal.forget()

    def serialise(self) -> bytes:
        """Return the present state as bytes."""
        self._kept().save(_TRANSIT)
        return self._kept().to_bytes(_TRANSIT)

    def deserialise(self, content: bytes, time: float) -> None:
        """Go on from a state at the communication point `time` [s] that was written as bytes."""
        self._kept().from_bytes(_TRANSIT, content)
        self._kept().restore(_TRANSIT)
        self._time = time
        self._journal.forget()

    def terminate(self) -> None:
        """Terminate the run."""
        self._started = False
        self._call(self._fmu.terminate)

    def close(self) -> None:
        """Free the instance; after fmi2Fatal nothing may be called, after fmi2Error no terminate."""
        try:
            if self._started and self._worst <= _DISCARD:
                self.terminate()
        except SlaveError as error:
            self._journal.logger.warning("%s", error)
        finally:
            if self._worst != _FATAL:
                if self._states is not None:
                    self._states.free()
                self._fmu.fmi2FreeInstance(self._fmu.component)
            self._journal.close()

    def _kept(self) -> KeptStates:
        """Return the states that are kept, for the first one of which the functions are found."""
        if self._states is None:
            self._states = KeptStates(self._instance, partial(bound, self._fmu.dll), self._judge)
        return self._states

    def _instantiate(self) -> None:
        """Instantiate, with logging of all categories: some FMUs else keep to themselves why a call fails."""
        try:
            self._fmu.instantiate(callbacks=self._journal.callbacks, loggingOn=True)
        except Exception as error:  # fmpy raises bare Exception when it gets no instance
            reason = self._journal.failure()
            self._journal.close()
            raise RunError(f"{self.name}: fmi2Instantiate failed" + (f": {reason}" if reason else "")) from error

    def _get(self, variable: Variable) -> Value:
        """Return the present value of one variable."""
        kind = _getter(variable)
        (value,) = self._call(getattr(self._fmu, f"get{kind}"), [variable.reference])
        if isinstance(value, bytes):
            return value.decode("utf-8", "replace")
        return bool(value) if kind == "Boolean" else value

    def _exchange_slopes(self, call: SlopeExchange, row: int) -> None:
        """Set or get the derivatives in a row."""
        values = call.base + row * call.stride
        status = call.function(self._instance, call.references, call.count, call.orders, values)
        if status:
            self._judge(call.name, status)

    def _call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call an FMI function through fmpy; return what it returns."""
        try:
            return function(*arguments)
        except FMICallException as error:
            self._judge(error.function, error.status)

    def _judge(self, function: str, status: int) -> None:
        """Let a warning pass, and turn any other status into the exception that tells why."""
        if status != _WARNING:
            raise self.failure(function, status)

    def _asks_to_end(self) -> bool:
        """Tell whether a discarded step means that the FMU wants no more of them."""
        try:
            return bool(self._fmu.getBooleanStatus(_TERMINATED))
        except FMICallException:
            return False


def _getter(variable: Variable) -> str:
    """Return the type in the names of the functions that get and set a variable."""
    return "String" if variable.type == "String" else base_type(variable)


@contextmanager
def open_fmu(name: str, path: Path, description: Description) -> Generator[FmuSlave]:
    """Unpack, load and instantiate an FMU, and free, unload and remove it afterwards, whatever happens.

    Parameters
    ----------
    name : str
        Name for the instance.
    path : Path
        The .fmu file.
    description : Description
        What `cosim.fmi2.model_description.read_description` read from it.

    Raises
    ------
    FmuFileError
        If there is no binary for this platform or it cannot be loaded.
    RunError
        If the FMU cannot be instantiated.
    """
    with loaded_fmu(name, path, description) as fmu:
        slave = FmuSlave(name, description, fmu)
        try:
            yield slave
        finally:
            slave.close()


_GET, _SET, _FREE = "fmi2GetFMUstate", "fmi2SetFMUstate", "fmi2FreeFMUstate"
_SIZE, _WRITE, _READ = "fmi2SerializedFMUstateSize", "fmi2SerializeFMUstate", "fmi2DeSerializeFMUstate"


class Bind(Protocol):
    """Finds a function of the library by its name and the types of its arguments."""

    def __call__(self, name: str, argument_types: tuple[Any, ...]) -> Callable[..., int]:
        """Return the function."""
        ...


class KeptStates:
    """Keep the states that fmi2GetFMUstate returns.

    Parameters
    ----------
    instance : c_void_p
        The instance.
    bind : callable
        Finds the functions.
    judge : callable
        Takes the name of a function and a status other than fmi2OK, and raises unless it is a warning.
    """

    def __init__(self, instance: c_void_p, bind: Bind, judge: Callable[[str, int], None]) -> None:
        self._instance = instance
        self._bind, self._judge = bind, judge
        self._get, self._set, self._free = (bind(name, (c_void_p, c_void_p)) for name in (_GET, _SET, _FREE))
        self._states: dict[int, c_void_p] = {}

    def save(self, slot: int) -> None:
        """Keep the present state; one kept there before is freed first, as not every FMU overwrites it."""
        self._release(slot)
        state = self._states[slot] = c_void_p()
        if status := self._get(self._instance, byref(state)):
            self._judge(_GET, status)

    def restore(self, slot: int) -> None:
        """Return to a state."""
        if status := self._set(self._instance, self._states[slot]):
            self._judge(_SET, status)

    def to_bytes(self, slot: int) -> bytes:
        """Write a state as bytes (FMI 2.0, section 2.1.8)."""
        state, size = self._states[slot], c_size_t()
        ask = self._bind(_SIZE, (c_void_p, c_void_p, c_void_p))
        if status := ask(self._instance, state, byref(size)):
            self._judge(_SIZE, status)
        content = (c_char * size.value)()
        write = self._bind(_WRITE, (c_void_p, c_void_p, c_void_p, c_size_t))
        if status := write(self._instance, state, content, size):
            self._judge(_WRITE, status)
        return bytes(content)

    def from_bytes(self, slot: int, content: bytes) -> None:
        """Keep a state that was written as bytes, by this instance or another of the same FMU."""
        self._release(slot)
        state, buffer = c_void_p(), (c_char * len(content)).from_buffer_copy(content)
        read = self._bind(_READ, (c_void_p, c_void_p, c_size_t, c_void_p))
        if status := read(self._instance, buffer, c_size_t(len(content)), byref(state)):
            self._judge(_READ, status)
        self._states[slot] = state

    def free(self) -> None:
        """Free them all; nothing can be done about a failure any more."""
        for state in self._states.values():
            self._free(self._instance, byref(state))
        self._states.clear()

    def _release(self, slot: int) -> None:
        state = self._states.pop(slot, None)
        if state is not None:
            self._free(self._instance, byref(state))
