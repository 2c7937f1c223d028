"""Check that a system fits the FMUs it names; every refusal names component, variable, expected and actual.

What the user wrote becomes what the FMU's setters take, or a sentence that says why not.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cosim.errors import Refusals, SystemDefinitionError, format_time, suggestion
from cosim.system.conversion import conversion_of, unit_conversion
from cosim.system.description import Description, Match, Variable, compare, describe
from cosim.system.signals import FloatArray, Signal, Value
from cosim.system.structure import Component, Connection, Port, System

log = logging.getLogger("cosim")

StartValues = Mapping[str, Mapping[Variable, Value]]


def check_system(system: System, descriptions: Mapping[str, Description]) -> StartValues:
    """Check connections, input signals and parameters against the model descriptions.

    Parameters
    ----------
    system : System
        What is to be coupled.
    descriptions : mapping of str to Description
        By name of component, one for each.

    Returns
    -------
    mapping of str to mapping of Variable to value
        Start values by component, converted to the variables' types.

    Raises
    ------
    SystemDefinitionError
        For all that does not fit.
    """
    told: set[tuple[str, str]] = set()
    values: dict[str, dict[Variable, Value]] = {}
    refusals = Refusals()
    for connection in system.connections:
        with refusals.noted():
            _check_connection(connection, descriptions, told)
    check_signals(system, descriptions, refusals)
    driven: dict[Port, str] = {connection.target: connection.source for connection in system.connections}
    driven.update(dict.fromkeys(system.inputs, "a signal"))
    for part in system.components:
        with refusals.noted():
            values[part.name] = start_values(part, descriptions[part.name])
        given = {variable.name for variable in values.get(part.name, ())}
        for variable in descriptions[part.name].variables:
            if variable.causality == "input" or variable.tunable:
                with refusals.noted():
                    _check_input(Port(part.name, variable.name), variable, variable.name in given, driven)
    refusals.raise_all(SystemDefinitionError)
    return values


def check_signals(system: System, descriptions: Mapping[str, Description], refusals: Refusals) -> None:
    """Note which signals do not fit what they drive."""
    for target, signal in system.inputs.items():
        with refusals.noted():
            _check_signal(target, signal, _variable(target, descriptions))


def check_course(system: System, descriptions: Mapping[str, Description], start: float, stop: float) -> None:
    """Refuse signals that leave the range of what they drive in a run [s], and warn of one of which nothing is in it.

    Raises
    ------
    SystemDefinitionError
        For all that do.
    """
    refusals = Refusals()
    for port, signal in system.inputs.items():
        variable = _variable(port, descriptions)
        if signal.levels is not None or variable.type != "Real":
            continue
        corners = np.array(signal.breakpoints, dtype=float)
        inner = corners[(corners > start) & (corners < stop)]
        times = np.unique([start, *inner, stop])
        if corners.size > 1 and (corners[0] >= stop or corners[-1] <= start):
            what = f"{format_time(float(corners[0]))} s to {format_time(float(corners[-1]))} s"
            log.warning("%s: the %s goes from %s, so that nothing of it is in the run", port, signal.kind, what)
        with refusals.noted():
            _refuse_beyond(port, variable, times[:-1], signal.values(times[:-1]))
            _refuse_beyond(port, variable, times[1:], signal.left_values(times[1:]))
    refusals.raise_all(SystemDefinitionError)


def _refuse_beyond(port: Port, variable: Variable, times: FloatArray, given: NDArray[np.generic]) -> None:
    """Refuse the first value that is not finite or not in the range of a variable."""
    values = np.asarray(given, dtype=float)
    low = -math.inf if variable.minimum is None else variable.minimum
    high = math.inf if variable.maximum is None else variable.maximum
    beyond = np.flatnonzero(~(np.isfinite(values) & (values >= low) & (values <= high)))
    if beyond.size:
        first = beyond[0]
        convert(f"{port} at t = {format_time(float(times[first]))} s", variable, float(values[first]))


def _variable(port: Port, descriptions: Mapping[str, Description]) -> Variable:
    """Find a variable among the inputs and outputs, or refuse it."""
    wanted, description = port.variable, descriptions[port.component]
    if wanted in description.by_name:
        return description.by_name[wanted]
    known = [v.name for v in description.variables if v.causality in ("input", "output") or v.tunable]
    hint = suggestion(wanted, known)
    raise SystemDefinitionError(f"{port.component}: {description.model_name} has no variable '{wanted}'{hint}")


def _check_connection(
    connection: Connection, descriptions: Mapping[str, Description], told: set[tuple[str, str]]
) -> None:
    """Refuse a connection whose ends do not exist, face the wrong way, or differ in type, items or kind of unit."""
    source = _variable(connection.source, descriptions)
    target = _variable(connection.target, descriptions)
    label = f"connection {connection.source} -> {connection.target}"
    for name, variable, wanted in ((connection.source, source, "output"), (connection.target, target, "input")):
        if variable.causality != wanted:
            raise SystemDefinitionError(f"{label}: {name} has causality {variable.causality}; expected {wanted}")
    if {source.type, target.type} == {"Integer", "Enumeration"}:
        if not connection.table:
            log.warning("%s: %s is given to %s; numbers are passed on", label, source.type, target.type)
    elif source.type != target.type:
        raise SystemDefinitionError(f"{label}: {connection.source} is {source.type}; expected {target.type}")
    elif not connection.table:
        _check_items(label, source.items, target.items)
    conversion_of(connection, descriptions)
    if not connection.unconverted:
        _check_units(label, source, target, told)


def _check_items(label: str, source: Mapping[str, int], target: Mapping[str, int]) -> None:
    """Refuse enumerations in which one name has two numbers; warn of others that are not the same."""
    for name in source:
        if name in target and source[name] != target[name]:
            raise SystemDefinitionError(f"{label}: '{name}' is {source[name]} at the source; expected {target[name]}")
    if source != target:
        actual, expected = (_list_items(items) or "none" for items in (source, target))
        log.warning(
            "%s: the items at the source are %s, at the input %s; numbers are passed on", label, actual, expected
        )


def _check_units(label: str, source: Variable, target: Variable, told: set[tuple[str, str]]) -> None:
    """Refuse units of different quantities; warn where it cannot be known, of two units of one name once."""
    match = compare(source.measured_in, target.measured_in)
    actual, expected = describe(source.measured_in), describe(target.measured_in)
    mixed = source.relative != target.relative
    shifted = mixed and unit_conversion(source.measured_in, target.measured_in)[1] != 0.0
    if match is Match.DIFFERENT or shifted:  # a difference of two temperatures is no temperature
        raise SystemDefinitionError(f"{label}: the source is in {actual}; expected {expected}")
    if mixed and any(end.unit is not None and end.unit.offset for end in (source, target)):
        which = "the source" if source.relative else "the input"
        log.warning("%s: %s alone is a difference; %s is passed on as one of %s", label, which, actual, expected)
    if match is Match.UNKNOWN:
        log.warning("%s: cannot tell whether %s and %s are the same unit", label, actual, expected)
    if match is Match.ASSUMED and (actual, expected) not in told:
        told.add((actual, expected))
        log.warning("%s: %s and %s are taken for the same unit, which one FMU does not define", label, actual, expected)


def _check_signal(target: Port, signal: Signal, variable: Variable) -> None:
    """Refuse a signal for what is neither an input nor a tunable parameter, or of another type."""
    if variable.causality != "input" and not variable.tunable:
        kind = f"is {_kind(variable)}" if variable.causality == "parameter" else f"has causality {variable.causality}"
        raise SystemDefinitionError(f"{target} {kind}; a signal drives an input or a tunable parameter only")
    for level in signal.levels or ():
        convert(target, variable, level)
    if signal.levels is None and variable.type != "Real":
        raise SystemDefinitionError(f"{target} is {variable.type}; a {signal.kind} drives Real variables only")


def with_numbers(system: System, descriptions: Mapping[str, Description]) -> System:
    """Return a checked system whose signals for enumerations give the numbers of items that they name."""
    inputs = dict(system.inputs)
    for port, signal in system.inputs.items():
        variable = _variable(port, descriptions)
        if variable.type == "Enumeration":
            inputs[port] = signal.with_levels(partial(convert, port, variable))
    return replace(system, inputs=inputs)


class Written(str):
    """A value as it was written on a command line, to be read by the type of its variable."""

    __slots__ = ()


def read_written(system: System, descriptions: Mapping[str, Description]) -> System:
    """Return the system with all values read that are as they were written; what cannot be read stays a string."""

    def read(component: str, variable: str, value: Value) -> Value:
        known = descriptions[component].by_name.get(variable)
        return read_value(value, known) if isinstance(value, Written) else value

    components = tuple(
        replace(part, parameters={name: read(part.name, name, value) for name, value in part.parameters.items()})
        for part in system.components
    )
    inputs = {
        port: signal.with_levels(partial(read, port.component, port.variable)) for port, signal in system.inputs.items()
    }
    return replace(system, components=components, inputs=inputs)


def read_value(text: str, variable: Variable | None) -> Value:
    """Read a text as a value of a variable's type; if it is none, as a string, without quotes around it."""
    plain = text[1:-1] if len(text) > 1 and text[0] == text[-1] and text[0] in "\"'" else str(text)
    kind = variable.type if variable is not None else "String"
    if variable is None or kind == "String" or plain in variable.items:
        return plain
    if kind == "Boolean":
        return {"true": True, "false": False}.get(text.lower(), plain)
    try:
        return float(text) if kind == "Real" else int(text)
    except ValueError:
        return plain


