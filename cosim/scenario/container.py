"""Write a whole system as one FMU, by the containers of the FMU Manipulation Toolbox.

A container holds the FMUs and couples them in steps of its own, by Jacobi's or the Gauss-Seidel algorithm. It cannot
save its state, and starts a loop through direct feedthrough from zero, without settling it first.
"""

from __future__ import annotations

import logging
import re
import shutil
import tempfile
import xml.etree.ElementTree as ElementTree
import zipfile
from collections import Counter
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from cosim.errors import InputError, require
from cosim.fmi2.archive import pack, put_in_place
from cosim.fmi2.locate import locate_fmu
from cosim.fmi2.model_description import read_description
from cosim.scenario.scenario import Scenario
from cosim.scenario.ssp.program import as_components
from cosim.scenario.ssp.writing import described
from cosim.system.compatibility import check_system, read_written
from cosim.system.conversion import conversion_of
from cosim.system.dependency import feedthrough_loops, stepping_order
from cosim.system.description import BASE_UNITS, Description, Unit
from cosim.system.signals import Value
from cosim.system.structure import System

log = logging.getLogger("cosim")

_SEQUENTIAL = {"jacobi": False, "gauss-seidel": True}
_DESCRIPTION = "modelDescription.xml"
_OF_THE_MOMENT = ("guid", "generationDateAndTime", "author", "license", "copyright")


def container_files(scenario: Scenario, identifier: str, packaging: str) -> dict[str, bytes]:
    """Return the content of a container FMU, by name within it.

    Constant signals and inputs that nothing drives become inputs of the container, named ``variable``, or
    ``component.variable`` where two have one name; signals that change become components. Outputs are named
    ``component.variable``.

    Parameters
    ----------
    scenario : Scenario
        Without variants; step size and algorithm become the container's own.
    identifier : str
        Model identifier, a name as in C.
    packaging : str
        ``"native"`` or ``"python"``: which build of the FMUs that are given by name.

    Raises
    ------
    InputError
        If the algorithm is not one of a container's, steps are to vary in size, or it cannot hold the system.
    """
    algorithm = scenario.method.algorithm
    if algorithm not in _SEQUENTIAL:
        known = " or ".join(_SEQUENTIAL)
        raise InputError(f"a container couples by {known}; the algorithm is {algorithm}")
    if scenario.method.tolerance is not None:
        raise InputError(f"a container takes steps of one size; the tolerance is {scenario.method.tolerance:g}")
    given = described(scenario.system, packaging, scenario.folder)
    system = _without_signals(read_written(scenario.system, given))
    paths = {part.name: locate_fmu(part.fmu, packaging, scenario.folder) for part in system.components}
    descriptions = {name: read_description(path) for name, path in paths.items()}
    start_values = check_system(system, descriptions)
    _warn_of_loops(system, descriptions)
    order = stepping_order(system, descriptions, _order(scenario, system))
    with _toolbox() as toolbox, tempfile.TemporaryDirectory(prefix="cosim-container-") as folder:
        container = toolbox.FMUContainer(identifier, folder, fmi_version=2)
        container.start_time, container.stop_time = scenario.start_time, scenario.stop_time
        # Not the names of the components: the toolbox names what is linked inside after these, and outputs have those.
        inside = {name: f"{name}_{place}" for place, name in enumerate(order)}
        for name, given in inside.items():
            shutil.copyfile(paths[name], Path(folder, f"{given}.fmu"))
            container.get_fmu(f"{given}.fmu", name=given)
            for variable, value in start_values[name].items():
                container.add_start_value(given, variable.name, value if isinstance(value, bool) else str(value))
        units = _expose(container, system, descriptions, inside)
        container.make_fmu(f"{identifier}.fmu", step_size=scenario.step_size, sequential=_SEQUENTIAL[algorithm])
        with zipfile.ZipFile(Path(folder, f"{identifier}.fmu")) as archive:
            files = {name: archive.read(name) for name in archive.namelist()}
    return _finished(files, scenario.title or scenario.name, units)


def export_container(
    scenario: Scenario,
    path: Path,
    *,
    packaging: str = "native",
    variant: str | None = None,
    overrides: Mapping[str, Value] | None = None,
) -> None:
    """Write one variant of a scenario as one FMU; arguments and errors are those of `ssp.writing.export_ssp`."""
    system = scenario.system_of(scenario.variant(variant), overrides)
    identifier = re.sub(r"\W", "_", path.stem, flags=re.ASCII)
    identifier = identifier if not identifier[:1].isdigit() else f"_{identifier}"
    files = container_files(replace(scenario, system=system, variants=()), identifier, packaging)
    put_in_place(path, pack(files, _DESCRIPTION))


