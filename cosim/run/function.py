"""Let a Python function take part in a run as a component: its parameters are inputs, what it returns are outputs.

A function has no memory by contract: what it returns follows from what it is given, so that a step may be repeated. In
runs that go forward only, one that remembers nevertheless (a closure, an attribute) is called once for each step; in
those that repeat steps it is refused where equal arguments give other outputs: the first call of each step is made
twice to see.
"""

from __future__ import annotations

import hashlib
import inspect
import math
import reprlib
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, cast

from cosim.errors import FunctionError, SystemDefinitionError, suggestion
from cosim.recording.record import BASE_TYPES, TEXT, Block, Section
from cosim.system.description import Description, Variable, VariableType
from cosim.system.signals import Signal, Value, plain_value
from cosim.system.structure import Component, Connection, Function, Port, System

TIME = "time"
"""The parameter that receives the communication point."""

_NAMED = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
_SIMPLE = bool | int | float | str
"""What a default or a value of a parameter can be to be told in a record."""


@dataclass(frozen=True)
class Callee:
    """A function, and what can be told of it without calling it."""

    function: Function

    @cached_property
    def name(self) -> str:
        """The name by which messages call it."""
        bare = _bare(self.function)
        return str(getattr(bare, "__name__", type(bare).__name__))

    @cached_property
    def parameters(self) -> Mapping[str, inspect.Parameter]:
        """Its parameters by name, without `time` and those that stand for any number of others."""
        return {name: each for name, each in self._all.items() if each.kind in _NAMED and name != TIME}

    @cached_property
    def takes_time(self) -> bool:
        """Tell whether it wants to know the time."""
        return TIME in self._all and self._all[TIME].kind in _NAMED

    def takes(self, name: str) -> bool:
        """Tell whether it can be given a value by a name."""
        anything = any(each.kind is inspect.Parameter.VAR_KEYWORD for each in self._all.values())
        return name in self.parameters or (anything and name != TIME)

    @cached_property
    def positional(self) -> tuple[str, ...]:
        """Names of the parameters that cannot be given by name, in their order."""
        return tuple(name for name, each in self._all.items() if each.kind is inspect.Parameter.POSITIONAL_ONLY)

    def record(self) -> dict[str, Any]:
        """Return its name, where it is from, and the hash of its source, as far as they can be told."""
        bare = _bare(self.function)
        named = bare if hasattr(bare, "__qualname__") else cast(Any, type(bare))
        code = getattr(bare, "__code__", None) or getattr(type(bare).__call__, "__code__", None)
        try:
            source = hashlib.sha256(inspect.getsource(code).encode()).hexdigest() if code is not None else None
        except (OSError, TypeError):  # typed in, or made by a program
            source = None
        return {
            "model": self.name,
            "python_function": f"{named.__module__}.{named.__qualname__}",
            "file": f"{code.co_filename}:{code.co_firstlineno}" if code is not None else None,
            "sha256": source,
        }

    @cached_property
    def _all(self) -> Mapping[str, inspect.Parameter]:
        try:
            return inspect.signature(self.function).parameters
        except (TypeError, ValueError) as error:
            raise SystemDefinitionError(
                f"{self.name} does not tell its parameters; expected a function written in Python around it"
            ) from error


def _bare(function: Function) -> Any:
    """Return what was written, without decorators and arguments that were bound to it."""
    while isinstance(function, partial):
        function = cast(Function, function.func)
    return inspect.unwrap(function)


def functions_of(system: System) -> dict[str, Callee]:
    """Return the components of a system that are functions, by name."""
    return {part.name: Callee(part.fmu) for part in system.components if callable(part.fmu)}


