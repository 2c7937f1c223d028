"""An interface table as pythonfmu wants it registered, and its bounds as sentences."""

# pyright: reportMissingTypeStubs=false

from __future__ import annotations

from collections.abc import Callable
from math import inf, isfinite

from pythonfmu import variables as declared
from pythonfmu.enums import Fmi2Causality, Fmi2Initial, Fmi2Variability

from ..schema import Value, Variable

_CLASSES = {
    "Real": declared.Real,
    "Integer": declared.Integer,
    "Enumeration": declared.Integer,  # FMI gets and sets enumerations as integers
    "Boolean": declared.Boolean,
    "String": declared.String,
}
_REST: dict[str, Value] = {"Real": 0.0, "Integer": 0, "Enumeration": 1, "Boolean": False, "String": ""}


def declaration(
    variable: Variable, getter: Callable[[], Value], setter: Callable[[Value], None]
) -> declared.ScalarVariable:
    """Return a variable of a table as one that pythonfmu can register."""
    calculated = variable.causality == "output"
    return _CLASSES[variable.kind](
        variable.name,
        description=variable.description,
        causality=Fmi2Causality[variable.causality],
        variability=Fmi2Variability[variable.variability],
        initial={"output": Fmi2Initial.calculated, "parameter": Fmi2Initial.exact}.get(variable.causality),
        getter=getter,
        setter=None if calculated else setter,
    )


def first_value(variable: Variable) -> Value:
    """Return the start value of a variable; of one that has none, what it is before it is calculated."""
    return _REST[variable.kind] if variable.start is None else variable.start


def misfit(variable: Variable, value: object) -> str | None:
    """Return why a variable cannot take a value, naming it, the value and what is expected; None if it can."""
    if variable.kind == "String":
        if isinstance(value, str):
            return None
    elif isinstance(value, int | float):
        low, high = variable.bounds
        if isfinite(value) and low <= value <= high:
            return None
    return f"{variable.causality} {variable.name} is {_shown(variable, value)}; expected {_expected(variable)}"


def _shown(variable: Variable, value: object) -> str:
    return f"{value!r} {variable.unit}" if variable.unit not in (None, "1") else repr(value)


def _expected(variable: Variable) -> str:
    match variable.kind:
        case "String":
            return "a text"
        case "Boolean":
            return "true or false"
        case "Enumeration":
            return " or ".join(f"{number} ({item})" for number, item in enumerate(variable.items, start=1))
        case "Integer":
            return f"a whole number {_span(*variable.bounds)}".rstrip()
        case "Real":
            return f"a finite value {_span(*variable.bounds)}".rstrip()


def _span(low: float, high: float) -> str:
    if high == inf:
        return "" if low == -inf else f"not below {low:g}"
    return f"not above {high:g}" if low == -inf else f"from {low:g} to {high:g}"
