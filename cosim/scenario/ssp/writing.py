"""Write a scenario as an .ssp file, in the portable subset: connections between components, and nothing else.

Every input that a component declares is driven, every FMU and parameter set lies in `resources`, and nothing depends on
time or place: the same scenario gives the same bytes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import quote
from xml.etree.ElementTree import Element, SubElement

from cosim.errors import SspError
from cosim.fmi2.archive import pack, put_in_place
from cosim.fmi2.locate import locate_fmu
from cosim.fmi2.model_description import read_description
from cosim.scenario.scenario import Scenario
from cosim.scenario.ssp.annotation import add_scenario, mark_as_signals
from cosim.scenario.ssp.document import FMU_TYPE, PARAMETER_SET_TYPE, RESOURCES, STRUCTURE, ssc, ssd, write_document
from cosim.scenario.ssp.parameters import parameter_set
from cosim.scenario.ssp.program import as_components
from cosim.system.compatibility import check_system, read_written
from cosim.system.conversion import conversion_of
from cosim.system.description import BASE_UNITS, Description, Unit, Variable
from cosim.system.signals import Value
from cosim.system.structure import Component, Connection, Port, System

_ENDS = ("input", "output")


@dataclass(frozen=True)
class _Part:
    """A component with its FMU, the place of the FMU in the archive, and its start values."""

    component: Component
    description: Description
    source: str
    values: Mapping[str, Value]


def export_ssp(
    scenario: Scenario,
    path: Path,
    *,
    packaging: str = "native",
    variant: str | None = None,
    overrides: Mapping[str, Value] | None = None,
) -> None:
    """Write one variant of a scenario as an .ssp file.

    Parameters
    ----------
    scenario : Scenario
        From `cosim.load_scenario`, or made in Python.
    path : Path
        The file; folders above it are made, a file in its place is replaced.
    packaging : str
        ``"native"`` or ``"python"``: which build of the FMUs that are given by name.
    variant : str, optional
        Name of the variant; by default the first.
    overrides : mapping of str to value, optional
        Parameters and input values by ``component.variable``, on top of the variant's.

    Raises
    ------
    InputError
        If something asked for does not exist, does not fit, or cannot be said in SSP.
    OutputError
        If the file cannot be written.
    """
    chosen = scenario.variant(variant)
    system = scenario.system_of(chosen, overrides)
    name = f"{scenario.name}-{chosen.name}" if chosen else scenario.name
    files = ssp_files(replace(scenario, name=name, system=system, variants=()), packaging)
    put_in_place(path, pack(files, STRUCTURE))


def ssp_files(scenario: Scenario, packaging: str) -> dict[str, bytes]:
    """Return what goes into the archive, by name."""
    given = described(scenario.system, packaging, scenario.folder)
    system, marked = as_components(read_written(scenario.system, given))
    paths = {part.name: locate_fmu(part.fmu, packaging, scenario.folder) for part in system.components}
    descriptions = {name: read_description(fmu) for name, fmu in paths.items()}
    start_values = check_system(system, descriptions)
    sources = _sources(paths)
    parts = [
        _Part(part, descriptions[part.name], sources[part.name], _named(part.name, start_values[part.name]))
        for part in system.components
    ]
    files = {source: paths[name].read_bytes() for name, source in sources.items()}
    for part in parts:
        if part.values:
            files[_set_name(part)] = write_document(parameter_set(part.values, part.description))
    told = replace(scenario, signals=_recorded(scenario.signals, descriptions))
    return {STRUCTURE: write_document(_structure(told, system, parts, marked)), **files}


def _recorded(signals: Iterable[str], descriptions: Mapping[str, Description]) -> tuple[str, ...]:
    """Return what a figure can still show: a parameter that no signal drives is not recorded."""
    known = {Port(name, each.name): each for name, described in descriptions.items() for each in described.variables}
    return tuple(name for name in signals if name not in known or known[Port.parse(name)].causality != "parameter")


def described(system: System, packaging: str, folder: Path | None) -> dict[str, Description]:
    """Read the model descriptions of components by name."""
    return {part.name: read_description(locate_fmu(part.fmu, packaging, folder)) for part in system.components}


def _named(component: str, values: Mapping[Variable, Value]) -> dict[str, Value]:
    """Name start values by variable; refuse files, which would stay behind.

    Enumerations at the value they start from anyway are left out: libcosim stops at a parameter set that holds any.
    """
    for variable, value in values.items():
        if variable.type == "String" and isinstance(value, str) and Path(value).is_file():
            raise SspError(
                f"{component}.{variable.name} is the file {value}; expected no files, which an FMU does not find in SSP"
            )
    return {
        variable.name: value
        for variable, value in values.items()
        if variable.type != "Enumeration" or str(value) != variable.start
    }


def _sources(paths: Mapping[str, Path]) -> dict[str, str]:
    """Give each FMU a place in the archive; components with the same FMU share it."""
    places: dict[Path, str] = {}
    for path in paths.values():
        if path in places:
            continue
        count = sum(other.name == path.name for other in places)
        name = f"{path.stem}_{count + 1}{path.suffix}" if count else path.name
        places[path] = f"{RESOURCES}/{name}"
    return {name: places[path] for name, path in paths.items()}


def _set_name(part: _Part) -> str:
    """Return where the parameter set of a component lies; a name may hold what a path cannot."""
    return f"{RESOURCES}/{quote(part.component.name, safe='')}.ssv"


def _structure(scenario: Scenario, system: System, parts: list[_Part], marked: frozenset[str]) -> Element:
    """Make the description of the system."""
    root = Element(ssd("SystemStructureDescription"), version="1.0", name=scenario.name)
    root.set("generationTool", "cosim")
    if scenario.title:
        root.set("description", scenario.title)
    whole = SubElement(root, ssd("System"), name=scenario.name)
    elements = SubElement(whole, ssd("Elements"))
    driven = {connection.target for connection in system.connections}
    units = _units(parts)
    for part in parts:
        component = _add_component(elements, part, driven, units)
        if part.component.name in marked:
            mark_as_signals(component)
    if system.connections:
        connections = SubElement(whole, ssd("Connections"))
        for connection in system.connections:
            _add_transformation(SubElement(connections, ssd("Connection"), _ends(connection)), connection, parts)
    if units:
        _add_units(SubElement(root, ssd("Units")), units.values())
    times = {"startTime": repr(scenario.start_time), "stopTime": repr(scenario.stop_time)}
    SubElement(root, ssd("DefaultExperiment"), times)
    add_scenario(root, scenario)
    return root


def _shown(part: _Part, driven: set[Port]) -> list[Variable]:
    """Return the variables of a component that are connectors: outputs, and inputs that are driven."""
    name = part.component.name
    return [
        variable
        for variable in part.description.variables
        if variable.causality == "output" or Port(name, variable.name) in driven
    ]


def _units(parts: list[_Part]) -> dict[str, Unit]:
    """Return the units that connectors can be said to be in, by name: those that all FMUs define alike.

    A connector without a unit has that of its variable, so that nothing is lost where one cannot be said.
    """
    every = [variable.unit for part in parts for variable in part.description.variables if variable.causality in _ENDS]
    found = {unit.name: unit for unit in every if unit is not None and unit.powers is not None}
    clashing = {unit.name for unit in every if unit is not None and found.get(unit.name, unit) != unit}
    return {name: unit for name, unit in sorted(found.items()) if name not in clashing}


def _add_units(element: Element, units: Iterable[Unit]) -> None:
    """Define units by their base units, what is usual left out."""
    for unit in units:
        powers = {name: str(power) for name, power in zip(BASE_UNITS, unit.powers or (), strict=False) if power}
        scale = {"factor": unit.factor, "offset": unit.offset}
        usual = {"factor": 1.0, "offset": 0.0}
        powers |= {name: repr(value) for name, value in scale.items() if value != usual[name]}
        SubElement(SubElement(element, ssc("Unit"), name=unit.name), ssc("BaseUnit"), powers)


def _add_component(elements: Element, part: _Part, driven: set[Port], units: Mapping[str, Unit]) -> Element:
    """Describe a component: its outputs, the inputs that are driven, with their units, and where its parameters are."""
    name = part.component.name
    component = SubElement(elements, ssd("Component"), name=name, type=FMU_TYPE, source=quote(part.source))
    component.set("implementation", "CoSimulation")
    shown = _shown(part, driven)
    if shown:
        connectors = SubElement(component, ssd("Connectors"))
        for variable in shown:
            connector = SubElement(connectors, ssd("Connector"), name=variable.name, kind=variable.causality)
            if variable.type != "Enumeration":  # which would have to be defined once more
                kind = SubElement(connector, ssc(variable.type))
                if variable.type == "Real" and variable.unit is not None and variable.unit.name in units:
                    kind.set("unit", variable.unit.name)
    if part.values:
        bindings = SubElement(component, ssd("ParameterBindings"))
        SubElement(bindings, ssd("ParameterBinding"), type=PARAMETER_SET_TYPE, source=quote(_set_name(part)))
    return component


def _ends(connection: Connection) -> dict[str, str]:
    """Write a connection as attributes."""
    source, target = connection.source, connection.target
    ends = {
        "startElement": source.component,
        "startConnector": source.variable,
        "endElement": target.component,
        "endConnector": target.variable,
    }
    return {**ends, "suppressUnitConversion": "true"} if connection.unconverted else ends


def _add_transformation(element: Element, connection: Connection, parts: list[_Part]) -> None:
    """Say what becomes of the values of a connection, units apart."""
    if (connection.factor, connection.offset) != (1.0, 0.0):
        scale = {"factor": repr(connection.factor), "offset": repr(connection.offset)}
        SubElement(element, ssc("LinearTransformation"), scale)
    if not connection.table:
        return
    descriptions = {part.component.name: part.description for part in parts}
    conversion = conversion_of(connection, descriptions)
    source = descriptions[connection.source.component].by_name[connection.source.variable]
    kind, write = ("Boolean", _truth) if source.type == "Boolean" else ("Integer", str)
    table = SubElement(element, ssc(f"{kind}MappingTransformation"))
    for given, taken in conversion.table if conversion is not None else ():
        SubElement(table, ssc("MapEntry"), source=write(given), target=write(taken))


def _truth(number: int) -> str:
    return "true" if number else "false"
