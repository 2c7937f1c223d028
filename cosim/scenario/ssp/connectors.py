"""Connections of a description, and the connectors at their ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from cosim.errors import SspError, suggestion
from cosim.scenario.ssp.document import plain_name
from cosim.scenario.ssp.parameter_set import read_units
from cosim.scenario.ssp.vocabulary import ssc, ssd
from cosim.system.description import Description, Unit
from cosim.system.structure import Connection
from cosim.system.units import Match, compare, describe

_KEPT = ("ConnectionGeometry", "Annotations")
_CLASHES = (Match.DIFFERENT, Match.SCALED)


@dataclass(frozen=True)
class Connector:
    """A connector of a component; `unit` is its own or, if it has none, that of the FMU's variable."""

    kind: str
    unit: Unit | None


def read_connectors(root: Element, component: Element, description: Description, where: str) -> dict[str, Connector]:
    """Read the connectors of a component by name.

    Raises
    ------
    SspError
        If the FMU has no variable of that name, or has it in another unit.
    """
    units = read_units(root.find(ssd("Units")))
    connectors: dict[str, Connector] = {}
    for element in component.iterfind(f"{ssd('Connectors')}/{ssd('Connector')}"):
        name = str(element.get("name"))
        label = f"{where}: connector {component.get('name')}.{name}"
        if name not in description.by_name:
            hint = suggestion(name, description.by_name)
            raise SspError(f"{label}: {description.model_name} has no variable of that name{hint}")
        variable = description.by_name[name]
        kind = element.find(ssc("Real"))
        given = kind.get("unit") if kind is not None else None
        unit = units.get(given, Unit(given)) if given is not None else variable.unit
        if variable.unit is not None and unit is not None and compare(unit, variable.unit) is not Match.SAME:
            raise SspError(
                f"{label} is in {describe(unit)}, the FMU's variable in {describe(variable.unit)}; "
                "conversion of units is not supported"
            )
        connectors[name] = Connector(str(element.get("kind")), unit)
    return connectors


def read_connections(
    whole: Element, connectors: Mapping[str, Mapping[str, Connector]], where: str
) -> tuple[Connection, ...]:
    """Read the connections of a system, whichever way round they are written.

    Parameters
    ----------
    whole : Element
        ssd:System.
    connectors : mapping
        By component and name.
    where : str
        File it is from, for messages.

    Raises
    ------
    SspError
        If an end does not exist or belongs to the system, the kinds do not fit, or the values would have to be
        transformed.
    """
    path = f"{ssd('Connections')}/{ssd('Connection')}"
    return tuple(_connection(element, connectors, where) for element in whole.iterfind(path))


def _connection(element: Element, connectors: Mapping[str, Mapping[str, Connector]], where: str) -> Connection:
    """Read one connection."""
    start, end = _end(element, "start", connectors, where), _end(element, "end", connectors, where)
    label = f"{where}: connection {start} -> {end}"
    for child in element:
        if plain_name(child.tag) not in _KEPT:
            raise SspError(f"{label} has a {plain_name(child.tag)}, which is not supported")
    (first, second) = (_connector(name, connectors) for name in (start, end))
    if compare(first.unit, second.unit) in _CLASHES and element.get("suppressUnitConversion") not in ("true", "1"):
        raise SspError(
            f"{label} leads from {describe(first.unit)} to {describe(second.unit)}; conversion of units is not "
            "supported"
        )
    if (first.kind, second.kind) == ("input", "output"):
        return Connection(end, start)
    if (first.kind, second.kind) != ("output", "input"):
        raise SspError(f"{label} leads from {first.kind} to {second.kind}; expected an output and an input")
    return Connection(start, end)


def _end(element: Element, side: str, connectors: Mapping[str, Mapping[str, Connector]], where: str) -> str:
    """Return ``component.connector`` of one end."""
    name, component = element.get(f"{side}Connector", ""), element.get(f"{side}Element")
    if not component:
        raise SspError(f"{where}: a connection leads to the connector {name} of the system, which is not supported")
    if component not in connectors:
        hint = suggestion(component, connectors)
        raise SspError(
            f"{where}: a connection leads to {component}.{name}, but there is no component of that name{hint}"
        )
    if name not in connectors[component]:
        hint = suggestion(name, connectors[component])
        raise SspError(f"{where}: a connection leads to {component}.{name}, which has no such connector{hint}")
    return f"{component}.{name}"


def _connector(name: str, connectors: Mapping[str, Mapping[str, Connector]]) -> Connector:
    """Find a connector by ``component.connector``."""
    component, _, connector = name.partition(".")
    return connectors[component][connector]
