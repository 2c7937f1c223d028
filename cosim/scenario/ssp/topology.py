"""Flatten a system of SSP: find the components within nested systems, and which output drives which input.

A connection of SSP ends at a connector of a component, of a nested system, of the system it stands in, or at an entry
of a signal dictionary. A connector of a system is an input from outside and a source within, or the other way round; an
entry of a dictionary is both, wherever it is referred to (SSP 1.0, sections 5.2 and 5.6). What the master couples are
components, so every input is traced back to the component whose output it is in the end.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple
from xml.etree.ElementTree import Element

from cosim.errors import Refusals, SspError, suggestion
from cosim.scenario.ssp.document import FMU_TYPE, plain_name, ssd

_SOURCES = ("output", "calculatedParameter")


class Place(NamedTuple):
    """A place that a value passes: a connector of a component or a system, or an entry of a dictionary."""

    kind: str
    owner: str
    name: str

    def __str__(self) -> str:
        """Write it as in a message."""
        return f"{self.owner}.{self.name}" if self.owner else self.name


class _End(NamedTuple):
    """An end of a connection: where it is, and whether it is a source within its system; None if it may be either."""

    place: Place
    source: bool | None
    kind: str


@dataclass(frozen=True)
class Link:
    """Say what drives a place: the source of its value, and the element Connection that leads from it."""

    source: Place
    element: Element


@dataclass
class Topology:
    """A system with all that is nested in it, flat.

    Attributes
    ----------
    components : dict of str to Element
        ssd:Component by name; that of one within nested systems has their names before it, as ``drive/motor``.
    enclosing : dict of str to tuple
        By component, the systems around it from the inside out, each with the component's name as seen from there, with
        dots.
    drivers : dict of Place to Link
        What drives each place that something drives.
    connectors : dict of Place to Element
        ssd:Connector, of components and systems.
    """

    where: str
    components: dict[str, Element] = field(default_factory=dict[str, Element])
    enclosing: dict[str, tuple[tuple[str, Element], ...]] = field(
        default_factory=dict[str, tuple[tuple[str, Element], ...]]
    )
    drivers: dict[Place, Link] = field(default_factory=dict[Place, Link])
    connectors: dict[Place, Element] = field(default_factory=dict[Place, Element])

    def source_of(self, place: Place) -> tuple[Place, tuple[Link, ...]]:
        """Follow a place back to where its value comes from, and return that with the connections on the way.

        Raises
        ------
        SspError
            If the way leads back to where it has been.
        """
        way: list[Link] = []
        seen = {place}
        while place in self.drivers:
            link = self.drivers[place]
            way.append(link)
            place = link.source
            if place in seen:
                raise SspError(f"{self.where}: connections lead from {place} back to it through connectors of systems")
            seen.add(place)
            if place.kind == "component":
                break
        return place, tuple(way)


def read_topology(whole: Element, where: str, refusals: Refusals) -> Topology:
    """Read a system and what is nested in it.

    What is wrong is noted: an element that cannot be run, a name given twice, an end of a connection that does not
    exist or does not fit.

    Parameters
    ----------
    whole : Element
        ssd:System.
    where : str
        File it is from, for messages.
    refusals : Refusals
        Takes what is wrong.
    """
    topology = Topology(where)
    _System(topology, refusals, whole, (), ()).read()
    return topology


class _System:
    """One system while it is read.

    Parameters
    ----------
    topology : Topology
        Where it is read into.
    refusals : Refusals
        Takes what is wrong.
    element : Element
        ssd:System.
    path : tuple of str
        Names of the systems that lead to it, its own included, but for the outermost.
    around : tuple of _System
        The systems around it, from the outside in.
    """

    def __init__(
        self,
        topology: Topology,
        refusals: Refusals,
        element: Element,
        path: tuple[str, ...],
        around: tuple[_System, ...],
    ) -> None:
        self.element, self.path, self._refusals = element, path, refusals
        self._topology, self._around = topology, around
        self._where = topology.where
        self.dictionaries = {
            str(each.get("name")) for each in element.iterfind(f"{ssd('SignalDictionaries')}/{ssd('SignalDictionary')}")
        }
        self._elements: dict[str, Element] = {}
        self.connectors = _connectors(element)
        self._keep_connectors("system", "/".join(path), element)

    def read(self) -> None:
        """Read elements, then connections."""
        for element in self.element.iterfind(f"{ssd('Elements')}/*"):
            with self._refusals.noted():
                self._read_element(element)
        for connection in self.element.iterfind(f"{ssd('Connections')}/{ssd('Connection')}"):
            with self._refusals.noted():
                self._read_connection(connection)

    def _read_element(self, element: Element) -> None:
        name, kind = str(element.get("name")), plain_name(element.tag)
        if "." in name:
            raise SspError(f"{self._where}: component {name} has a dot in its name; expected none")
        if name in self._elements:
            raise SspError(f"{self._where}: two components are called {self._flat(name)}; expected each name once")
        self._elements[name] = element
        if kind == "System":
            _System(self._topology, self._refusals, element, (*self.path, name), (*self._around, self)).read()
        elif kind == "Component":
            self._read_component(name, element)
        elif kind != "SignalDictionaryReference":
            raise SspError(f"{self._where}: {name} is a {kind}; expected a component or a system")

    def _read_component(self, name: str, element: Element) -> None:
        flat = self._flat(name)
        if element.get("type", FMU_TYPE) != FMU_TYPE:
            raise SspError(f"{self._where}: component {flat} has the type {element.get('type')}; expected {FMU_TYPE}")
        if element.get("implementation") == "ModelExchange":
            raise SspError(f"{self._where}: component {flat} is to be used by model exchange; expected co-simulation")
        self._topology.components[flat] = element
        self._keep_connectors("component", flat, element)
        inside_out = (self, *reversed(self._around))
        self._topology.enclosing[flat] = tuple(
            (".".join((*self.path[len(system.path) :], name)), system.element) for system in inside_out
        )

    def _read_connection(self, element: Element) -> None:
        start, end = self._end(element, "start"), self._end(element, "end")
        label = f"{self._where}: connection {start.place} -> {end.place}"
        first = (not end.source if end.source is not None else True) if start.source is None else start.source
        second = not first if end.source is None else end.source
        if first == second:
            raise SspError(f"{label} leads from {start.kind} to {end.kind}; expected an output and an input")
        source, sink = (start.place, end.place) if first else (end.place, start.place)
        if sink in self._topology.drivers:
            other = self._topology.drivers[sink].source
            raise SspError(f"{self._where}: {sink} is driven by {other} and by {source}; expected one of them")
        self._topology.drivers[sink] = Link(source, element)

    def _keep_connectors(self, kind: str, owner: str, element: Element) -> None:
        """Keep the connectors of a component or system by where they are."""
        for each in element.iterfind(f"{ssd('Connectors')}/{ssd('Connector')}"):
            self._topology.connectors[Place(kind, owner, str(each.get("name")))] = each

    def _end(self, connection: Element, side: str) -> _End:
        """Find one end of a connection."""
        name, owner = connection.get(f"{side}Connector", ""), connection.get(f"{side}Element")
        if not owner:
            if name not in self.connectors:
                hint = suggestion(name, self.connectors)
                what = f"the system {'/'.join(self.path)}" if self.path else "the system"
                raise SspError(f"{self._where}: a connection leads to {name}, but {what} has no such connector{hint}")
            kind = self.connectors[name]
            return _End(Place("system", "/".join(self.path), name), kind not in _SOURCES, kind)
        if owner not in self._elements:
            hint = suggestion(owner, self._elements)
            address = f"{self._flat(owner)}.{name}"
            raise SspError(
                f"{self._where}: a connection leads to {address}, but there is no component of that name{hint}"
            )
        return self._end_at(owner, name)

    def _end_at(self, owner: str, name: str) -> _End:
        """Find an end at a connector of an element."""
        element = self._elements[owner]
        kind = plain_name(element.tag)
        if kind == "SignalDictionaryReference":
            return _End(
                Place("dictionary", self._dictionary(owner, str(element.get("dictionary"))), name), None, "entry"
            )
        connectors = _connectors(element)
        if name not in connectors:
            hint = suggestion(name, connectors)
            address = f"{self._flat(owner)}.{name}"
            raise SspError(f"{self._where}: a connection leads to {address}, which has no such connector{hint}")
        direction = connectors[name]
        place = Place("system" if kind == "System" else "component", self._flat(owner), name)
        return _End(place, direction in _SOURCES, direction)

    def _dictionary(self, reference: str, name: str) -> str:
        """Return the full name of the dictionary that a reference means: the nearest of that name."""
        for system in (self, *reversed(self._around)):
            if name in system.dictionaries:
                return "/".join((*system.path, name))
        known = sorted({each for system in (self, *self._around) for each in system.dictionaries})
        hint = suggestion(name, known)
        raise SspError(
            f"{self._where}: {self._flat(reference)} refers to the signal dictionary {name}, which is not there{hint}"
        )

    def _flat(self, name: str) -> str:
        """Return the name of an element of this system, with the systems that lead to it."""
        return "/".join((*self.path, name))


def _connectors(element: Element) -> Mapping[str, str]:
    """Return the kinds of the connectors of a component or system by name."""
    found = element.iterfind(f"{ssd('Connectors')}/{ssd('Connector')}")
    return {str(each.get("name")): str(each.get("kind")) for each in found}
