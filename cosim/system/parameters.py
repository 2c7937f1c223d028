"""Start values: from what the user wrote to what the FMU's setters take, or a sentence that says why not."""

from __future__ import annotations

import math
from collections.abc import Mapping

from cosim.errors import SystemDefinitionError, suggestion
from cosim.system.description import Description, Variable
from cosim.system.signals import Value
from cosim.system.structure import Component

_KINDS = {"Real": "a number", "Integer": "an integer", "Boolean": "true or false", "String": "a string"}
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
    if isinstance(value, str | bool):
        return value
    _refuse_out_of_range(label, variable, value)
    return float(value) if variable.type == "Real" else value


def _enumeration(label: str, items: Mapping[str, int], value: Value) -> int:
    """Return the number of an item given by name or number."""
    if isinstance(value, str) and value in items:
        return items[value]
    if isinstance(value, int) and not isinstance(value, bool) and value in items.values():
        return value
    known = ", ".join(f"'{name}' ({number})" for name, number in items.items())
    raise SystemDefinitionError(f"{label} is {_show(value)}; expected one of {known}")


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
    return f"an {kind}" if kind[0] in "aeiou" else f"a {kind}"


def _show(value: Value) -> str:
    """Write a value as the user would in a scenario."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"'{value}'" if isinstance(value, str) else f"{value}"
