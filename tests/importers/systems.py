"""What every tool is given: the scenarios, as plain values and connections, and their reference runs by our master."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from cosim import load_scenario, simulate
from cosim.fmi2.model_description import read_description
from cosim.recording.result import Result
from cosim.system.description import Variable
from cosim.system.signals import Constant, Value
from cosim.system.structure import System

NATIVE = Path(__file__).parents[2] / "dist" / "native"

ALONE = [
    ("stick-slip", None),
    ("lower-wob", None),
    ("higher-speed", None),
    *(("bit-damping", f"c_b={c_b}") for c_b in ("0.8", "15", "65", "150")),
]
"""Scenarios without a connection: the plant under constant inputs."""
OPEN_START = [*ALONE, ("wob-law", None)]
"""Scenarios whose values at the start do not depend on how a tool finds them: no loop through direct feedthrough."""
LOOP = [("dissipative-law", "printed"), ("dissipative-law", "tracking")]
"""Scenarios in which law and plant answer each other at once."""


class Setting(NamedTuple):
    """A value given before the start; an enumeration is given by number."""

    component: str
    variable: Variable
    value: Value


def system_of(scenario: str, variant: str | None) -> System:
    """Return the system of a variant of a scenario."""
    loaded = load_scenario(scenario)
    chosen = loaded.variant(variant)
    return loaded.system.with_values(chosen.values if chosen else {})


def ordered(system: System, names: Sequence[str]) -> System:
    """Return the system with its components in another order."""
    parts = {part.name: part for part in system.components}
    return replace(system, components=tuple(parts[name] for name in names))


def fmu_of(system: System, component: str) -> Path:
    """Return the file of a component's FMU: one of dist/ by name, or any by its path."""
    fmu = next(part.fmu for part in system.components if part.name == component)
    return NATIVE / f"{fmu}.fmu" if isinstance(fmu, str) else fmu


def settings(system: System) -> Iterator[Setting]:
    """Yield the parameters of all components, and the inputs, which are constant in every scenario."""
    given: list[tuple[str, str, Value]] = [
        (part.name, name, value) for part in system.components for name, value in part.parameters.items()
    ]
    for target, signal in system.inputs.items():
        assert isinstance(signal, Constant)
        given.append((target.component, target.variable, signal.value))
    for component, name, value in given:
        variable = read_description(fmu_of(system, component)).by_name[name]
        yield Setting(component, variable, variable.items[str(value)] if variable.items else value)


def outputs(system: System, types: tuple[str, ...] = ("Real", "Integer", "Boolean")) -> dict[str, list[Variable]]:
    """Return the outputs of each component that are of one of the types."""
    descriptions = {part.name: read_description(fmu_of(system, part.name)) for part in system.components}
    return {
        name: [variable for variable in description.with_causality("output") if variable.type in types]
        for name, description in descriptions.items()
    }


@cache
def our_run(scenario: str, variant: str | None, step_size: float, steps: int, algorithm: str = "jacobi") -> Result:
    """Run a scenario by our master; tests share the result."""
    return simulate(
        load_scenario(scenario),
        variant=variant,
        algorithm=algorithm,
        step_size=step_size,
        stop_time=steps * step_size,
    )


def assert_same_bits(actual: Mapping[str, np.ndarray], expected: Result | Mapping[str, np.ndarray]) -> None:
    """Compare trajectories by ``component.variable``: every row of every one given, and at least one."""
    assert actual
    for name, values in actual.items():
        wanted = np.asarray(expected[name])
        values = np.asarray(values).astype(wanted.dtype)
        assert values.shape == wanted.shape, name
        if values.tobytes() != wanted.tobytes():
            row = int(np.argmax(values != wanted))
            pytest.fail(f"{name} differs from row {row} on: {values[row]!r} is not {wanted[row]!r}")
