"""Read an .ssp file as a scenario; what is not supported is refused by name, all of it at once.

Supported are components that are FMUs within the archive, in systems nested to any depth, connections between them and
through connectors of systems and signal dictionaries, with units and transformations, and parameter bindings, inline or
external, with mappings, on components and systems.
"""

from __future__ import annotations

import math
import re
import tempfile
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path, PurePosixPath
from xml.etree.ElementTree import Element

from cosim.errors import InputError, Refusals, SspError
from cosim.fmi2.archive import open_archive
from cosim.fmi2.library import find_binary
from cosim.fmi2.model_description import read_description
from cosim.scenario.scenario import Scenario
from cosim.scenario.ssp.annotation import Remarks, read_remarks, stands_for_signals
from cosim.scenario.ssp.connections import Way, Wiring
from cosim.scenario.ssp.document import SspSource, open_source, read_document, ssd, without_proxy
from cosim.scenario.ssp.parameters import Given, component_values, read_bindings, read_units
from cosim.scenario.ssp.program import as_signals
from cosim.scenario.ssp.topology import Topology, read_topology
from cosim.system.description import Description
from cosim.system.structure import Component, Connection, System

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
        members: dict[str, str] = {}
        with _told_by_member(members):
            with open_source(path) as archive:
                scenario = _Reading(archive, Path(folder), members).scenario(stop_time, step_size)
            yield scenario


@contextmanager
def _told_by_member(members: Mapping[str, str]) -> Generator[None]:
    """Let refusals name FMUs as the archive does, and not by where they have been unpacked.

    `members` leads from the latter to the former, and may grow within the block.
    """
    try:
        yield
    except InputError as error:
        sentence = str(error)
        for place, member in members.items():
            sentence = sentence.replace(place, member)
        if sentence == str(error):
            raise
        raise type(error)(sentence) from error