@contextmanager
def _toolbox() -> Generator[Any]:
    """Give the toolbox, whose import takes a while, with its log turned down and its errors turned into ours."""
    container = require("fmu_manipulation_toolbox.container", extra="container", purpose="writing an FMU of FMUs")
    logger = logging.getLogger("fmu_manipulation_toolbox")
    before, propagate = logger.level, logger.propagate
    logger.setLevel(logging.CRITICAL)
    try:
        yield container
    except container.FMUContainerError as error:
        raise InputError(f"the FMU Manipulation Toolbox cannot make this container: {error.reason}") from error
    finally:
        logger.setLevel(before)
        logger.propagate = propagate


def _without_signals(system: System) -> System:
    """Make start values of constants, and components of signals that change."""
    constants = {name: signal.held for name, signal in system.inputs.items() if signal.held is not None}
    changing = {name: signal for name, signal in system.inputs.items() if name not in constants}
    bare, _ = as_components(System(system.components, system.connections, changing))
    return bare.with_values(constants)


def _order(scenario: Scenario, system: System) -> tuple[str, ...]:
    """Return the given stepping order, if there is one, with the components that were signals first."""
    order = scenario.method.order
    added = tuple(part.name for part in system.components if part not in scenario.system.components)
    return (*(name for name in added if name not in order), *order) if order else ()


def _expose(
    container: Any, system: System, descriptions: Mapping[str, Description], inside: Mapping[str, str]
) -> dict[str, Unit]:
    """Connect what is connected, and give the rest and all outputs to the outside; return their units by name.

    `inside` says what the components are called there.
    """
    for connection in system.connections:
        source, target = connection.source, connection.target
        if conversion_of(connection, descriptions) is not None:
            raise InputError(f"a container passes values on as they are; connection {source} -> {target} converts them")
        container.add_link(inside[source.component], source.variable, inside[target.component], target.variable)
    driven = {connection.target for connection in system.connections}
    free = [
        (component, variable)
        for component, description in descriptions.items()
        for variable in description.with_causality("input")
        if f"{component}.{variable.name}" not in driven
    ]
    count = Counter(variable.name for _, variable in free)
    units: dict[str, Unit] = {}
    for component, variable in free:
        name = variable.name if count[variable.name] == 1 else f"{component}.{variable.name}"
        container.add_input(name, inside[component], variable.name)
        units |= {name: variable.unit} if variable.unit else {}
    for component, description in descriptions.items():
        for variable in description.with_causality("output"):
            name = f"{component}.{variable.name}"
            container.add_output(inside[component], variable.name, name)
            units |= {name: variable.unit} if variable.unit else {}
    return units


def _warn_of_loops(system: System, descriptions: Mapping[str, Description]) -> None:
    """Name loops that a container does not settle at the start."""
    for loop in feedthrough_loops(system, descriptions, initially=True):
        log.warning("a container starts the loop %s from zero, and does not settle it", loop)


def _finished(files: Mapping[str, bytes], title: str, units: Mapping[str, Unit]) -> dict[str, bytes]:
    """Complete the description: units, which the toolbox leaves out, and a GUID that names the content.

    The toolbox draws the GUID from chance, and other attributes from clock and user.
    """
    root = ElementTree.fromstring(files[_DESCRIPTION])
    for attribute in _OF_THE_MOMENT:
        root.attrib.pop(attribute, None)
    root.set("description", title)
    _add_units(root, units)
    total = sha256(ElementTree.tostring(root))
    for name in sorted(files):
        if name != _DESCRIPTION:
            total.update(f"\0{name}\0".encode() + files[name])
    root.set("guid", total.hexdigest())
    ElementTree.indent(root)
    return {**files, _DESCRIPTION: ElementTree.tostring(root, "utf-8", xml_declaration=True)}


def _add_units(root: Element, units: Mapping[str, Unit]) -> None:
    """Give variables their units, and define those."""
    used: dict[str, Unit] = {}
    for variable in root.iterfind("ModelVariables/ScalarVariable"):
        unit, kind = units.get(variable.get("name", "")), variable.find("Real")
        if unit is not None and kind is not None:
            kind.set("unit", unit.name)
            used[unit.name] = unit
    if not used:
        return
    definitions = Element("UnitDefinitions")
    root.insert([child.tag for child in root].index("CoSimulation") + 1, definitions)
    for name, unit in sorted(used.items()):
        definition = SubElement(definitions, "Unit", name=name)
        if unit.powers is not None:
            powers = {base: str(power) for base, power in zip(BASE_UNITS, unit.powers, strict=True) if power}
            SubElement(definition, "BaseUnit", powers, factor=repr(unit.factor), offset=repr(unit.offset))
