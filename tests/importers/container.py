"""FMU containers of the FMU Manipulation Toolbox: one FMU that holds others and couples them in steps of its own."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

from fmu_manipulation_toolbox.container import FMUContainer

from cosim.system.structure import System
from tests.importers.systems import fmu_of, outputs, settings


def make_container(
    system: System, folder: Path, step_size: float, *, sequential: bool = False, plain_names: bool = False
) -> Path:
    """Pack a system of FMUs into one.

    Parameters
    ----------
    system : System
        Of FMUs that are all different; inputs without a connection become the container's inputs.
    folder : Path
        Where to work; the container is made there.
    step_size : float
        Communication step size inside [s].
    sequential : bool
        Whether an FMU gets what those before it have put out in the same step.
    plain_names : bool
        Whether outputs are named ``variable``, and not ``component.variable``.
    """
    container = FMUContainer("Coupled", folder, fmi_version=2)
    files = {part.name: fmu_of(system, part.name).name for part in system.components}
    for name, file in files.items():
        shutil.copy(fmu_of(system, name), folder)
        container.get_fmu(file)
    for component, variable, value in settings(system):
        container.add_start_value(files[component], variable.name, str(value))
    for connection in system.connections:
        source, target = connection.source, connection.target
        container.add_link(files[source.component], source.variable, files[target.component], target.variable)
    for component, variables in outputs(system).items():
        for variable in variables:
            name = variable.name if plain_names else f"{component}.{variable.name}"
            container.add_output(files[component], variable.name, name)
    container.add_implicit_rule(auto_input=True, auto_output=False, auto_link=False)
    container.make_fmu("Coupled.fmu", step_size=step_size, sequential=sequential)
    return folder / "Coupled.fmu"


def with_law_in_container(system: System, folder: Path, step_size: float) -> System:
    """Return a system whose law comes in a container of its own with its parameters set.

    For tools that leave enumerations at their start value: the law's form is chosen inside the container.
    """
    (law,) = [part for part in system.components if part.name == "law"]
    container = make_container(System((law,)), folder, step_size, plain_names=True)
    packed = replace(law, fmu=container, parameters={})
    return replace(system, components=tuple(packed if part is law else part for part in system.components))
