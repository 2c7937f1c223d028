"""Read an .ssp file as a scenario; what is not supported is refused by name.

Supported are components that are FMUs within the archive, connections between them, and parameter bindings, inline or
external, on components or on the system. Nested systems, connectors of the system, signal dictionaries, parameter
mappings and transformations are not.
"""

from __future__ import annotations

import logging
import re
import tempfile
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from xml.etree.ElementTree import Element

from cosim.errors import InputError, SspError, suggestion
from cosim.fmi2.model_description import read_description
from cosim.scenario.scenario import Scenario
from cosim.scenario.ssp.annotation import read_remarks, stands_for_signals
from cosim.scenario.ssp.document import (
    FMU_TYPE,
    STRUCTURE,
    SspArchive,
    open_archive,
    plain_name,
    read_document,
    ssc,
    ssd,
)
from cosim.scenario.ssp.parameters import component_values, read_bindings, read_units
from cosim.scenario.ssp.program import as_signals
from cosim.system.description import Description, Match, Unit, compare, describe
from cosim.system.structure import Component, Connection, Port, System

_FILE_NAME = re.compile(r"[^/\\:\0-\x1f]+\.fmu")


@contextmanager
def open_ssp(
    path: str | Path, *, stop_time: float | None = None, step_size: float | None = None
) -> Generator[Scenario]:
    """Read an .ssp file; its FMUs lie in a temporary folder until the block is left.

    Parameters
    ----------
    path : str or Path
        The file.
    stop_time, step_size : float, optional
        In s, instead of the file's; needed where the file does not give them.

    Yields
    ------
    Scenario
        What the file describes, to be given to `cosim.simulate`.

    Raises
    ------
    SspError
        If the file is damaged, breaks the standard, or holds what is not supported.
    InputError
        If its parts contradict each other.
    """
    path = Path(path)
    with tempfile.TemporaryDirectory(prefix="cosim-ssp-") as folder:
        with open_archive(path) as archive:
            try:
                scenario = _scenario(archive, Path(folder), stop_time, step_size)
            except SspError:
                raise
            except InputError as error:
                raise type(error)(f"{path.name}: {error}") from error
        yield scenario


def _scenario(archive: SspArchive, folder: Path, stop_time: float | None, step_size: float | None) -> Scenario:
    """Read a description and all it needs."""
    where = f"{archive.path.name}: {STRUCTURE}"
    root = read_document(archive.read(STRUCTURE), where, ssd("SystemStructureDescription"))
    remarks = read_remarks(root, where)
    experiment = root.find(ssd("DefaultExperiment"))
    start, stop = (experiment.get(name) if experiment is not None else None for name in ("startTime", "stopTime"))
    stop_time = stop_time if stop_time is not None or stop is None else float(stop)
    step_size = step_size if step_size is not None else remarks.step_size
    if stop_time is None:
        raise SspError(f"{where} has no DefaultExperiment with a stopTime; expected a stop time to be given")
    if step_size is None:
        raise SspError(f"{where}: SSP has no communication step size; expected one to be given")
    return Scenario(
        name=remarks.name or archive.path.stem,
        system=replace(_system(archive, root, folder, where), guards=remarks.guards, power_bonds=remarks.power_bonds),
        stop_time=stop_time,
        step_size=step_size,
        start_time=float(start) if start is not None else 0.0,
        method=remarks.method,
        title=remarks.title or root.get("description", ""),
        description=remarks.description,
        signals=remarks.signals,
    )


def _system(archive: SspArchive, root: Element, folder: Path, where: str) -> System:
    """Read components and connections."""
    (whole,) = root.iterfind(ssd("System"))
    elements = _components(whole, where)
    fmus = {name: _unpack(archive, element, folder, where) for name, element in elements.items()}
    descriptions = {name: read_description(fmu) for name, fmu in fmus.items()}
    connectors = {name: read_connectors(root, element, descriptions[name], where) for name, element in elements.items()}
    connections = read_connections(whole, connectors, where)
    driven = [connection.target for connection in connections]
    above = read_bindings(archive, whole, where)
    components: list[Component] = []
    for name, element in elements.items():
        bound = read_bindings(archive, element, where)
        values = component_values(name, descriptions[name], bound, above, driven)
        components.append(Component(name, fmus[name], values))
    system = System(tuple(components), connections)
    marked = [name for name, element in elements.items() if stands_for_signals(element)]
    return as_signals(system, {name: descriptions[name] for name in marked})


