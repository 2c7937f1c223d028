"""Runs of the scenarios that claims are judged by, and what they came to in words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np

from cosim import Result, Step, load_scenario, simulate
from cosim.drilling.oscillation import Measures, measure
from models.plant.parameters import DrillstringParameters
from models.theory.stability.equilibrium import running_equilibrium

CHANGE = 60.0
"""When an input changes in runs from the cycle [s]."""
LATE = 20.0
"""The end of a run that tells what it came to [s]."""
QUIET = 1e-2
"""A speed that varies by less is steady [rad/s]."""
NOMINAL_SPEED, NOMINAL_WEIGHT = 10.0, 97347.0


class Run:
    """A run of a scenario and its measures."""

    def __init__(self, result: Result):
        self.result = result
        found = measure(result)
        assert found is not None
        self.measures: Measures = found

    @property
    def steady(self) -> bool:
        """Whether bit and top turn on uniformly in the end."""
        return self.measures.peak - self.measures.minimum < QUIET and self.measures.mean_speed > QUIET

    @property
    def sticks(self) -> bool:
        """Whether the bit still sticks and slips in the end."""
        return self.measures.stuck_fraction > 0.0 and self.measures.peak > QUIET

    def __str__(self) -> str:
        found = self.measures
        if self.steady:
            return f"steady at {found.mean_speed:.4f} rad/s"
        if self.sticks:
            period = f"period {found.period:.4f} s, " if found.period else ""
            return f"stick-slip: {period}peak {found.peak:.2f} rad/s, stuck {100 * found.stuck_fraction:.1f} %"
        if found.peak < QUIET:
            return "the bit stays at rest"
        return f"swings from {found.minimum:.1f} to {found.peak:.1f} rad/s"

    def swing(self, output: str) -> tuple[float, float]:
        """Return the mean of an output in the end, and from its least to its greatest value."""
        values = self.result[f"plant.{output}"][self.result.time > self.result.time[-1] - LATE]
        return float(np.mean(values)), float(np.ptp(values))


@lru_cache
def _run(scenario: str, variant: str | None, stop_time: float, values: tuple[tuple[str, float], ...]) -> Run:
    return Run(simulate(load_scenario(scenario), variant=variant, stop_time=stop_time, overrides=dict(values)))


def run(scenario: str, variant: str | None = None, *, stop_time: float = 100.0, **values: float) -> Run:
    """Run a scenario with other values, ``plant__I_B=311`` for ``plant.I_B``."""
    named = tuple((name.replace("__", "."), float(value)) for name, value in values.items())
    return _run(scenario, variant, stop_time, named)


@lru_cache
def from_the_cycle(name: str, value: float, inertia: float = 89.0) -> Run:
    """Run stick-slip of Fig. 2 for a minute, then change one of its inputs, ``Omega`` or ``WOB``."""
    scenario = load_scenario("stick-slip")
    before = {"Omega": NOMINAL_SPEED, "WOB": NOMINAL_WEIGHT}[name]
    inputs = {**scenario.system.inputs, f"plant.{name}": Step(before, value, CHANGE)}
    changed = replace(scenario, system=replace(scenario.system, inputs=inputs))
    return Run(simulate(changed, stop_time=CHANGE + 140.0, overrides={"plant.I_B": inertia}))


def equilibrium_start(inertia: float = 89.0) -> Mapping[str, float]:
    """Return the start values of steady rotation at the nominal point."""
    found = running_equilibrium(DrillstringParameters(I_B=inertia), NOMINAL_SPEED, NOMINAL_WEIGHT)
    return {"plant__initial_speed": found.speed, "plant__initial_torque": found.torque}