class _Reading:
    """Read a description and all it needs, noting what is wrong on the way.

    Parameters
    ----------
    archive : SspSource
        Where it lies.
    folder : Path
        For FMUs.
    members : dict of str to str
        Takes what FMUs are called in the archive, by where they are unpacked.
    """

    def __init__(self, archive: SspSource, folder: Path, members: dict[str, str]) -> None:
        structure = archive.structure
        self._archive, self._folder, self._members = archive, folder, members
        self._where = structure if structure == archive.path.name else f"{archive.path.name}: {structure}"
        self._refusals = Refusals()
        self._fmus: dict[str, Path] = {}
        self._descriptions: dict[str, Description] = {}

    def scenario(self, stop_time: float | None, step_size: float | None) -> Scenario:
        """Return what the description says, or raise all that stops it."""
        root = read_document(
            self._archive.read(self._archive.structure), self._where, ssd("SystemStructureDescription")
        )
        remarks = Remarks(step_size=math.nan)  # what stands if they cannot be read
        with self._noted():
            remarks = read_remarks(root, self._where)
        start, stop, size = self._times(root, stop_time, step_size if step_size is not None else remarks.step_size)
        (whole,) = root.iterfind(ssd("System"))
        topology = read_topology(whole, self._where, self._refusals)
        components, connections = self._parts(root, whole, topology)
        self._raise_all()
        marked = [name for name, element in topology.components.items() if stands_for_signals(element)]
        with self._noted():
            system = System(components, connections)
            system = as_signals(system, {name: self._descriptions[name] for name in marked})
            return Scenario(
                name=remarks.name or self._archive.path.stem,
                system=replace(system, guards=remarks.guards, power_bonds=remarks.power_bonds),
                stop_time=stop,
                step_size=size,
                start_time=start,
                method=remarks.method,
                title=remarks.title or root.get("description", ""),
                description=remarks.description,
                signals=remarks.signals,
            )
        raise self._refusals.found[0]

    def _times(self, root: Element, stop_time: float | None, step_size: float | None) -> tuple[float, float, float]:
        """Return start time, stop time and step size [s]; what nobody gives is noted, with what would."""
        experiment = root.find(ssd("DefaultExperiment"))
        start, stop = (experiment.get(name) if experiment is not None else None for name in ("startTime", "stopTime"))
        if stop_time is None and stop is None:
            self._refuse(
                f"{self._where} has no DefaultExperiment with a stopTime; expected one from --stop-time, or stop_time "
                "in Python"
            )
        if step_size is None:
            self._refuse(
                f"{self._where}: SSP has no communication step size; expected one from --step-size, or step_size in "
                "Python"
            )
        end = stop_time if stop_time is not None else float(stop or "nan")
        return float(start or 0.0), end, math.nan if step_size is None else step_size

    def _parts(
        self, root: Element, whole: Element, topology: Topology
    ) -> tuple[tuple[Component, ...], tuple[Connection, ...]]:
        """Read components and connections."""
        for name, element in topology.components.items():
            with self._noted():
                self._fmus[name] = self._unpack(name, element)
                self._descriptions[name] = read_description(self._fmus[name])
        units = read_units(root.find(ssd("Units")))
        wiring = Wiring(topology, self._descriptions, units, self._refusals)
        connections, from_outside = wiring.read()
        driven = [connection.target for connection in connections]
        bindings = {id(system): self._bindings(system) for system in whole.iter(ssd("System"))}
        components: list[Component] = []
        for name, description in self._descriptions.items():
            bound = self._bindings(topology.components[name])
            inherited = _inherited(topology.enclosing[name], bindings)
            inherited |= {
                port.variable: _arrived(given, way)
                for port, (connector, way) in from_outside.items()
                if port.component == name and (given := bindings[id(whole)].get(connector)) is not None
            }
            with self._noted():
                values = component_values(name, description, bound, inherited, driven)
                _, isolate = without_proxy(str(topology.components[name].get("source")))
                components.append(Component(name, self._fmus[name], values, isolate))
        return tuple(components), connections

    def _bindings(self, element: Element) -> dict[str, Given]:
        """Read the parameter bindings of a component or system; none if something is wrong with them."""
        with self._noted():
            return read_bindings(self._archive, element, self._where)
        return {}

    def _unpack(self, label: str, component: Element) -> Path:
        """Put the FMU of a component into a folder, once for all components that share it."""
        source, _ = without_proxy(str(component.get("source")))
        name = self._archive.member(source, f"component {label}")
        file = PurePosixPath(name).name
        if not _FILE_NAME.fullmatch(file):
            raise SspError(f"{self._where}: component {label} is the file {name}; expected one that ends in .fmu")
        # a folder for each member, since two in different folders may have one name; its number, since names can be
        # hostile
        place = self._folder / str(self._archive.number(name))
        if not (place / file).exists():
            place.mkdir(exist_ok=True)
            self._archive.copy(name, place / file)
            self._members[str(place / file)] = f"{self._archive.path.name}: {name}"
        return place / file

    @contextmanager
    def _noted(self) -> Generator[None]:
        """Note what the block refuses, with the name of the file before it."""
        with self._refusals.noted():
            try:
                yield
            except SspError:
                raise
            except InputError as error:
                if any(place in str(error) for place in self._members):  # which becomes a member of the file
                    raise
                raise type(error)(f"{self._archive.path.name}: {error}") from error

    def _refuse(self, sentence: str) -> None:
        with self._refusals.noted():
            raise SspError(sentence)

    def _raise_all(self) -> None:
        """Raise what was noted, if anything was, and which FMUs could not be run here anyway."""
        if self._refusals.found:
            for name, description in self._descriptions.items():
                with self._refusals.noted(), open_archive(self._fmus[name]) as fmu:
                    find_binary(fmu, description.model_identifier)
        self._refusals.raise_all(SspError)


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


def _arrived(given: Given, way: Way) -> Given:
    """Return a value that is bound to a connector of the whole system as it comes to an input."""
    return given if way.is_plain else replace(given, value=way.of(given.value), unit=None)