def _check_input(name: Port, variable: Variable, given: bool, driven: Mapping[Port, str]) -> None:
    """Refuse an input that has no value; and one, or a parameter, that has a value given beside its source."""
    if name in driven and given:
        raise SystemDefinitionError(f"{name} is driven by {driven[name]}; its value cannot be set as well")
    if variable.causality == "input" and name not in driven and not given and variable.start is None:
        raise SystemDefinitionError(
            f"{name} is not connected and has no start value; expected a connection or a signal"
        )


_KINDS = {"Real": "a number", "Integer": "an integer", "Boolean": "true or false", "String": "a string"}
_GREATEST_WHOLE = 2**1023
_LEAST_INTEGER, _GREATEST_INTEGER = -(2**31), 2**31 - 1


def start_values(component: Component, description: Description) -> dict[Variable, Value]:
    """Check the parameters of a component and convert them.

    Returns
    -------
    dict of Variable to float, int, bool or str
        Enumeration items by their number, integers for Real variables as floats.

    Raises
    ------
    SystemDefinitionError
        Naming component, variable, value and what was expected.
    """
    values: dict[Variable, Value] = {}
    for name, value in component.parameters.items():
        variable = description.by_name.get(name)
        if variable is None:
            known = [known.name for known in description.variables if known.settable]
            hint = suggestion(name, known)
            raise SystemDefinitionError(f"{component.name}: {description.model_name} has no variable '{name}'{hint}")
        label = f"{component.name}.{name}"
        if not variable.settable:
            raise SystemDefinitionError(
                f"{label} is {_kind(variable)}; expected a parameter, an input or a variable with a start value"
            )
        values[variable] = convert(label, variable, value)
    return values