def _components(whole: Element, where: str) -> dict[str, Element]:
    """Return the components by name; refuse what else a system may hold."""
    for connector in whole.iterfind(f"{ssd('Connectors')}/{ssd('Connector')}"):
        raise SspError(f"{where}: the system has a connector, {connector.get('name')}; none are supported")
    if whole.find(ssd("SignalDictionaries")) is not None:
        raise SspError(f"{where}: the system has signal dictionaries; none are supported")
    components: dict[str, Element] = {}
    for element in whole.iterfind(f"{ssd('Elements')}/*"):
        name, kind = str(element.get("name")), plain_name(element.tag)
        if kind != "Component":
            raise SspError(f"{where}: {name} is a {kind}; only components are supported")
        if element.get("type", FMU_TYPE) != FMU_TYPE:
            raise SspError(f"{where}: component {name} has the type {element.get('type')}; expected {FMU_TYPE}")
        if element.get("implementation") == "ModelExchange":
            raise SspError(f"{where}: component {name} is to be used by model exchange; expected co-simulation")
        if "." in name:
            raise SspError(f"{where}: component {name} has a dot in its name; expected none")
        if name in components:
            raise SspError(f"{where}: two components are called {name}; expected each name once")
        components[name] = element
    return components


def _unpack(archive: SspArchive, component: Element, folder: Path, where: str) -> Path:
    """Put the FMU of a component into a folder, once for all components that share it."""
    name = archive.member(str(component.get("source")), f"component {component.get('name')}")
    file = PurePosixPath(name).name
    if not _FILE_NAME.fullmatch(file):
        raise SspError(f"{where}: component {component.get('name')} is the file {name}; expected one that ends in .fmu")
    # a folder for each member, since two in different folders may have one name; its number, since names can be hostile
    place = folder / str(archive.number(name))
    if not (place / file).exists():
        place.mkdir()
        archive.copy(name, place / file)
    return place / file


log = logging.getLogger("cosim")

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
        own = variable.measured_in
        unit = units.get(given, Unit(given)) if given is not None else own
        unit = unit.of_differences if unit is not None and variable.relative else unit
        match = Match.SAME if own is None or unit is None else compare(unit, own)
        if match in _CLASHES:
            raise SspError(
                f"{label} is in {describe(unit)}, the FMU's variable in {describe(own)}; "
                "conversion of units is not supported"
            )
        if match is not Match.SAME:
            log.warning(
                "%s is in %s, the FMU's variable in %s; taken for the same", label, describe(unit), describe(own)
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
    (first, second) = (_connector(port, connectors) for port in (start, end))
    unconverted = element.get("suppressUnitConversion") in ("true", "1")
    if compare(first.unit, second.unit) in _CLASHES and not unconverted:
        raise SspError(
            f"{label} leads from {describe(first.unit)} to {describe(second.unit)}; conversion of units is not "
            "supported"
        )
    if (first.kind, second.kind) == ("input", "output"):
        return Connection(end, start, unconverted=unconverted)
    if (first.kind, second.kind) != ("output", "input"):
        raise SspError(f"{label} leads from {first.kind} to {second.kind}; expected an output and an input")
    return Connection(start, end, unconverted=unconverted)


def _end(element: Element, side: str, connectors: Mapping[str, Mapping[str, Connector]], where: str) -> Port:
    """Return the port of one end."""
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
    return Port(component, name)


def _connector(port: Port, connectors: Mapping[str, Mapping[str, Connector]]) -> Connector:
    """Find the connector of a port."""
    return connectors[port.component][port.variable]
