"""A master to be read at a glance, on fmpy's wrappers: it explains why a tool's result is or is not our master's.

Tools that step every FMU once from t to t + H differ in three things only, and each is an argument here: the times they
pass to fmi2DoStep, the values they exchange in initialization mode, and whether an FMU is given the newest values or
those of the beginning of the step.
"""

from __future__ import annotations

import itertools
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

from cosim.system.structure import System
from tests.importers.systems import fmu_of, settings

Times = tuple[list[float], list[float]]
"""Communication points and communication step sizes [s]."""


def multiples(step: float, count: int) -> Times:
    """Points k H and steps H, as our master and FMU containers have them."""
    return [k * step for k in range(count)], [step] * count


def differences(step: float, count: int) -> Times:
    """Points k H and the steps between them, as fmpy.simulate_fmu has them."""
    points = [k * step for k in range(count + 1)]
    return points[:-1], [end - begin for begin, end in itertools.pairwise(points)]


def nanoseconds(step: float, count: int) -> Times:
    """Points at whole nanoseconds, each rounded to the nearest number, and the steps between, as in libcosim."""
    points = [k * round(step * 1e9) / 1e9 for k in range(count + 1)]
    return points[:-1], [end - begin for begin, end in itertools.pairwise(points)]


def sums(step: float, count: int) -> Times:
    """Points t += H and steps H, as in Ecos."""
    points = [0.0]
    for _ in range(count - 1):
        points.append(points[-1] + step)
    return points, [step] * count


class Part:
    """One FMU of a system."""

    def __init__(self, name: str, path: Path, stack: ExitStack) -> None:
        folder = fmpy.extract(path)
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        description = fmpy.read_model_description(folder)
        self.variables = {variable.name: variable for variable in description.modelVariables}
        self.slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.slave.instantiate()
        stack.callback(self.slave.freeInstance)
        of_type = {
            kind: [v for v in description.modelVariables if v.causality == "output" and v.type == kind]
            for kind in ("Real", "Integer", "Boolean")
        }
        self.names = [f"{name}.{v.name}" for group in of_type.values() for v in group]
        self._reads = [
            (getattr(self.slave, f"get{kind}"), [v.valueReference for v in group])
            for kind, group in of_type.items()
            if group
        ]

    def set(self, name: str, value: Any) -> None:
        variable = self.variables[name]
        kind = "Integer" if variable.type == "Enumeration" else variable.type
        getattr(self.slave, f"set{kind}")([variable.valueReference], [value])

    def outputs(self) -> dict[str, Any]:
        return dict(zip(self.names, (v for get, references in self._reads for v in get(references)), strict=True))


class Loop:
    """A system of FMUs in initialization mode, with all given values set.

    Attributes
    ----------
    parts : dict of str to Part
        In the order of the system.
    now : dict of str to value
        The outputs by ``component.variable``, as they were read last.
    """

    def __init__(self, system: System, stack: ExitStack) -> None:
        self.connections = [(c.source, c.target.component, c.target.variable) for c in system.connections]
        self.parts = {part.name: Part(part.name, fmu_of(system, part.name), stack) for part in system.components}
        self.now: dict[str, Any] = {}
        for component, variable, value in settings(system):
            self.parts[component].set(variable.name, value)
        for part in self.parts.values():
            part.slave.setupExperiment(startTime=0.0)
            part.slave.enterInitializationMode()
        self.read(self.parts)

    def read(self, names: Iterable[str]) -> None:
        for name in names:
            self.now.update(self.parts[name].outputs())

    def give(self, names: Iterable[str], values: Mapping[str, Any]) -> None:
        """Set the connected inputs of some components to values of outputs."""
        chosen = set(names)
        for source, component, variable in self.connections:
            if component in chosen:
                self.parts[component].set(variable, values[source])


Exchange = Callable[[Loop], None]
"""What happens in initialization mode."""


def rounds(count: int) -> Exchange:
    """Pass all outputs to all inputs at once, `count` times."""

    def exchange(loop: Loop) -> None:
        for _ in range(count):
            loop.give(loop.parts, loop.now)
            loop.read(loop.parts)

    return exchange


def once_in_order(order: Sequence[str]) -> Exchange:
    """Initialise one component after the other; inputs from a component still to come are given zero."""

    def exchange(loop: Loop) -> None:
        known = dict.fromkeys(loop.now, 0.0)
        for name in order:
            loop.give([name], known)
            loop.read([name])
            known.update({key: loop.now[key] for key in loop.parts[name].names})

    return exchange


def given(inputs: Mapping[str, Any]) -> Exchange:
    """Set the connected inputs, by ``component.variable``, to values found elsewhere."""

    def exchange(loop: Loop) -> None:
        for _, component, variable in loop.connections:
            loop.parts[component].set(variable, inputs[f"{component}.{variable}"])

    return exchange


def run(system: System, times: Times, exchange: Exchange, *, sequential: bool = False) -> dict[str, np.ndarray]:
    """Run a system and return its outputs by ``component.variable``, at the start and after each step.

    Parameters
    ----------
    system : System
        Its inputs are connected or constant.
    times : tuple of lists
        Communication points and step sizes [s].
    exchange : callable
        What happens in initialization mode.
    sequential : bool
        Whether an FMU is given what those before it have put out at the end of the step already.
    """
    with ExitStack() as stack:
        loop = Loop(system, stack)
        exchange(loop)
        for part in loop.parts.values():
            part.slave.exitInitializationMode()
        loop.read(loop.parts)
        rows = [list(loop.now.values())]
        for point, size in zip(*times, strict=True):
            begin = loop.now if sequential else dict(loop.now)
            for name, part in loop.parts.items():
                loop.give([name], begin)
                part.slave.doStep(point, size)
                loop.read([name])
            rows.append(list(loop.now.values()))
        for part in loop.parts.values():
            part.slave.terminate()
        return {name: np.array(column) for name, column in zip(loop.now, zip(*rows, strict=True), strict=True)}