def convert(label: str, variable: Variable, value: Value) -> Value:
    """Convert one value to the type of its variable and check it against the declared range.

    Parameters
    ----------
    label : str
        The variable's full name, for the message.
    variable : Variable
        What it is for.
    value : float, int, bool or str
        What the user wrote.

    Raises
    ------
    SystemDefinitionError
        If the type or range does not fit.
    """
    if variable.type == "Enumeration":
        return _enumeration(label, variable.items, value)
    number = isinstance(value, int | float) and not isinstance(value, bool)
    fits = {
        "Real": number,
        "Integer": number and isinstance(value, int),
        "Boolean": isinstance(value, bool),
        "String": isinstance(value, str),
    }
    if not fits[variable.type]:
        raise SystemDefinitionError(f"{label} is {_show(value)}; expected {_KINDS[variable.type]}")
    if isinstance(value, str) and "\0" in value:
        raise SystemDefinitionError(f"{label} has a NUL at {value.index(chr(0))}; expected a string without one")
    if isinstance(value, str | bool):
        return value
    if isinstance(value, int) and not -_GREATEST_WHOLE <= value <= _GREATEST_WHOLE:
        raise SystemDefinitionError(f"{label} is an integer of {value.bit_length()} bits; expected a finite number")
    _refuse_out_of_range(label, variable, value)
    return float(value) if variable.type == "Real" else value


def _enumeration(label: str, items: Mapping[str, int], value: Value) -> int:
    """Return the number of an item given by name or number."""
    if isinstance(value, str) and value in items:
        return items[value]
    if isinstance(value, int) and not isinstance(value, bool) and value in items.values():
        return value
    raise SystemDefinitionError(f"{label} is {_show(value)}; expected one of {_list_items(items)}")


def _list_items(items: Mapping[str, int]) -> str:
    """Name the items of an enumeration with their numbers."""
    return ", ".join(f"'{name}' ({number})" for name, number in items.items())


def _refuse_out_of_range(label: str, variable: Variable, value: float) -> None:
    """Refuse a number that is not finite, beyond 32 bits, or beyond the declared minimum or maximum."""
    low = variable.minimum if variable.minimum is not None else -math.inf
    high = variable.maximum if variable.maximum is not None else math.inf
    if variable.type == "Integer":
        low, high = max(low, _LEAST_INTEGER), min(high, _GREATEST_INTEGER)
    if math.isfinite(value) and low <= value <= high:
        return
    unit = f" {variable.unit.name}" if variable.unit and variable.unit.name != "1" else ""
    bounds = [f">= {low:.12g}" if low > -math.inf else "", f"<= {high:.12g}" if high < math.inf else ""]
    wanted = " ".join(["a finite number", " and ".join(bound for bound in bounds if bound)]).strip()
    raise SystemDefinitionError(f"{label} is {value:.12g}{unit}; expected {wanted}{unit if any(bounds) else ''}")


def _kind(variable: Variable) -> str:
    """Say what a variable is, for a message."""
    kind = "constant" if variable.variability == "constant" else variable.causality
    if kind == "parameter":
        return f"a {variable.variability} parameter"
    return f"an {kind}" if kind[0] in "aeiou" else f"a {kind}"


def _show(value: Value) -> str:
    """Write a value as the user would in a scenario."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"'{value}'" if isinstance(value, str) else f"{value}"
