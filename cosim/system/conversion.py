"""Say what becomes of a value on its way from an output to an input: another unit, a factor and offset, or a table.

Real numbers are converted into the unit of the input first, and then multiplied by the factor and shifted by the offset
of the connection, which are in that unit; Booleans, integers and enumerations go through the connection's table, in
which what is not listed stays as it is (SSP 2.0, sections 4.5.5 and 5.3.5). Both together are one `Conversion`, which
every algorithm applies where it passes a value on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from cosim.errors import SystemDefinitionError
from cosim.system.description import Description, Match, Unit, Variable, compare
from cosim.system.signals import Value
from cosim.system.structure import Connection

_WHOLE = ("Boolean", "Integer", "Enumeration")


@dataclass(frozen=True)
class Conversion:
    """Give what an input gets for what an output gives.

    Attributes
    ----------
    factor, offset : float
        Of numbers: the input gets factor times the output plus offset.
    table : tuple of pairs of int, optional
        Of Booleans, integers and enumerations, instead: what the input gets for what the output gives.
    """

    factor: float = 1.0
    offset: float = 0.0
    table: tuple[tuple[int, int], ...] = ()

    def of(self, value: Any) -> Any:
        """Convert one value."""
        if self.table:
            return next((taken for given, taken in self.table if given == value), value)
        return self.factor * value + self.offset

    def of_all(self, values: NDArray[Any]) -> NDArray[Any]:
        """Convert an array."""
        if not self.table:
            return self.factor * values + self.offset
        converted = values.copy()
        for given, taken in self.table:
            converted[values == given] = taken
        return converted

    def record(self) -> dict[str, Any]:
        """Return what a manifest tells of it."""
        if self.table:
            return {"table": [list(pair) for pair in self.table]}
        return {"factor": self.factor, "offset": self.offset}


def conversion_of(connection: Connection, descriptions: Mapping[str, Description]) -> Conversion | None:
    """Return what a connection does to values; None if they are passed on as they are.

    Raises
    ------
    SystemDefinitionError
        If what the connection asks for does not fit the types of its ends.
    """
    source, target = (
        descriptions[port.component].by_name[port.variable] for port in (connection.source, connection.target)
    )
    label = f"connection {connection.source} -> {connection.target}"
    if connection.table:
        return Conversion(table=_numbers(label, connection, source, target))
    scaled = (connection.factor, connection.offset) != (1.0, 0.0)
    if scaled and not source.type == target.type == "Real":
        raise SystemDefinitionError(
            f"{label}: factor and offset are for Real; {connection.source} is {source.type}, {connection.target} "
            f"{target.type}"
        )
    if source.type != "Real":
        return None
    unit = (1.0, 0.0) if connection.unconverted else unit_conversion(source.measured_in, target.measured_in)
    if not scaled and unit == (1.0, 0.0):
        return None
    return Conversion(connection.factor * unit[0], connection.factor * unit[1] + connection.offset)


def unit_conversion(source: Unit | None, target: Unit | None) -> tuple[float, float]:
    """Return factor and offset from one unit to another; 1 and 0 where nothing is known, or to be converted."""
    if source is None or target is None or compare(source, target) is not Match.SCALED:
        return 1.0, 0.0
    return source.factor / target.factor, (source.offset - target.offset) / target.factor


def _numbers(label: str, connection: Connection, source: Variable, target: Variable) -> tuple[tuple[int, int], ...]:
    """Return a table in numbers, as FMI passes what is not Real, without what the source never gives."""
    fit = source.type == target.type or {source.type, target.type} <= {"Integer", "Enumeration"}
    if not (fit and source.type in _WHOLE):
        raise SystemDefinitionError(
            f"{label}: a table is for Boolean, Integer or Enumeration; {connection.source} is {source.type}, "
            f"{connection.target} {target.type}"
        )
    pairs = [(_number(source, given), _number(target, taken), taken) for given, taken in connection.table]
    for _, number, taken in pairs:
        if number is None:
            known = ", ".join(f"'{name}'" for name in target.items) or target.type
            raise SystemDefinitionError(f"{label}: the table leads to {taken!r}; expected {known}")
    return tuple((given, taken) for given, taken, _ in pairs if given is not None and taken is not None)


def _number(variable: Variable, value: Value) -> int | None:
    """Return the number of a value in a table; None if it is none of the variable's."""
    if variable.type == "Enumeration":
        if isinstance(value, str):
            return variable.items.get(value)
        fits = not isinstance(value, bool) and isinstance(value, int) and value in variable.items.values()
        return int(value) if fits else None
    kind = bool if variable.type == "Boolean" else int
    return int(value) if type(value) is kind else None
