"""A co-simulation slave for pythonfmu that is made from an interface table.

Of all calls only do_step can tell the importer that something is wrong (see `calls`). So what a native FMU refuses
with a status at once, this slave logs, leaves everything as it was, and then refuses every step until the cause is
gone: until a fitting value has been set, or, after an illegal call, until a reset or a restored state.
"""
# pyright: reportMissingTypeStubs=false, reportUnknownMemberType=false

from __future__ import annotations

import sys
from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import partial
from math import isfinite
from typing import Any, ClassVar

from pythonfmu.enums import Fmi2Status
from pythonfmu.fmi2slave import Fmi2Slave

from ..schema import Kind, Model, Value
from . import calls, library, saved
from .calls import guarded
from .table import declaration
from .values import IllegalCall, Phase, Values


class TableSlave(Fmi2Slave):
    """Base of the slaves: a subclass names its table and fills in the hooks.

    Attributes
    ----------
    model : Model
        The interface table, a class attribute of the subclass.
    values : list
        One value per variable, by value reference; hooks write outputs here.
    at : dict of str to int
        Value references by name.
    time : float
        The communication point reached [s].
    """

    model: ClassVar[Model]

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        library.hold(kwargs.get("resources"), self.model.name)
        # the library has put this folder first on the path for good; nothing is imported from it any more
        sys.path[:] = [entry for entry in sys.path if entry != kwargs.get("resources")]
        self.name = str(kwargs["instance_name"])
        self.modelName = self.model.name
        self._values = Values(self.model)
        self.values = self._values.current
        self.at = {variable.name: reference for reference, variable in enumerate(self.model.variables)}
        self.time = 0.0
        self._phase = Phase.INSTANTIATED
        self._stale = True  # parameters or inputs have changed since the model was initialised
        self._tuned = False  # parameters have changed since the last step
        self._refusals: dict[str, str] = {}
        for reference, variable in enumerate(self.model.variables):
            getter = partial(self.values.__getitem__, reference)
            setter = partial(self.values.__setitem__, reference)
            self.register_variable(declaration(variable, getter, setter), nested=False)

    # Hooks of a model

    def check(self, values: Sequence[Any]) -> str | None:
        """Return what is wrong between several values as a sentence, None if nothing is."""
        return None

    @abstractmethod
    def start(self, values: list[Any], time: float) -> None:
        """Initialise at a time [s] from the parameters and inputs in `values`, and write the outputs there.

        Called again when one of them has changed before stepping begins. A ValueError or ArithmeticError with a
        sentence refuses the initialisation.
        """

    @abstractmethod
    def step(self, values: list[Any], time: float, end: float) -> None:
        """Advance from `time` to `end` [s], the inputs in `values` held, and write the outputs there.

        A ValueError or ArithmeticError with a sentence refuses the step; the state must then be as before it.
        """

    @abstractmethod
    def state(self) -> object:
        """Return all that steps depend on beside `values`: new lists, dicts by str, numbers, texts, None."""

    @abstractmethod
    def restore(self, state: Any) -> None:
        """Take over what `state` returned, without keeping or changing it: it may be restored again."""

    def below(self, values: Sequence[Any], name: str, least: str) -> str | None:
        """Return that a variable is below another, None if it is not."""
        value, bound = (values[self.model.value_reference(each)] for each in (name, least))
        return None if value >= bound else f"{name} is {value}; expected at least {least} = {bound}"

    # Messages

    def event(self, time: float, sentence: str) -> None:
        """Log something that happened in the model at a time [s]."""
        self._say(Fmi2Status.ok, "logEvents", sentence, time)

    def warning(self, time: float, sentence: str) -> None:
        """Log something that limits the worth of the results from a time [s] on."""
        self._say(Fmi2Status.warning, "logStatusWarning", sentence, time)

    def refuse(self, cause: str, sentence: str) -> None:
        """Log a sentence as fmi2Discard, and let no step pass until the cause is gone."""
        self._refusals[cause] = sentence
        self._say(Fmi2Status.discard, "logStatusDiscard", sentence)

    def failed(self, call: str, error: BaseException) -> None:
        """Log as fmi2Error what ended a call, and let no step pass until a reset or a restored state."""
        sentence = str(error) if isinstance(error, IllegalCall) else f"{call} failed: {error!r}"
        self._refusals["call"] = sentence
        self._say(Fmi2Status.error, "logStatusError", sentence)

    def _say(self, status: Fmi2Status, category: str, sentence: str, time: float | None = None) -> None:
        at = self.time if time is None else time
        # the importer's logger takes the message for a format string of printf
        self.log(f"{self.name} at t = {at!r} s: {sentence}".replace("%", "%%"), status, category)

    # Values

    def _get(self, kind: Kind, references: Sequence[int]) -> list[Any]:
        if self._stale and self._phase is Phase.INITIALIZATION:
            self._prepare()
        return self._values.read(kind, references)

    def _set(self, kind: Kind, references: Sequence[int], given: Sequence[Value]) -> None:
        misfits = self._values.misfits(kind, references, given, self._phase)
        for name, sentence in misfits.items():
            self.refuse(name, sentence)
        if misfits:
            return
        for reference, value in zip(references, given, strict=True):
            variable = self.model.variables[reference]
            self.values[reference] = value
            self._refusals.pop(variable.name, None)
            self._tuned = self._tuned or variable.causality == "parameter"
        self._stale = self._stale or self._phase is not Phase.STEPPING

    @guarded(calls.blank_reals)
    def get_real(self, vrs: list[int]) -> list[float]:
        """Return the values of Real variables."""
        return self._get("Real", vrs)

    @guarded(calls.blank_integers)
    def get_integer(self, vrs: list[int]) -> list[int]:
        """Return the values of Integer variables and enumerations."""
        return self._get("Integer", vrs)

    @guarded(calls.blank_booleans)
    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Return the values of Boolean variables."""
        return self._get("Boolean", vrs)

    @guarded(calls.blank_strings)
    def get_string(self, vrs: list[int]) -> list[str]:
        """Return the values of String variables."""
        return self._get("String", vrs)

    @guarded(calls.nothing)
    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Set all given Real variables, or none if one of the values does not fit."""
        self._set("Real", vrs, values)

    @guarded(calls.nothing)
    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """Set all given Integer variables and enumerations, or none if one of the values does not fit."""
        self._set("Integer", vrs, values)

    @guarded(calls.nothing)
    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Set all given Boolean variables, or none if one of the values does not fit."""
        self._set("Boolean", vrs, values)

    @guarded(calls.nothing)
    def set_string(self, vrs: list[int], values: list[str]) -> None:
        """Set all given String variables, or none if one of the values does not fit."""
        self._set("String", vrs, values)

    # Calling sequence

    @guarded(calls.nothing)
    def setup_experiment(self, start_time: float, stop_time: float | None, tolerance: float | None) -> None:
        """Take over the start time [s]."""
        self._require(Phase.INSTANTIATED, "setup_experiment")
        if not isfinite(start_time):
            raise IllegalCall(f"start time is {start_time!r} s; expected a finite value")
        self.time = start_time
        self._stale = True

    @guarded(calls.nothing)
    def enter_initialization_mode(self) -> None:
        """Begin to answer outputs for the parameters and inputs set so far."""
        self._require(Phase.INSTANTIATED, "enter_initialization_mode")
        self._phase = Phase.INITIALIZATION

    @guarded(calls.nothing)
    def exit_initialization_mode(self) -> None:
        """Initialise the model with the parameters and inputs as they are now."""
        self._require(Phase.INITIALIZATION, "exit_initialization_mode")
        self._prepare()
        self._tuned = False
        self._phase = Phase.STEPPING

    @guarded(calls.nothing)
    def terminate(self) -> None:
        """Allow no more steps; outputs can still be read."""
        self._require(Phase.STEPPING, "terminate")
        self._phase = Phase.TERMINATED

    def _require(self, phase: Phase, call: str) -> None:
        if self._phase is not phase:
            raise IllegalCall(f"{call} while {self._phase}; expected it while {phase}")

    def _prepare(self) -> None:
        if not self._stale:
            return
        self._refusals.pop("start", None)
        problem = _objection(lambda: self.check(self.values)) or _objection(lambda: self.start(self.values, self.time))
        self._stale = problem is not None
        if problem is not None:
            self._values.invalidate()
            self.refuse("start", problem)

    @guarded(calls.refused)
    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance the model; False, with everything as it was, if the step cannot be taken."""
        before = self.values[:]
        problem = self._obstacle(current_time, step_size)
        problem = problem or _objection(lambda: self.step(self.values, self.time, current_time + step_size))
        if problem is not None:
            self.values[:] = before
            self._say(Fmi2Status.discard, "logStatusDiscard", problem)
            return False
        self.time = current_time + step_size
        self._tuned = False
        return True

    def _obstacle(self, current_time: float, step_size: float) -> str | None:
        self._require(Phase.STEPPING, "do_step")
        if self._refusals:
            return next(iter(self._refusals.values()))
        if not (isfinite(step_size) and step_size > 0.0):
            return f"step size is {step_size!r} s; expected a finite value > 0"
        slack = 1e-9 * max(1.0, abs(self.time)) + 1e-6 * step_size
        if not abs(current_time - self.time) <= slack:
            return f"communication point is {current_time!r} s; expected {self.time!r} s"
        if not current_time + step_size > self.time:
            return f"step size is {step_size!r} s; too small to be told from rounding"
        return _objection(lambda: self.check(self.values)) if self._tuned else None

    # Saved states: pythonfmu's own would keep the registered variables only

    @guarded(calls.saved_nothing)
    def _get_fmu_state(self) -> dict[str, Any]:
        return {
            "model": self.model.name,
            "phase": self._phase.value,
            "time": self.time,
            "values": self.values[:],
            "stale": self._stale,
            "tuned": self._tuned,
            "refusals": dict(self._refusals),
            "state": None if self._stale else self.state(),
        }

    @guarded(calls.nothing)
    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        if state.get("model") != self.model.name or len(state["values"]) != len(self.values):
            raise IllegalCall(f"the state to restore is not one of {self.model.name}")
        if not state["stale"]:
            self.restore(state["state"])
        self._phase, self.time = Phase(state["phase"]), state["time"]
        self.values[:] = state["values"]
        self._stale, self._tuned = state["stale"], state["tuned"]
        self._refusals = dict(state["refusals"])

    @staticmethod
    def _fmu_state_to_bytes(state: dict[str, Any]) -> bytes:
        return saved.encoded(state)

    @staticmethod
    def _fmu_state_from_bytes(state: bytes) -> dict[str, Any]:
        return saved.decoded(state)


def _objection(call: Callable[[], str | None]) -> str | None:
    """Return what a hook objects to, whether it says or raises it; any other exception is a failure of its own."""
    try:
        return call()
    except (ValueError, ArithmeticError) as error:
        return str(error) or repr(error)
