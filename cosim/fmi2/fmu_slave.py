"""Run an FMI 2.0 co-simulation FMU as a slave.

Every step's calls are bound to addresses within the recording, which are good for as long as the block is kept. States
that a master may return to are kept by number.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping
from contextlib import ExitStack, contextmanager
from ctypes import byref, c_char, c_double, c_int, c_size_t, c_void_p
from functools import cache, partial
from pathlib import Path
from typing import Any

from cosim.errors import EndRequestError, RunError, SlaveError
from cosim.fmi2.functions import (
    ACCEPTED,
    CO_SIMULATION,
    DISCARD,
    FATAL,
    LAST_SUCCESSFUL_TIME,
    WARNING,
    SectionExchange,
    SlopeExchange,
    StepCalls,
    StringExchange,
    asks_to_end,
    bind,
    exchange,
    get_one,
    set_one,
    slope_exchange,
    status_name,
    string_exchange,
)
from cosim.fmi2.library import loaded_fmu
from cosim.fmi2.log import Journal
from cosim.fmi2.surroundings import Surroundings
from cosim.recording.record import BASE_TYPES, BaseType, Block, base_type
from cosim.system.description import Description, Variable
from cosim.system.signals import Value

_NUMBERS: tuple[BaseType, ...] = tuple(kind for kind in BASE_TYPES if kind != "String")
_TRANSIT = -1  # slot of a state on its way to or from bytes


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

    Attributes
    ----------
    not_kept : dict of str to value
        What the FMU has, once initialised, for parameters that are not what they were set to.

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
        self._bound = cache(partial(bind, fmu.dll))
        self._block: Block | None = None
        self._reads: tuple[SectionExchange, ...] = ()
        self._writes: tuple[SectionExchange, ...] = ()
        self._text_reads: StringExchange | None = None
        self._text_writes: StringExchange | None = None
        self._slopes: SlopeExchange | None = None
        self._output_slopes: SlopeExchange | None = None
        self._states: KeptStates | None = None
        self._times: dict[int, float] = {}
        self._asked: dict[Variable, Value] = {}
        self.not_kept: dict[str, Value] = {}
        self._instance = c_void_p(self._instantiate())
        self._do_step = self._bound("DoStep")

    @property
    def description(self) -> Description:
        """Variables and capabilities."""
        return self._description

    def setup(self, block: Block, start_values: Mapping[Variable, Value], start_time: float, stop_time: float) -> None:
        """Set start values and bind the getters and setters to the recording; times in s.

        The experiment is set up first: FMI 2.0 (section 4.2.1) allows both orders, and there are exporters whose
        fmi2SetupExperiment puts back what was set before. It is told the tolerance of its default experiment, which is
        what its makers have tried; without one, solvers take what they please.
        """
        self._time = start_time
        tolerance = self._description.tolerance
        self._must("SetupExperiment", tolerance is not None, tolerance or 0.0, start_time, True, stop_time)
        for variable, value in start_values.items():
            set_one(self._must, base_type(variable), variable.reference, value)
        self._asked = {variable: value for variable, value in start_values.items() if variable.causality == "parameter"}
        if block is not self._block:
            self._bind(block)

    def _bind(self, block: Block) -> None:
        """Bind the getters and setters to the recording, whose memory they use."""
        self._block = block
        library = self._fmu.dll
        self._reads = tuple(
            exchange(library, "Get", kind, section, len(section.variables))
            for kind, section in ((kind, block.outputs[kind]) for kind in _NUMBERS)
            if section.variables
        )
        self._writes = tuple(
            exchange(library, "Set", kind, section, section.driven)
            for kind, section in ((kind, block.inputs[kind]) for kind in _NUMBERS)
            if section.driven
        )
        texts, driven = block.outputs["String"], block.inputs["String"]
        self._text_reads = string_exchange(library, "Get", texts, len(texts.variables))
        self._text_writes = string_exchange(library, "Set", driven, driven.driven)
        self._slopes = slope_exchange(library, "SetRealInputDerivatives", block.slopes)
        self._output_slopes = slope_exchange(library, "GetRealOutputDerivatives", block.output_slopes)

    def enter_initialization(self) -> None:
        """Enter initialization mode; a driven input that declares no start value begins with what it is in the FMU."""
        assert self._block is not None
        self._must("EnterInitializationMode")
        for section in self._block.inputs.values():
            for index, variable in enumerate(section.variables[: section.driven]):
                if variable.start is None:
                    section.values[0, index] = self._get(variable)

    def exit_initialization(self) -> None:
        """Exit initialization mode, and say which parameters are not what they were set to."""
        self._must("ExitInitializationMode")
        self._started = True
        for variable, asked in self._asked.items():
            value = self._get(variable)
            if value != asked:
                self.not_kept[variable.name] = value
                self._journal.logger.warning(
                    "%s was set to %s, but the FMU has %s after initialisation", variable.name, asked, value
                )

    def write(self, row: int) -> None:
        """Set the driven inputs from a row of the block, and from row 1 on their derivatives."""
        for call in self._writes:
            status = call.function(self._instance, call.references, call.count, call.base + row * call.stride)
            if status:
                self._judge(call.name, status)
        if self._text_writes is not None and (status := self._text_writes.set(self._instance, row)):
            self._judge(self._text_writes.name, status)
        if self._slopes is not None and row:
            self._exchange_slopes(self._slopes, row)

    def step(self, time: float, size: float) -> None:
        """Do one step from the communication point `time` [s] of the communication step size `size` [s]."""
        self._time = time
        status = self._do_step(self._instance, time, size, self._no_rollback)
        if status and status != WARNING:
            raise self.failure("fmi2DoStep", status, size)
        self._time = time + size

    def read(self, row: int) -> None:
        """Get the outputs straight into a row of the block."""
        for call in self._reads:
            status = call.function(self._instance, call.references, call.count, call.base + row * call.stride)
            if status:
                self._judge(call.name, status)
        if self._text_reads is not None and (status := self._text_reads.get(self._instance, row)):
            self._judge(self._text_reads.name, status)
        if self._output_slopes is not None and self._started:
            self._exchange_slopes(self._output_slopes, row)

    def calls(self) -> StepCalls:
        """Return what a step calls but for strings; once initialised."""
        return StepCalls(self._instance, self._do_step, self._writes, self._reads, self._slopes, self._output_slopes)

    def arrive(self, time: float) -> None:
        """Take note of the time [s] that others have stepped the FMU to."""
        self._time = time

    def failure(self, function: str, status: int, size: float = 0.0) -> SlaveError:
        """Return the exception that tells why a call failed, its status being worse than a warning.

        Of a step its size [s] is given, which bounds the time at which an FMU can say that it has ended.
        """
        self._worst = max(self._worst, status)
        reason = self._journal.failure()
        if function == "fmi2DoStep" and status == DISCARD and asks_to_end(self._call, self._description):
            return EndRequestError(self.name, self._time, reason, self._last_successful_time(size))
        return SlaveError(self.name, self._time, function, status_name(status), reason)

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

    @property
    def is_sound(self) -> bool:
        """Tell whether no call has failed, so that the instance can serve once more."""
        return self._worst <= WARNING

    def reset(self) -> None:
        """Be as after instantiation, for another run; what was kept of this one is dropped."""
        if self._states is not None:
            self._states.free()
        self._must("Reset")
        self._started = False
        self._no_rollback = c_int(True)
        self._times.clear()
        self.not_kept = {}
        self._journal.forget()

    def terminate(self) -> None:
        """Terminate the run."""
        self._started = False
        self._must("Terminate")

    def close(self) -> None:
        """Free the instance; after fmi2Fatal nothing may be called, after fmi2Error no terminate."""
        try:
            if self._started and self._worst <= DISCARD:
                self.terminate()
        except SlaveError as error:
            self._journal.logger.warning("%s", error)
        finally:
            if self._worst != FATAL:
                if self._states is not None:
                    self._states.free()
                self._bound("FreeInstance")(self._instance)
            self._journal.close()

    def _kept(self) -> KeptStates:
        """Return the states that are kept, for the first one of which the functions are found."""
        if self._states is None:
            self._states = KeptStates(self._instance, self._fmu.dll, self._judge)
        return self._states

    def _instantiate(self) -> int:
        """Instantiate, with logging of all categories: some FMUs else keep to themselves why a call fails."""
        instance = self._bound("Instantiate")(
            self.name.encode(),
            CO_SIMULATION,
            self._description.guid.encode(),
            Path(self._fmu.unzipDirectory, "resources").as_uri().encode(),
            byref(self._journal.callbacks),
            False,
            True,
        )
        if instance is None:
            reason = self._journal.failure()
            self._journal.close()
            raise RunError(f"{self.name}: fmi2Instantiate failed" + (f": {reason}" if reason else ""))
        return instance

    def _get(self, variable: Variable) -> Value:
        """Return the present value of one variable."""
        value: Value | None = get_one(self._must, base_type(variable), variable.reference)
        return "" if value is None else value

    def _exchange_slopes(self, call: SlopeExchange, row: int) -> None:
        """Set or get the derivatives in a row."""
        values = call.base + row * call.stride
        status = call.function(self._instance, call.references, call.count, call.orders, values)
        if status:
            self._judge(call.name, status)

    def _call(self, function: str, *arguments: Any) -> int:
        """Call fmi2<function> and return its status."""
        return self._bound(function)(self._instance, *arguments)

    def _must(self, function: str, *arguments: Any) -> int:
        """Call fmi2<function>; SlaveError unless it returns fmi2OK or fmi2Warning."""
        status = self._call(function, *arguments)
        if status:
            self._judge(f"fmi2{function}", status)
        return status

    def _judge(self, function: str, status: int) -> None:
        """Let a warning pass, and turn any other status into the exception that tells why."""
        if status != WARNING:
            raise self.failure(function, status)

    def _last_successful_time(self, size: float) -> float:
        """Return when the FMU ended within a step that it discarded (FMI 2.0.4, section 4.2.2), s.

        One that does not tell, or tells a time outside the step, is taken to have ended where the step began. Many
        keep a time of their own, which is off by rounding.
        """
        told = c_double(math.nan)
        if self._call("GetRealStatus", LAST_SUCCESSFUL_TIME, byref(told)) not in ACCEPTED:
            return self._time
        end = min(max(told.value, self._time), self._time + size)
        return end if abs(told.value - end) <= 1e-6 * size else self._time


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
    surroundings = Surroundings(name)
    with ExitStack() as stack:
        with surroundings.kept("while it was loaded and instantiated"):
            slave = FmuSlave(name, description, stack.enter_context(loaded_fmu(name, path, description)))
        stack.callback(slave.close)
        try:
            yield slave
        finally:
            with surroundings.kept("while it was freed and unloaded"):
                stack.close()


class KeptStates:
    """Keep the states that fmi2GetFMUstate returns.

    Parameters
    ----------
    instance : c_void_p
        The instance.
    library : ctypes.CDLL
        Of the FMU.
    judge : callable
        Takes the name of a function and a status other than fmi2OK, and raises unless it is a warning.
    """

    def __init__(self, instance: c_void_p, library: Any, judge: Callable[[str, int], None]) -> None:
        self._instance = instance
        self._library, self._judge = library, judge
        self._get, self._set, self._free = (bind(library, f"{verb}FMUstate") for verb in ("Get", "Set", "Free"))
        self._states: dict[int, c_void_p] = {}

    def save(self, slot: int) -> None:
        """Keep the present state; one kept there before is freed first, as not every FMU overwrites it."""
        self._release(slot)
        state = self._states[slot] = c_void_p()
        if status := self._get(self._instance, byref(state)):
            self._judge("fmi2GetFMUstate", status)

    def restore(self, slot: int) -> None:
        """Return to a state."""
        if status := self._set(self._instance, self._states[slot]):
            self._judge("fmi2SetFMUstate", status)

    def to_bytes(self, slot: int) -> bytes:
        """Write a state as bytes (FMI 2.0, section 2.1.8)."""
        state, size = self._states[slot], c_size_t()
        self._must("SerializedFMUstateSize", state, byref(size))
        content = (c_char * size.value)()
        self._must("SerializeFMUstate", state, content, size)
        return bytes(content)

    def from_bytes(self, slot: int, content: bytes) -> None:
        """Keep a state that was written as bytes, by this instance or another of the same FMU."""
        self._release(slot)
        state, buffer = c_void_p(), (c_char * len(content)).from_buffer_copy(content)
        self._must("DeSerializeFMUstate", buffer, len(content), byref(state))
        self._states[slot] = state

    def free(self) -> None:
        """Free them all; nothing can be done about a failure any more."""
        for state in self._states.values():
            self._free(self._instance, byref(state))
        self._states.clear()

    def _must(self, function: str, *arguments: Any) -> None:
        """Call fmi2<function>, and judge any status but fmi2OK."""
        if status := bind(self._library, function)(self._instance, *arguments):
            self._judge(f"fmi2{function}", status)

    def _release(self, slot: int) -> None:
        state = self._states.pop(slot, None)
        if state is not None:
            self._free(self._instance, byref(state))
