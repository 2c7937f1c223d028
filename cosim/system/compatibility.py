"""Whether a system fits the FMUs it names; every refusal names component, variable, expected and actual."""

from __future__ import annotations

import logging
from collections.abc import Mapping

from cosim.errors import SystemDefinitionError, suggestion
from cosim.system.description import Description, Variable
from cosim.system.parameters import convert, start_values
from cosim.system.signals import Constant, Signal, Step, Value
from cosim.system.structure import Connection, System, split_name
from cosim.system.units import Match, compare, describe

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
        For the first thing that does not fit.
    """
    for connection in system.connections:
        _check_connection(connection, descriptions)
    for target, signal in system.inputs.items():
        _check_signal(target, signal, _variable(target, descriptions))
    values = {part.name: start_values(part, descriptions[part.name]) for part in system.components}
    driven = {connection.target: connection.source for connection in system.connections}
    driven.update(dict.fromkeys(system.inputs, "a signal"))
    for name, description in descriptions.items():
        given = {variable.name for variable in values[name]}
        for variable in description.with_causality("input"):
            _check_input(f"{name}.{variable.name}", variable, variable.name in given, driven)
    return values


def _variable(name: str, descriptions: Mapping[str, Description]) -> Variable:
    """Find ``component.variable`` among the inputs and outputs, or refuse it."""
    component, wanted = split_name(name)
    description = descriptions[component]
    if wanted in description.by_name:
        return description.by_name[wanted]
    known = [variable.name for variable in description.variables if variable.causality in ("input", "output")]
    hint = suggestion(wanted, known)
    raise SystemDefinitionError(f"{component}: {description.model_name} has no variable '{wanted}'{hint}")


def _check_connection(connection: Connection, descriptions: Mapping[str, Description]) -> None:
    """Refuse a connection whose ends do not exist, face the wrong way, or differ in type or unit."""
    source = _variable(connection.source, descriptions)
    target = _variable(connection.target, descriptions)
    label = f"connection {connection.source} -> {connection.target}"
    for name, variable, wanted in ((connection.source, source, "output"), (connection.target, target, "input")):
        if variable.causality != wanted:
            raise SystemDefinitionError(f"{label}: {name} has causality {variable.causality}; expected {wanted}")
    if source.type != target.type:
        raise SystemDefinitionError(f"{label}: {connection.source} is {source.type}; expected {target.type}")
    if source.type == "String":
        raise SystemDefinitionError(f"{label}: both ends are String; expected numbers, Booleans or enumerations")
    _check_units(label, source, target)


def _check_units(label: str, source: Variable, target: Variable) -> None:
    """Refuse units that differ; warn where it cannot be known."""
    match = compare(source.unit, target.unit)
    actual, expected = describe(source.unit), describe(target.unit)
    if match is Match.DIFFERENT:
        raise SystemDefinitionError(f"{label}: the source is in {actual}; expected {expected}")
    if match is Match.SCALED:
        raise SystemDefinitionError(
            f"{label}: the source is in {actual}; expected {expected}; values are passed on unconverted"
        )
    if match is Match.UNKNOWN:
        log.warning("%s: cannot tell whether %s and %s are the same unit", label, actual, expected)


def _check_signal(target: str, signal: Signal, variable: Variable) -> None:
    """Refuse a signal for what is no input, or of another type."""
    if variable.causality != "input":
        raise SystemDefinitionError(f"{target} has causality {variable.causality}; a signal drives an input only")
    if variable.type == "String":
        raise SystemDefinitionError(f"{target} is String; a signal drives numbers, Booleans and enumerations only")
    if isinstance(signal, Constant):
        convert(target, variable, signal.value)
    elif isinstance(signal, Step):
        convert(target, variable, signal.before)
        convert(target, variable, signal.after)
    elif variable.type != "Real":
        raise SystemDefinitionError(f"{target} is {variable.type}; ramps and tables drive Real inputs only")


def _check_input(name: str, variable: Variable, given: bool, driven: Mapping[str, str]) -> None:
    """Refuse an input that has no value, or has one given beside its source."""
    if name in driven and given:
        raise SystemDefinitionError(f"{name} is driven by {driven[name]}; its value cannot be set as well")
    if name not in driven and not given and variable.start is None:
        raise SystemDefinitionError(
            f"{name} is not connected and has no start value; expected a connection or a signal"
        )