def with_functions(system: System, functions: Mapping[str, Function], connections: Collection[Connection]) -> System:
    """Return a system with functions as components, and with more connections.

    A function takes the place of the component of its name with all that leads there; connections, signals and
    parameters that it has no parameter for are left out. A connection replaces what else drives its target.

    Raises
    ------
    SystemDefinitionError
        If a function is neither a component nor named by a connection, or a connection names no component.
    """
    callees = {name: Callee(function) for name, function in functions.items()}
    names = [part.name for part in system.components]
    ends = {port.component for each in connections for port in (each.source, each.target)}
    for name in callees:
        if name not in names and name not in ends:
            raise SystemDefinitionError(
                f"there is no component '{name}' to be a function, and no connection to a new one"
                f"{suggestion(name, names)}"
            )

    def fits(port: Port) -> bool:
        return port.component not in callees or callees[port.component].takes(port.variable)

    taken = {connection.target for connection in connections}
    kept = [each for each in system.connections if fits(each.target) and each.target not in taken]
    sources = {each.source for each in (*kept, *connections)}
    bonds = system.power_bonds
    return System(
        components=(
            *(_replaced(part, callees) for part in system.components),
            *(Component(name, callee.function) for name, callee in callees.items() if name not in names),
        ),
        connections=(*kept, *connections),
        inputs={port: signal for port, signal in system.inputs.items() if fits(port) and port not in taken},
        guards=system.guards and tuple(port for port in system.guards if port.component not in callees),
        power_bonds=bonds
        and tuple(each for each in bonds if each.input.component not in callees or each.output in sources),
    )


def _replaced(part: Component, callees: Mapping[str, Callee]) -> Component:
    """Return a component, or the function in its place, with the parameters that the function takes."""
    if part.name not in callees:
        return part
    callee = callees[part.name]
    given = {name: value for name, value in part.parameters.items() if callee.takes(name)}
    return Component(part.name, callee.function, given)


def describe_functions(system: System, known: Mapping[str, Description]) -> dict[str, Description]:
    """Describe the functions of a system by what they are connected to.

    Parameters
    ----------
    system : System
        What is coupled with what.
    known : mapping of str to Description
        Of the components that are FMUs.

    Raises
    ------
    SystemDefinitionError
        If nothing feeds a parameter that has no default.
    """
    callees = functions_of(system)
    outputs: dict[Port, Variable] = {}
    for connection in (each for each in system.connections if each.source.component in callees):
        peer = _known(connection.target, known)
        if peer is not None or connection.source not in outputs:
            outputs.setdefault(connection.source, _like(peer, connection.source.variable, "output"))
    peers = {connection.target: connection.source for connection in system.connections}
    found: dict[str, Description] = {}
    for part in (part for part in system.components if part.name in callees):
        callee = callees[part.name]
        driven: dict[str, Variable] = {}
        for target, source in ((target, source) for target, source in peers.items() if target.component == part.name):
            driven[target.variable] = _like(outputs.get(source) or _known(source, known), target.variable, "input")
        for port, signal in system.inputs.items():
            if port.component == part.name:
                driven[port.variable] = Variable(port.variable, 0, _type_of(signal), "input")
        _refuse_unfed(part, callee, driven, known)
        inputs = [_started(variable, callee) for variable in driven.values() if callee.takes(variable.name)]
        gives = [variable for port, variable in outputs.items() if port.component == part.name]
        numbered = enumerate([*inputs, *_parameters(part, callee, driven), *gives])
        variables = tuple(replace(variable, reference=number) for number, variable in numbered)
        found[part.name] = Description(
            callee.name, callee.name, "", variables, can_save_state=True, can_serialize_state=True
        )
    return found


def _known(port: Port, known: Mapping[str, Description]) -> Variable | None:
    """Return a variable of an FMU, if there is such an FMU and variable."""
    return known[port.component].by_name.get(port.variable) if port.component in known else None


def _like(peer: Variable | None, name: str, causality: str) -> Variable:
    """Return a variable that fits one at the other end of a connection, a plain number if there is none."""
    if peer is None:
        return Variable(name, 0, "Real", causality)
    variability = "continuous" if peer.type == "Real" else "discrete"
    return Variable(
        name, 0, peer.type, causality, variability, unit=peer.measured_in, nominal=peer.nominal, items=peer.items
    )


def _type_of(value: Signal | object) -> VariableType:
    """Return the type of a signal or value; numbers are Real, whether or not they are whole."""
    levels = getattr(value, "levels", (value,))
    first = levels[0] if levels else 0.0
    return "Boolean" if isinstance(first, bool) else "String" if isinstance(first, str) else "Real"


