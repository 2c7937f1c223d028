"""Drives one FMU of dist/ through FMI from communication point to communication point and keeps what it puts out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from ctypes import c_double, c_int
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from tests.oracle import OracleParameters, Program
from tests.plant.fmi import Instance, must

PLANT = "DrillstringNeutral"
DAMPED = "DrillstringDistributed"
PLANTS = (PLANT, DAMPED)
RANGE = ("bit_speed_min", "bit_speed_max")
"""Outputs about the time since the last communication point."""


class Drive(Instance):
    """An FMU that has been initialised, every call of which must succeed.

    Parameters
    ----------
    model, packaging : str
        Which file of dist/.
    start_values : mapping
        Parameters and inputs by name.
    start : float
        Start time [s].
    """

    def __init__(
        self, model: str, start_values: Mapping[str, Any], packaging: str = "native", start: float = 0.0, **options: Any
    ) -> None:
        super().__init__(model, packaging, **options)
        for name, value in start_values.items():
            self.put(**{name: value})
        must(self, self.initialize(start))
        self.time = start
        names = {kind: [v.name for v in self._outputs() if v.type == kind] for kind in ("Real", "Integer", "Boolean")}
        self.names = [name for group in names.values() for name in group]
        arrays = {"Real": c_double, "Integer": c_int, "Boolean": c_int}
        self._reads = [
            (
                self.library.functions[f"fmi2Get{kind}"],
                self.references(group),
                len(group),
                (arrays[kind] * len(group))(),
            )
            for kind, group in names.items()
            if group
        ]

    def _outputs(self) -> list[Any]:
        return [variable for variable in self.variables.values() if variable.causality == "output"]

    def put(self, **values: float | str) -> None:
        """Set variables of one type."""
        must(self, self.set(**values))

    def go(self, end: float) -> None:
        """Take one step to a time [s]; `time` is then where the FMU is, which rounding can make another."""
        size = end - self.time
        must(self, self.step(self.time, size))
        self.time = self.time + size

    def outputs(self) -> list[float]:
        """Return all outputs, in the order of `names`."""
        row: list[float] = []
        for function, references, count, array in self._reads:
            status = function(self.component, references, count, array)
            if status:
                must(self, status)
            row.extend(array)
        return row

    def named(self) -> dict[str, float]:
        """Return all outputs by name."""
        return dict(zip(self.names, self.outputs(), strict=True))


@dataclass(frozen=True)
class Trajectory:
    """Outputs by name at communication points.

    Attributes
    ----------
    times : ndarray
        Where the FMU was [s].
    table : ndarray
        One row of outputs a time, in the order of `names`.
    """

    times: np.ndarray
    table: np.ndarray
    names: list[str]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.table[:, self.names.index(name)]

    def at(self, times: np.ndarray) -> Trajectory:
        """Return the part at some of the communication points."""
        places = np.searchsorted(self.times, times)
        assert (self.times[places] == times).all()
        return Trajectory(times, self.table[places], self.names)


def points(grid: Sequence[float] | np.ndarray, *programs: Program) -> np.ndarray:
    """Return communication points: those of a grid and, up to its end, all at which an input changes."""
    changes = [time for program in programs for time in program.times if 0 < time <= grid[-1]]
    return np.unique(np.concatenate([grid, changes]))


def travel(
    parameters: OracleParameters,
    omega: Program,
    wob: Program,
    ends: np.ndarray,
    packaging: str = "native",
    cells: int = 0,
    model: str = PLANT,
    **more: float,
) -> Iterator[Drive]:
    """Drive the plant from one time to the next with inputs that may jump and have slopes; yield it at each.

    `more` are other start values of the model. Where an input has no slope it is set when it changes only, so that it
    is held for the FMU as well.
    """
    programs = {"Omega": omega, "WOB": wob}
    lines = {name: program.line(0.0, 0.0) for name, program in programs.items()}
    start_values = {**asdict(parameters), "cells": cells, **{name: line[0] for name, line in lines.items()}, **more}
    with Drive(model, start_values, packaging) as plant:
        for end in ends.tolist():
            for name, program in programs.items():
                line = program.line(0.5 * (plant.time + end), plant.time)
                if line != lines[name]:
                    plant.put(**{name: line[0]})
                    lines[name] = line
                if line[1] != 0.0:
                    must(plant, plant.set_slopes(**{name: line[1]}))
            plant.go(end)
            yield plant


def follow(
    parameters: OracleParameters,
    omega: Program,
    wob: Program,
    grid: Sequence[float] | np.ndarray,
    packaging: str = "native",
    cells: int = 0,
    model: str = PLANT,
    **more: float,
) -> Trajectory:
    """Drive the plant along a grid and through all changes of the inputs, and return what it puts out."""
    rows, times, names = [], [], []
    for plant in travel(parameters, omega, wob, points(grid, omega, wob), packaging, cells, model, **more):
        rows.append(plant.outputs())
        times.append(plant.time)
        names = plant.names
    return Trajectory(np.array(times), np.array(rows), names)
