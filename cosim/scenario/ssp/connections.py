"""Read connections with what becomes of values on the way: units of connectors, transformations of connections.

A value goes from the output of a component through connectors of systems and entries of dictionaries to an input. Each
connector may have a unit of its own, into which it is converted (SSP 1.0, section 5.3.4); each connection may transform
it after that, a linear transformation being in the unit it arrives in (SSP 2.0, section 4.5.5). The master knows what
becomes of it from end to end.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element

from cosim.errors import Refusals, SspError, suggestion
from cosim.scenario.ssp.document import plain_name, ssc
from cosim.scenario.ssp.topology import Link, Place, Topology
from cosim.system.conversion import unit_conversion
from cosim.system.description import Description, Match, Unit, compare, describe
from cosim.system.signals import Value
from cosim.system.structure import Connection, Port

log = logging.getLogger("cosim")

_PLAIN = ("ConnectionGeometry", "Annotations")
_LINEAR = "LinearTransformation"


@dataclass(frozen=True)
class Way:
    """Say what becomes of a value on its way.

    Attributes
    ----------
    unit : Unit or None
        That it has arrived in, as far as it is known.
    factor, offset : float
        Of numbers: the input gets factor times the output plus offset.
    table : mapping
        Of other values.
    converted : bool
        Whether units have been converted, or are not to be, so that nothing is left to do.
    """

    unit: Unit | None
    factor: float = 1.0
    offset: float = 0.0
    table: Mapping[Value, Value] = field(default_factory=dict[Value, Value])
    converted: bool = False

    @property
    def is_plain(self) -> bool:
        """Tell whether values arrive as they are."""
        return (self.factor, self.offset) == (1.0, 0.0) and not self.table

    def scaled(self, factor: float, offset: float, unit: Unit | None, *, converted: bool) -> Way:
        """Return the way with a factor and an offset more at its end."""
        return Way(unit, factor * self.factor, factor * self.offset + offset, self.table, converted)

    def mapped(self, table: Mapping[Value, Value]) -> Way:
        """Return the way with a table more at its end."""
        joined = {given: table.get(taken, taken) for given, taken in self.table.items()}
        joined |= {given: taken for given, taken in table.items() if given not in self.table}
        return Way(self.unit, self.factor, self.offset, joined, self.converted)

    def of(self, value: Value) -> Value:
        """Return what arrives."""
        if isinstance(value, float) or (isinstance(value, int) and not isinstance(value, bool) and not self.table):
            return value if self.is_plain else self.factor * value + self.offset
        return self.table.get(value, value)


@dataclass(frozen=True)
class Wiring:
    """Read which output drives which input.

    Attributes
    ----------
    topology : Topology
        The system, flat.
    descriptions : mapping of str to Description
        Of the components that could be read.
    units : mapping of str to Unit
        That the description of the system defines.
    refusals : Refusals
        What is wrong is noted there.
    """

    topology: Topology
    descriptions: Mapping[str, Description]
    units: Mapping[str, Unit]
    refusals: Refusals

    def read(self) -> tuple[tuple[Connection, ...], dict[Port, tuple[str, Way]]]:
        """Return connections between components, and the inputs that connectors of the whole system lead to.

        Of the latter the connector is given, and what becomes of a value on the way from there.
        """
        connections: list[Connection] = []
        from_outside: dict[Port, tuple[str, Way]] = {}
        for sink in self.topology.drivers:
            if sink.kind != "component" or sink.owner not in self.descriptions:
                continue
            with self.refusals.noted():
                source, links = self.topology.source_of(sink)
                target = Port(sink.owner, sink.name)
                self._check_connector(target)
                if source.kind == "system" and not source.owner:
                    from_outside[target] = source.name, self._way(sink, links)
                elif source.kind == "component" and source.owner in self.descriptions:
                    origin = Port(source.owner, source.name)
                    self._check_connector(origin)
                    connections.append(self._connection(origin, target, self._way(sink, links), links))
        return tuple(connections), from_outside

    def _connection(self, source: Port, target: Port, way: Way, links: Sequence[Link]) -> Connection:
        """Make a connection of a way; where the master converts the same units by itself, it is left to it."""
        own = [self.descriptions[port.component].by_name[port.variable].measured_in for port in (source, target)]
        suppressed = all(_is_suppressed(link.element) for link in links)
        if len(links) == 1 and not suppressed and compare(*own) is not Match.DIFFERENT:
            (link,) = links
            connectors = [self._unit_of(Place("component", port.component, port.variable)) for port in (source, target)]
            if connectors == own:
                factor, offset = _linear(link.element)
                return Connection(source, target, factor=factor, offset=offset, table=way.table)
        unconverted = suppressed or way.converted
        return Connection(
            source, target, unconverted=unconverted, factor=way.factor, offset=way.offset, table=way.table
        )

    def _way(self, sink: Place, links: Sequence[Link]) -> Way:
        """Follow a value from its source to an input."""
        start = links[-1].source
        way = Way(self._unit_of(start))
        if start.kind == "component":
            way = self._into(Way(self._own_unit(start)), way.unit, start, suppressed=False)
        for index in range(len(links) - 1, -1, -1):
            link = links[index]
            place = links[index - 1].source if index else sink
            way = self._into(way, self._unit_of(place), place, suppressed=_is_suppressed(link.element))
            way = self._transformed(way, link.element, place)
        return self._into(way, self._own_unit(sink), sink, suppressed=False)

    def _into(self, way: Way, unit: Unit | None, place: Place, *, suppressed: bool) -> Way:
        """Convert into the unit of a place, if it has one; a unit that is not known is taken for the one so far."""
        if suppressed:
            return Way(unit, way.factor, way.offset, way.table, converted=True)
        match = Match.UNKNOWN if unit is None else compare(way.unit, unit)
        if match is Match.DIFFERENT:
            raise SspError(
                f"{self.topology.where}: connection {self._origin(place)} -> {place} leads from {describe(way.unit)} "
                f"to {describe(unit)}; expected the same quantity"
            )
        if way.unit is not None and (match is Match.UNKNOWN or (unit is not None and unit.powers is None)):
            return way
        factor, offset = unit_conversion(way.unit, unit)
        return way.scaled(factor, offset, unit, converted=way.converted or (factor, offset) != (1.0, 0.0))

    def _origin(self, place: Place) -> Place:
        return self.topology.drivers[place].source if place in self.topology.drivers else place

    def _transformed(self, way: Way, connection: Element, place: Place) -> Way:
        """Apply the transformation of a connection, if it has one."""
        label = f"{self.topology.where}: connection {self._origin(place)} -> {place}"
        for child in connection:
            kind = plain_name(child.tag)
            if kind in _PLAIN:
                continue
            if kind == _LINEAR:
                way = way.scaled(*_linear(connection), way.unit, converted=way.converted)
            else:
                way = way.mapped(_table(child, kind, label))
        return way

    def _check_connector(self, port: Port) -> None:
        """Refuse a connector of no variable, or of one of another quantity; say where a unit is taken for another."""
        label, description = f"{self.topology.where}: connector {port}", self.descriptions[port.component]
        if port.variable not in description.by_name:
            hint = suggestion(port.variable, description.by_name)
            raise SspError(f"{label}: {description.model_name} has no variable of that name{hint}")
        place = Place("component", port.component, port.variable)
        own, unit = self._own_unit(place), self._declared(place)
        match = Match.SAME if own is None or unit is None else compare(unit, own)
        if match is Match.DIFFERENT:
            raise SspError(
                f"{label} is in {describe(unit)}, the FMU's variable in {describe(own)}; expected the same quantity"
            )
        if match in (Match.ASSUMED, Match.UNKNOWN):
            names = describe(unit), describe(own)
            log.warning("%s is in %s, the FMU's variable in %s; taken for the same", label, *names)

    def _own_unit(self, place: Place) -> Unit | None:
        """Return the unit of the FMU's variable."""
        return self.descriptions[place.owner].by_name[place.name].measured_in

    def _unit_of(self, place: Place) -> Unit | None:
        """Return the unit of a connector; of a component's, the FMU's where it declares none, or none that is known."""
        declared = self._declared(place)
        if place.kind != "component":
            return declared
        own = self._own_unit(place)
        known = declared is not None and compare(declared, own) in (Match.SAME, Match.SCALED, Match.DIFFERENT)
        return declared if own is None or known else own

    def _declared(self, place: Place) -> Unit | None:
        """Return the unit that a connector declares, if it is one and does."""
        element = self.topology.connectors.get(place)
        kind = element.find(ssc("Real")) if element is not None else None
        given = kind.get("unit") if kind is not None else None
        if given is None:
            return None
        unit = self.units.get(given, Unit(given))
        relative = place.kind == "component" and self.descriptions[place.owner].by_name[place.name].relative
        return unit.of_differences if relative else unit


def _is_suppressed(connection: Element) -> bool:
    return connection.get("suppressUnitConversion") in ("true", "1")


def _linear(connection: Element) -> tuple[float, float]:
    """Return factor and offset of a connection; 1 and 0 if it has none."""
    element = connection.find(ssc(_LINEAR))
    if element is None:
        return 1.0, 0.0
    return float(element.get("factor", "1")), float(element.get("offset", "0"))


def _table(transformation: Element, kind: str, label: str) -> dict[Value, Value]:
    """Read a transformation by a table."""
    read: Callable[[str], Value] = {"BooleanMappingTransformation": _boolean, "IntegerMappingTransformation": int}.get(
        kind, str
    )
    table: dict[Value, Value] = {}
    for entry in transformation:
        given, taken = read(str(entry.get("source"))), read(str(entry.get("target")))
        if table.setdefault(given, taken) != taken:
            raise SspError(f"{label}: its {kind} maps {given!r} twice; expected once")
    return table


def _boolean(text: str) -> bool:
    return text.strip() in ("true", "1")