def _started(variable: Variable, callee: Callee) -> Variable:
    """Return an input with the default of its parameter as start value."""
    default = callee.parameters[variable.name].default if variable.name in callee.parameters else None
    fits = isinstance(default, _SIMPLE) and _type_of(default) == variable.type
    return replace(variable, start=_text(default)) if fits else variable


def _text(value: Any) -> str:
    """Write a start value as a model description does."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _parameters(part: Component, callee: Callee, driven: Collection[str]) -> Iterator[Variable]:
    """Give what is set once and for all: parameters with a value, or with a default that a record can tell."""
    defaults = {name: each.default for name, each in callee.parameters.items()}
    more = {name: None for name in part.parameters if callee.takes(name)}
    for name in (name for name in {**defaults, **more} if name not in driven):
        default = defaults.get(name)
        value = part.parameters.get(name, default)
        if isinstance(value, _SIMPLE):
            whole = all(isinstance(each, int) and not isinstance(each, bool) for each in (value, default))
            kind = "Integer" if whole else _type_of(value)
            start = _text(default) if isinstance(default, _SIMPLE) and _type_of(default) == _type_of(value) else None
            yield Variable(name, 0, kind, "parameter", "fixed", "exact", start=start)


def _refuse_unfed(part: Component, callee: Callee, driven: Collection[str], known: Mapping[str, Description]) -> None:
    """Refuse a function that would be called without a value that it needs."""
    names = {variable.name for each in known.values() for variable in each.with_causality("output")}
    for name, parameter in callee.parameters.items():
        if name not in driven and name not in part.parameters and parameter.default is inspect.Parameter.empty:
            raise SystemDefinitionError(
                f"{part.name}: nothing feeds the parameter '{name}' of {callee.name}, which has no default; expected a "
                f"connection, a signal or a value{suggestion(name, names - {name})}"
            )


class FunctionSlave:
    """A function as the master sees it.

    Parameters
    ----------
    name : str
        Of the component, in every message.
    callee : Callee
        What is called.
    description : Description
        From `describe_functions`.
    repeats : bool
        Whether steps are repeated, so that equal arguments must give equal outputs.
    """

    def __init__(self, name: str, callee: Callee, description: Description, *, repeats: bool = False) -> None:
        self.name = name
        self._callee, self._description = callee, description
        self._function = _called(callee)
        self._time = 0.0
        self._started, self._repeats, self._twice = False, repeats, repeats
        self._arguments: dict[str, Any] = {}
        self._answered: dict[str, Any] | None = None
        self._outputs: dict[str, Value] = {}
        self._slots: dict[int, tuple[float, dict[str, Value]]] = {}
        self._reads: list[tuple[Any, int, Variable]] = []
        self._writes: list[tuple[Any, int, Variable]] = []

    @property
    def description(self) -> Description:
        """Variables and capabilities."""
        return self._description

    def setup(self, block: Block, start_values: Mapping[Variable, Value], start_time: float, stop_time: float) -> None:
        """Remember where values are exchanged, and what does not change; times in s."""
        del stop_time
        self._time = start_time
        given = {variable.name: value for variable, value in start_values.items()}
        self._arguments = {name: value for name, value in given.items() if self._callee.takes(name)}
        self._reads = [place for kind in BASE_TYPES for place in _places(block.inputs[kind])]
        self._writes = [place for kind in BASE_TYPES for place in _places(block.outputs[kind])]

    def enter_initialization(self) -> None:
        """Begin to exchange values at the start time."""

    def exit_initialization(self) -> None:
        """Answer what is consistent now."""
        self._started = True
        self._answer()

    def write(self, row: int) -> None:
        """Take the inputs from a row of the block."""
        for cells, column, variable in self._reads:
            value = cells[row, column]
            self._arguments[variable.name] = bool(value) if variable.type == "Boolean" else value

    def step(self, time: float, size: float) -> None:
        """Answer at the end of the step from `time` [s] of `size` [s]."""
        self._time = time + size
        self._answer()

    def read(self, row: int) -> None:
        """Put the outputs into a row of the block."""
        if not self._started:
            self._try_answer()
        for cells, column, variable in self._writes:
            if variable.name in self._outputs:
                cells[row, column] = self._outputs[variable.name]

    def save(self, slot: int) -> None:
        """Keep time and outputs under a number; what comes next may be repeated, so it is tried."""
        self._twice = self._repeats
        self._slots[slot] = self._time, self._outputs

    def restore(self, slot: int) -> None:
        """Return to the time and outputs that were kept under a number."""
        self._time, self._outputs = self._slots[slot]

    def serialise(self) -> bytes:
        """Return nothing: a function has no state."""
        return b""

    def deserialise(self, content: bytes, time: float) -> None:
        """Go on at a communication point [s]."""
        del content
        self._time = time

    def terminate(self) -> None:
        """End the run."""

    def _try_answer(self) -> None:
        """Answer what may not be meant yet: values at the start are first sought from none at all."""
        try:
            self._answer()
        except FunctionError:
            return  # asked again with consistent values, it says so

    def _answer(self) -> None:
        """Call the function, and take the outputs from what it returns."""
        arguments = {**self._arguments, TIME: self._time} if self._callee.takes_time else dict(self._arguments)
        try:
            answer = self._function(arguments)
        except Exception as error:  # whatever a user's function raises
            said = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
            raise self._error(f"raised {said}") from error
        outputs = self._taken(answer)
        if self._repeats and arguments == self._answered:
            for name, value in outputs.items():
                if value != self._outputs.get(name, value):
                    raise self._error(
                        f"gave {name} = {self._outputs[name]!r}, and then {value!r} from the same arguments; expected "
                        "a function that remembers nothing, as this algorithm repeats steps"
                    )
        twice, self._twice = self._twice, False
        self._answered, self._outputs = arguments, outputs
        if twice:
            self._answer()

    def _taken(self, answer: object) -> dict[str, Value]:
        """Return the outputs by name."""
        names = [variable.name for _, _, variable in self._writes]
        if not isinstance(answer, Mapping):
            if not names:
                return {}
            if len(names) > 1:
                listed = ", ".join(f"'{name}'" for name in names)
                raise self._error(f"gave {reprlib.repr(answer)}; expected a mapping with {listed}")
            answer = {names[0]: answer}
        given = cast(Mapping[object, object], answer)
        for name in names:
            if name not in given:
                raise self._error(f"gave no '{name}', which is connected{suggestion(name, map(str, given))}")
        return {variable.name: self._value(variable, given[variable.name]) for _, _, variable in self._writes}

    def _value(self, variable: Variable, given: object) -> Value:
        """Return an output as its type wants it."""
        value = plain_value(given)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        fits = {
            "Real": (number and math.isfinite(value), "a finite number"),
            "Boolean": (isinstance(value, bool), "true or false"),
            "String": (isinstance(value, str), "a string"),
        }.get(variable.type, (number and isinstance(value, int), "an integer"))
        if not fits[0]:
            raise self._error(f"gave {variable.name} = {reprlib.repr(value)}; expected {fits[1]}")
        return float(value) if variable.type == "Real" else value

    def _error(self, what: str) -> FunctionError:
        return FunctionError(self.name, self._time, self._callee.name, what)


def _places(section: Section) -> Iterator[tuple[Any, int, Variable]]:
    """Give for each variable of a section where its values are; memory views are quickest to index."""
    cells = section.values if section.values.dtype == TEXT else memoryview(cast(Any, section.values))
    for column, variable in enumerate(section.variables):
        yield cells, column, variable


def _called(callee: Callee) -> Callable[[dict[str, Any]], object]:
    """Return what calls a function with arguments by name, those that must be so by their place."""
    function, positional = callee.function, callee.positional
    if not positional:
        return lambda arguments: function(**arguments)
    defaults = {name: callee.parameters[name].default for name in positional if name in callee.parameters}

    def call(arguments: dict[str, Any]) -> object:
        given = {**defaults, **arguments}
        placed = [given.pop(name) for name in positional]
        return function(*placed, **given)

    return call
