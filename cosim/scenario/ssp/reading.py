"""Read an .ssp file as a scenario; what is not supported is refused by name.

Supported are components that are FMUs within the archive, in systems nested to any depth, connections between them and
through connectors of systems and signal dictionaries, and parameter bindings, inline or external, with mappings, on
components and systems. Transformations on connections are not, and units are not converted on them.
"""

from __future__ import annotations

import logging
import re
import tempfile
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path, PurePosixPath
from xml.etree.ElementTree import Element

from cosim.errors import InputError, SspError, suggestion
from cosim.fmi2.model_description import read_description
from cosim.scenario.scenario import Scenario
from cosim.scenario.ssp.annotation import read_remarks, stands_for_signals
from cosim.scenario.ssp.document import (
    SspSource,
    open_source,
    read_document,
    ssc,
    ssd,
)
from cosim.scenario.ssp.parameters import Given, component_values, read_bindings, read_units
from cosim.scenario.ssp.program import as_signals
from cosim.scenario.ssp.topology import Topology, read_topology
from cosim.system.description import Description, Match, Unit, compare, describe
from cosim.system.structure import Component, Connection, Port, System

_FILE_NAME = re.compile(r"[^/\\:\0-\x1f]+\.fmu")


@contextmanager
def open_ssp(
    path: str | Path, *, stop_time: float | None = None, step_size: float | None = None
) -> Generator[Scenario]:
    """Read an .ssp file, or an unpacked .ssd; its FMUs lie in a temporary folder until the block is left.

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
        with open_source(path) as archive:
            try:
                scenario = _scenario(archive, Path(folder), stop_time, step_size)
            except SspError:
                raise
            except InputError as error:
                raise type(error)(f"{path.name}: {error}") from error
        yield scenario


def _scenario(archive: SspSource, folder: Path, stop_time: float | None, step_size: float | None) -> Scenario:
    """Read a description and all it needs."""
    structure = archive.structure
    where = structure if structure == archive.path.name else f"{archive.path.name}: {structure}"
    root = read_document(archive.read(structure), where, ssd("SystemStructureDescription"))
    remarks = read_remarks(root, where)
    experiment = root.find(ssd("DefaultExperiment"))
    start, stop = (experiment.get(name) if experiment is not None else None for name in ("startTime", "stopTime"))
    stop_time = stop_time if stop_time is not None or stop is None else float(stop)
    step_size = step_size if step_size is not None else remarks.step_size
    if stop_time is None:
        raise SspError(
            f"{where} has no DefaultExperiment with a stopTime; expected one from --stop-time, or stop_time in Python"
        )
    if step_size is None:
        raise SspError(
            f"{where}: SSP has no communication step size; expected one from --step-size, or step_size in Python"
        )
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


def _system(archive: SspSource, root: Element, folder: Path, where: str) -> System:
    """Read components and connections."""
    (whole,) = root.iterfind(ssd("System"))
    topology = read_topology(whole, where)
    fmus = {name: _unpack(archive, name, element, folder, where) for name, element in topology.components.items()}
    descriptions = {name: read_description(fmu) for name, fmu in fmus.items()}
    units = read_units(root.find(ssd("Units")))
    connections, from_outside = _connections(topology, descriptions, units)
    driven = [connection.target for connection in connections]
    bindings = {id(system): read_bindings(archive, system, where) for system in whole.iter(ssd("System"))}
    components: list[Component] = []
    for name, element in topology.components.items():
        bound = read_bindings(archive, element, where)
        inherited = _inherited(topology.enclosing[name], bindings)
        inherited |= {
            port.variable: given
            for port, connector in from_outside.items()
            if port.component == name and (given := bindings[id(whole)].get(connector)) is not None
        }
        values = component_values(name, descriptions[name], bound, inherited, driven)
        components.append(Component(name, fmus[name], values))
    system = System(tuple(components), connections)
    marked = [name for name, element in topology.components.items() if stands_for_signals(element)]
    return as_signals(system, {name: descriptions[name] for name in marked})


def _inherited(
    enclosing: Sequence[tuple[str, Element]], bindings: Mapping[int, Mapping[str, Given]]
) -> dict[str, Given]:
    """Return what the systems around a component give it, by variable; those further out take precedence."""
    values: dict[str, Given] = {}
    for name, system in enclosing:
        prefix = f"{name}."
        bound = bindings[id(system)].items()
        values |= {key.removeprefix(prefix): given for key, given in bound if key.startswith(prefix)}
    return values


def _unpack(archive: SspSource, label: str, component: Element, folder: Path, where: str) -> Path:
    """Put the FMU of a component into a folder, once for all components that share it."""
    name = archive.member(str(component.get("source")), f"component {label}")
    file = PurePosixPath(name).name
    if not _FILE_NAME.fullmatch(file):
        raise SspError(f"{where}: component {label} is the file {name}; expected one that ends in .fmu")
    # a folder for each member, since two in different folders may have one name; its number, since names can be hostile
    place = folder / str(archive.number(name))
    if not (place / file).exists():
        place.mkdir()
        archive.copy(name, place / file)
    return place / file


log = logging.getLogger("cosim")

_CLASHES = (Match.DIFFERENT, Match.SCALED)


def _connections(
    topology: Topology, descriptions: Mapping[str, Description], units: Mapping[str, Unit]
) -> tuple[tuple[Connection, ...], dict[Port, str]]:
    """Return the connections between components, and the inputs that connectors of the whole system lead to.

    Raises
    ------
    SspError
        If a connector is of no variable, or its value would have to be converted.
    """
    connections: list[Connection] = []
    from_outside: dict[Port, str] = {}
    for sink in topology.drivers:
        if sink.kind != "component":
            continue
        source, way = topology.source_of(sink)
        target = Port(sink.owner, sink.name)
        _check_connector(topology, target, descriptions, units)
        if source.kind == "system" and not source.owner:
            from_outside[target] = source.name
        if source.kind != "component":
            continue
        origin = Port(source.owner, source.name)
        _check_connector(topology, origin, descriptions, units)
        given, wanted = (_unit_of(topology, port, descriptions, units) for port in (origin, target))
        unconverted = all(element.get("suppressUnitConversion") in ("true", "1") for element in way)
        if compare(given, wanted) in _CLASHES and not unconverted:
            raise SspError(
                f"{topology.where}: connection {origin} -> {target} leads from {describe(given)} to "
                f"{describe(wanted)}; conversion of units is not supported"
            )
        connections.append(Connection(origin, target, unconverted=unconverted))
    return tuple(connections), from_outside


def _check_connector(
    topology: Topology, port: Port, descriptions: Mapping[str, Description], units: Mapping[str, Unit]
) -> None:
    """Refuse a connector of no variable, or of one in another unit."""
    label, description = f"{topology.where}: connector {port}", descriptions[port.component]
    if port.variable not in description.by_name:
        hint = suggestion(port.variable, description.by_name)
        raise SspError(f"{label}: {description.model_name} has no variable of that name{hint}")
    own = description.by_name[port.variable].measured_in
    unit = _unit_of(topology, port, descriptions, units)
    match = Match.SAME if own is None or unit is None else compare(unit, own)
    if match in _CLASHES:
        raise SspError(
            f"{label} is in {describe(unit)}, the FMU's variable in {describe(own)}; "
            "conversion of units is not supported"
        )
    if match is not Match.SAME:
        log.warning("%s is in %s, the FMU's variable in %s; taken for the same", label, describe(unit), describe(own))


def _unit_of(
    topology: Topology, port: Port, descriptions: Mapping[str, Description], units: Mapping[str, Unit]
) -> Unit | None:
    """Return the unit of a connector: its own or, if it has none, that of the FMU's variable."""
    variable = descriptions[port.component].by_name[port.variable]
    for element in topology.components[port.component].iterfind(f"{ssd('Connectors')}/{ssd('Connector')}"):
        kind = element.find(ssc("Real"))
        given = kind.get("unit") if kind is not None else None
        if element.get("name") == port.variable and given is not None:
            unit = units.get(given, Unit(given))
            return unit.of_differences if variable.relative else unit
    return variable.measured_in
