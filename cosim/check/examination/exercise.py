"""Give an FMU something to do, in many ways that must not make a difference, and record it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.check.examination.instance import Exchange, Instance, exchanges
from cosim.errors import format_time
from cosim.system.description import Description, Variable

STEPS = 500
"""Steps of a run, if the default experiment has as many."""

_GOLDEN = 0.6180339887498949
_HELD = 7
_APART = 31
_SHARE = 0.05


@dataclass(frozen=True)
class Plan:
    """Limit a run.

    Attributes
    ----------
    start, step : float
        Start time and communication step size [s].
    steps : int
        Number of steps.
    moves : bool
        Whether Real inputs are moved about their start values, so that more of the FMU is at work.
    """

    start: float
    step: float
    steps: int
    moves: bool = True

    @classmethod
    def of(cls, description: Description) -> Plan:
        """Return a plan after the default experiment; without one, of steps of 0.01 s from 0."""
        start = description.start_time or 0.0
        step = description.step_size
        stop = description.stop_time
        if stop is None or stop <= start:
            return cls(start, step or 0.01, STEPS)
        step = step or (stop - start) / STEPS
        return cls(start, step, max(2, min(STEPS, round((stop - start) / step))))

    def time(self, index: int) -> float:
        """Return a communication point [s]."""
        return self.start + index * self.step

    def __str__(self) -> str:
        """Return the plan as a table says it."""
        return f"{self.steps} steps of {self.step:g} s"


class Record:
    """Outputs at communication points, to be compared bit by bit.

    Parameters
    ----------
    names : sequence of str
        Of the outputs, Real ones first.
    times : sequence of float
        Communication points [s].
    reals : ndarray, shape (times, Real outputs)
        Their values.
    others : list of tuple
        One tuple of all other outputs a time.
    """

    def __init__(
        self, names: Sequence[str], times: Sequence[float], reals: NDArray[np.float64], others: list[tuple[Any, ...]]
    ) -> None:
        self.names = tuple(names)
        self.times = tuple(times)
        self.reals = reals
        self.others = others

    def part(self, begin: int, end: int) -> Record:
        """Return some of the rows."""
        return Record(self.names, self.times[begin:end], self.reals[begin:end], self.others[begin:end])

    def difference(self, other: Record) -> str:
        """Say where this record and another first differ in a bit; empty if nowhere."""
        for row, time in enumerate(self.times):
            column = self._differing_column(other, row)
            if column is not None:
                pair = f"{self._value(row, column)!r} and {other._value(row, column)!r}"
                return f"{self.names[column]} at t = {format_time(time)} s: {pair}"
        return ""

    def _differing_column(self, other: Record, row: int) -> int | None:
        same = self.reals[row].view(np.int64) == other.reals[row].view(np.int64)
        if not same.all():
            return int(np.argmin(same))
        pairs = zip(self.others[row], other.others[row], strict=True)
        return next((len(same) + place for place, (a, b) in enumerate(pairs) if a != b), None)

    def _value(self, row: int, column: int) -> Any:
        width = self.reals.shape[1]
        return float(self.reals[row, column]) if column < width else self.others[row][column - width]

    def column(self, name: str) -> NDArray[np.float64]:
        """Return a Real output over time."""
        return self.reals[:, self.names.index(name)]


@dataclass(frozen=True)
class Exercise:
    """The run of a plan on instances of an FMU."""

    description: Description
    plan: Plan

    @cached_property
    def moved(self) -> tuple[Variable, ...]:
        """The inputs that are moved."""
        inputs = self.description.with_causality("input")
        return tuple(v for v in inputs if v.type == "Real" and v.start is not None) if self.plan.moves else ()

    @cached_property
    def outputs(self) -> tuple[Variable, ...]:
        """The outputs, Real ones first."""
        found = self.description.with_causality("output")
        return tuple(sorted(found, key=lambda variable: variable.type != "Real"))

    def values(self, index: int, variant: int = 0) -> list[float]:
        """Return what the moved inputs are set to before a step; other variants move them otherwise."""
        first = index // _HELD + 1 + _APART * variant
        return [_moved(variable, first + place) for place, variable in enumerate(self.moved)]

    def run(self, instance: Instance, begin: int = 0, end: int | None = None, variant: int = 0) -> Record:
        """Step an initialised instance over the steps from `begin` to `end`; CallError if one fails."""
        runner = Runner(self, instance, variant)
        for index in range(begin, self.plan.steps if end is None else end):
            runner.step(index)
        return runner.record()

    def initialise(self, instance: Instance) -> None:
        """Initialise an instance at the start of the plan, its inputs as before the first step."""
        instance.initialise(self.plan.start)


class Runner:
    """An instance on its way through an exercise, step by step.

    Parameters
    ----------
    exercise : Exercise
        What is run.
    instance : Instance
        Initialised.
    variant : int
        How the inputs are moved.
    """

    def __init__(self, exercise: Exercise, instance: Instance, variant: int = 0) -> None:
        self._exercise = exercise
        self._instance = instance
        self._variant = variant
        self._inputs = Exchange("Real", exercise.moved) if exercise.moved else None
        self._outputs = exchanges(exercise.outputs)
        self._times: list[float] = []
        self._reals: list[list[float]] = []
        self._others: list[tuple[Any, ...]] = []

    def step(self, index: int, time: float | None = None, size: float | None = None) -> None:
        """Set the inputs, do a step, keep the outputs; `time` and `size` are the plan's unless given [s]."""
        if self._inputs is not None:
            self._inputs.set(self._instance, self._exercise.values(index, self._variant))
        plan = self._exercise.plan
        self._instance.step(plan.time(index) if time is None else time, plan.step if size is None else size)
        self.read()

    def read(self) -> None:
        """Keep the outputs as they are now."""
        groups = {group.kind: group.get(self._instance) for group in self._outputs}
        self._times.append(self._instance.time)
        self._reals.append(groups.pop("Real", []))
        self._others.append(tuple(value for group in groups.values() for value in group))

    def record(self) -> Record:
        """Return what was kept."""
        names = [variable.name for group in self._outputs for variable in group.variables]
        width = sum(variable.type == "Real" for variable in self._exercise.outputs)
        reals = np.array(self._reals, dtype=np.float64).reshape(len(self._times), width)
        return Record(names, self._times, reals, self._others)


def _moved(variable: Variable, place: int) -> float:
    """Return a value near the start value, within the declared bounds; the places spread evenly about it."""
    start = float(variable.start or 0.0)
    share = 2.0 * math.fmod(place * _GOLDEN, 1.0) - 1.0
    value = start + _SHARE * (abs(start) or 1.0) * share
    low = -math.inf if variable.minimum is None else variable.minimum
    high = math.inf if variable.maximum is None else variable.maximum
    return min(max(value, low), high)


def not_finite(record: Record) -> str:
    """Say where a Real output is not a finite number; empty if nowhere."""
    wrong = np.argwhere(~np.isfinite(record.reals))
    if not wrong.size:
        return ""
    row, column = wrong[0]
    value = float(record.reals[row, column])
    return f"{record.names[int(column)]} is {value} at t = {format_time(record.times[int(row)])} s"
