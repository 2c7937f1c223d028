"""Branches of cycles over the drive speed or the weight on bit, through folds, by pseudo-arclength continuation.

A branch is followed in the space of its times, its free input and, as long as the bit never rests, its least speed.
Times count for much there: near a fold the input hardly changes while the bit rests longer and longer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import copysign

import numpy as np
from scipy.optimize import brentq

from ..numerics.arrays import FloatArray
from ..numerics.progress import Progress, silent
from .cycle import broken_law
from .equations import Orbit
from .mesh import Resolution
from .solver import IMPATIENT, Condition, advanced, free_row, held_at, jacobian, remeshed, resolved

TOLERANCE = 1e-6
"""Defect of the cycles along a branch, relative to their greatest speed; that of their periods is far smaller."""
SHORTEST_STEP = 1e-5
STEP, GROWTH = 0.3, 1.5
BISECTIONS = 13
TIME_UNIT = 0.25
"""Unit of time along a branch, in travel times."""


@dataclass(frozen=True)
class BranchPoint:
    """A cycle on a branch.

    Attributes
    ----------
    orbit : Orbit
        The cycle.
    free : str
        The input that changes along the branch, "Omega" or "WOB".
    unit : float
        What counts as one of it, beside 1 rad/s of the least speed and TIME_UNIT of time.
    tangent : ndarray
        Direction of the branch, of all unknowns and of length 1 in the space in which it is followed.
    """

    orbit: Orbit
    free: str
    unit: float
    tangent: FloatArray

    @property
    def input(self) -> float:
        """Value of the free input [rad/s or N]."""
        return input_of(self.orbit, self.free)

    @property
    def slope(self) -> float:
        """Change of the free input along the branch, per unit of length; 0 at a fold."""
        return float(self.tangent[-1])


def input_of(orbit: Orbit, free: str) -> float:
    """Return "Omega" [rad/s] or "WOB" [N] of an orbit."""
    return orbit.omega if free == "Omega" else orbit.wob


def branch_point(orbit: Orbit, free: str, unit: float, towards: Callable[[Orbit], FloatArray]) -> BranchPoint:
    """Return a cycle as the beginning of a branch that goes where the row `towards` of it grows."""
    row = towards(orbit)
    return BranchPoint(orbit, free, unit, _tangent(orbit, free, unit, row))


def next_point(point: BranchPoint, length: float) -> BranchPoint:
    """Return the cycle at a distance along the branch.

    Raises
    ------
    ArithmeticError
        There is none, or it cannot be found.
    """
    guess = advanced(point.orbit, point.free, length * point.tangent)
    if guess is None:
        raise ArithmeticError(f"the branch cannot be followed over a distance of {length}")
    condition = _at_distance(point, length)
    orbit = resolved(guess, point.free, condition, TOLERANCE, IMPATIENT)
    tangent = _tangent(orbit, point.free, point.unit, condition(orbit)[1])
    return BranchPoint(orbit, point.free, point.unit, tangent)


def followed(start: BranchPoint, first: float, longest: float) -> Iterator[BranchPoint]:
    """Follow a branch, and yield its cycles after the first, as long as it can be followed.

    Parameters
    ----------
    start : BranchPoint
        Where it begins.
    first, longest : float
        Distance of the first cycle, and greatest distance between cycles.
    """
    point, length = start, first
    while length >= SHORTEST_STEP:
        try:
            following = next_point(point, length)
        except ArithmeticError:
            length *= 0.5
            continue
        if _turned(point, following) < 0.5:
            length *= 0.5
            continue
        point = following
        yield point
        length = min(GROWTH * length, longest)


@dataclass(frozen=True)
class Branch:
    """Cycles in order, and why there are no more.

    Attributes
    ----------
    points : tuple of BranchPoint
        The cycles; all obey the law of friction.
    end : str
        What ended the branch: what the law of friction forbids beyond the last cycle, or that it was long enough.
    """

    points: tuple[BranchPoint, ...]
    end: str


def branch_from(
    orbit: Orbit, free: str, growing: bool, until: Callable[[BranchPoint], bool], progress: Progress = silent
) -> Branch:
    """Follow the branch of a cycle, through folds, for as long as it obeys the law of friction.

    Parameters
    ----------
    orbit : Orbit
        The cycle, as of :func:`models.theory.cycle.cycle.limit_cycle`.
    free : str
        The input that changes, "Omega" or "WOB".
    growing : bool
        Whether it is to grow at first, or to fall.
    until : callable
        Of a point: whether to end with it.
    progress : callable, optional
        Called at each cycle; which part of the branch is done is not known, and grows to 1 ever more slowly.
    """
    timing, sign = orbit.timing, 1.0 if growing else -1.0
    resolution = Resolution.coarse(timing.slips, float(orbit.mesh.resolution.limits.max()))
    coarse = remeshed(orbit, replace(orbit.mesh, resolution=resolution))
    coarse = resolved(coarse, free, held_at(free, input_of(orbit, free)), TOLERANCE)
    start = branch_point(coarse, free, input_unit(orbit, free), lambda orbit: sign * free_row(orbit))
    points = [start]
    for point in followed(start, STEP, STEP):
        if (broken := broken_law(point.orbit)) is not None:
            points.append(_last_lawful(points[-1], point))
            return Branch(tuple(points), f"beyond {free} = {points[-1].input:.6g} {broken}")
        points.append(point)
        progress(f"{len(points)} cycles, {free} = {point.input:.5g}", 1.0 - 20.0 / (20.0 + len(points)))
        if until(point):
            return Branch(tuple(points), "it was followed as far as asked for")
    return Branch(tuple(points), f"it cannot be followed beyond {free} = {points[-1].input:.9g}")


def _last_lawful(lawful: BranchPoint, broken: BranchPoint) -> BranchPoint:
    """Return the last cycle between two of a branch that obeys the law of friction, to about 1e-4 of their distance."""
    low, high, last = 0.0, _distance(lawful, broken), lawful
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        point = next_point(lawful, middle)
        if broken_law(point.orbit) is None:
            low, last = middle, point
        else:
            high = middle
    return last


def input_unit(orbit: Orbit, free: str) -> float:
    """Return what counts as one of the free input: 1 rad/s, or the weight that is to WOB as that is to Omega [N]."""
    return 1.0 if free == "Omega" else orbit.wob / orbit.omega


def fold_between(before: BranchPoint, after: BranchPoint) -> BranchPoint:
    """Return the cycle at which the free input turns, between two of a branch in which it grows and falls."""
    found: dict[float, BranchPoint] = {0.0: before}
    whole = _distance(before, after)

    def slope(length: float) -> float:
        if length not in found:
            found[length] = next_point(before, length)
        return found[length].slope

    length = float(brentq(slope, 0.0, whole, xtol=1e-6 * abs(whole), rtol=1e-12))
    return found[length] if length in found else next_point(before, length)


def _at_distance(point: BranchPoint, length: float) -> Condition:
    """Return the condition that an orbit is at a distance along the tangent of a point."""
    weights = _weighted(point)
    origin = float(weights @ _coordinates(point))

    def condition(orbit: Orbit) -> tuple[float, FloatArray]:
        here = replace(point, orbit=orbit)
        row = np.zeros(orbit.mesh.size + orbit.timing.vector.size + 1)
        row[_places(orbit)] = weights / _units(orbit, point.unit)
        return float(weights @ _coordinates(here)) - origin - length, row

    return condition


def _distance(before: BranchPoint, after: BranchPoint) -> float:
    """Return the distance of a cycle along the tangent of another."""
    return float((_coordinates(after) - _coordinates(before)) @ _weighted(before))


def _turned(before: BranchPoint, after: BranchPoint) -> float:
    """Return the cosine of the angle between two tangents, in the space in which the branch is followed."""
    return float(_weighted(before) @ _weighted(after))


def _places(orbit: Orbit) -> list[int]:
    """Return the unknowns that make the space: the least speed of a bit that never rests, the times and the input."""
    size = orbit.mesh.size
    slowest = [] if orbit.timing.slips else [int(orbit.mesh.columns[0, 0])]
    return [*slowest, *range(size, size + orbit.timing.vector.size + 1)]


def _units(orbit: Orbit, unit: float) -> FloatArray:
    """Return what counts as one of each: 1 rad/s, TIME_UNIT travel times, and a unit of the input."""
    slowest = np.ones(0 if orbit.timing.slips else 1)
    times = np.full(orbit.timing.vector.size, TIME_UNIT * orbit.parameters.travel_time)
    return np.array([*slowest, *times, unit])


def _coordinates(point: BranchPoint) -> FloatArray:
    """Return the place of a cycle in the space in which the branch is followed."""
    orbit = point.orbit
    slowest = orbit.values[[] if orbit.timing.slips else [int(orbit.mesh.columns[0, 0])]]
    return np.array([*slowest, *orbit.timing.vector, point.input]) / _units(orbit, point.unit)


def _weighted(point: BranchPoint) -> FloatArray:
    """Return the tangent in that space, of length 1."""
    return point.tangent[_places(point.orbit)] / _units(point.orbit, point.unit)


def _tangent(orbit: Orbit, free: str, unit: float, row: FloatArray) -> FloatArray:
    """Return the direction of the branch on which the product with a row is positive."""
    _, matrix = jacobian(orbit, free)
    wanted = np.zeros(row.size)
    wanted[-1] = 1.0
    tangent = np.asarray(np.linalg.solve(np.vstack([matrix, row]), wanted), np.float64)
    size = float(np.linalg.norm(tangent[_places(orbit)] / _units(orbit, unit)))
    return tangent * copysign(1.0 / size, float(row @ tangent))
