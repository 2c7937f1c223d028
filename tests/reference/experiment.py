"""What a reference experiment is: inputs, parameters, steps, and how far an answer may be off."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

Points = Sequence[tuple[float, float]]
"""An input over time [s]: straight lines between points, a jump where two share a time, the last value kept."""

Answers = Mapping[str, np.ndarray]
"""Outputs by name at times; bool for Boolean, int for Integer."""

DOUBLE = 17
"""Significant digits that tell every double from its neighbours."""

CLEARANCE = 1e-4
"""No time of a reference is nearer than this to a jump of an output [s]."""


@dataclass(frozen=True)
class Tolerance:
    """How far an output may be from its reference, in its own unit, and why.

    Allowed is absolute + relative times the size of the reference; zero and zero means equal.
    """

    reason: str
    absolute: float = 0.0
    relative: float = 0.0


@dataclass(frozen=True)
class Experiment:
    """One run of an FMU from time 0.

    Attributes
    ----------
    stop_time, step_size : float
        End of the run, communication step size [s].
    every : int
        The reference holds every so many communication points.
    answer : callable
        From times [s] to outputs; and with the step size, which outputs about the last step need.
    digits : int
        Significant digits of the reference.
    avoid : callable, optional
        Returns the times [s] near which an output jumps, so that nothing can be compared there.
    parameters : mapping of str to number or str
        Other than their start values; an enumeration by the name of its item.
    inputs : mapping of str to points
        Those that are driven.
    """

    name: str
    description: str
    stop_time: float
    step_size: float
    every: int
    answer: Callable[[np.ndarray, float], Answers]
    tolerances: Mapping[str, Tolerance]
    parameters: Mapping[str, float | str] = field(default_factory=dict)
    inputs: Mapping[str, Points] = field(default_factory=dict)
    digits: int = DOUBLE
    avoid: Callable[[], np.ndarray] | None = None

    @property
    def interpolated(self) -> bool:
        """Whether an input has a slope, so that only an FMU that interpolates its inputs can follow."""
        return any(_has_slope(points) for points in self.inputs.values())

    def times(self) -> np.ndarray:
        """Return the communication points the reference holds [s]."""
        steps = round(self.stop_time / self.step_size)
        times = np.arange(0, steps + 1, self.every) * self.step_size
        if self.avoid is None:
            return times
        distances = np.abs(times[:, None] - self.avoid()[None, :]).min(axis=1)
        return times[distances > CLEARANCE]


def _has_slope(points: Points) -> bool:
    return any(before[0] < after[0] and before[1] != after[1] for before, after in pairwise(points))


def held(*changes: tuple[float, float]) -> Points:
    """Return the points of an input that is held from each change (time [s], value) to the next."""
    points = [changes[0]]
    for (_, before), (time, after) in pairwise(changes):
        points += [(time, before), (time, after)]
    return tuple(points)
