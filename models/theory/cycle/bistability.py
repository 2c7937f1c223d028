"""The bistable range of steady rotation and stick-slip: from the loss of stability to the fold of the cycles.

The cycles that are born where the running equilibrium loses its stability are followed. At first the bit never rests;
its least speed falls until it is zero, where the bit begins to stick; from there on it rests longer and longer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from ...plant.parameters import DrillstringParameters
from ..numerics.progress import Progress, silent
from ..stability.spectrum import CriticalPoint, critical_point, critical_wob
from .continuation import STEP, TOLERANCE, BranchPoint, branch_point, fold_between, followed, input_of, input_unit
from .cycle import LONGEST, broken_law
from .equations import Orbit
from .mesh import Resolution, Timing, cycle_mesh
from .solver import remeshed, resolved, slowest_at, stuck_for

FIRST_DIP = 0.02
"""By how much the least speed of the first cycle is below that of the equilibrium, as a part of it."""
LAST_DIP = 0.03
"""Least speed, as a part of the speed of the equilibrium, below which the bit is made to touch rest."""
FIRST_REST = 0.08
"""Rest of the bit in the first cycle in which it has one, in travel times."""
LONGEST_STEP = 0.8
USUAL = 10
"""About as many cycles in which the bit sticks are found before the fold, to guess how far it is."""


@dataclass(frozen=True)
class Bistability:
    """Range of one input in which the equilibrium and a cycle are both stable: between `threshold` and `fold`.

    Attributes
    ----------
    free : str
        The input, "Omega" or "WOB".
    threshold : float
        Where the running equilibrium loses its stability [rad/s or N].
    grazing : float or None
        Where the bit begins to stick in the cycles that are born there; None if they turn before.
    fold : float
        Up to where there are cycles: where the unstable ones that come from the threshold meet the stable ones.
    grazing_cycle, fold_cycle : Orbit or None, Orbit
        The cycles at `grazing` and at `fold`.
    points : tuple of BranchPoint
        The cycles from the threshold to a little beyond the fold.
    """

    free: str
    threshold: float
    grazing: float | None
    fold: float
    grazing_cycle: Orbit | None
    fold_cycle: Orbit
    points: tuple[BranchPoint, ...]


def bistable_omegas(parameters: DrillstringParameters, wob: float, progress: Progress = silent) -> Bistability:
    """Return between which drive speeds steady rotation and stick-slip are both stable at a weight on bit [N].

    It takes ten seconds to minutes; `progress` is called at each cycle that is found.

    Raises
    ------
    ValueError
        The running equilibrium is stable at every Omega, or loses its stability without an oscillation or to cycles
        that live on the unstable side only.
    ArithmeticError
        The cycles cannot be followed to their fold.
    """
    return _bistability(parameters, critical_point(parameters, wob), "Omega", progress)


def bistable_wobs(parameters: DrillstringParameters, omega: float, progress: Progress = silent) -> Bistability:
    """Return between which weights on bit steady rotation and stick-slip are both stable at a drive speed [rad/s].

    Takes as long, and raises, as :func:`bistable_omegas`.
    """
    return _bistability(parameters, critical_point(parameters, critical_wob(parameters, omega)), "WOB", progress)


def _bistability(
    parameters: DrillstringParameters, critical: CriticalPoint, free: str, progress: Progress
) -> Bistability:
    if not critical.frequency:
        raise ValueError(f"the running equilibrium ends at Omega = {critical.omega:.9g} rad/s without an oscillation")
    threshold = critical.omega if free == "Omega" else critical.wob
    start = _first_cycle(parameters, critical, free)
    ahead = 1.0 if free == "Omega" else -1.0
    if ahead * (input_of(start.orbit, free) - threshold) <= 0.0:
        raise ValueError(f"the cycles born at {free} = {threshold:.9g} live where the equilibrium is unstable")
    turning, touch = [start], LAST_DIP * critical.speed
    for point in followed(start, STEP, LONGEST_STEP):
        turning.append(point)
        progress(_told(turning), 0.4 * min(1.0, 1.0 - _least_speed(point.orbit) / critical.speed))
        if ahead * point.slope < 0.0:
            fold = _finely(fold_between(*turning[-2:]).orbit, free)
            return Bistability(free, threshold, None, input_of(fold, free), None, fold, tuple(turning))
        if _least_speed(point.orbit) < touch:
            break
    grazing = _finely(resolved(turning[-1].orbit, free, slowest_at(0.0), TOLERANCE), free)
    progress("cycles in which the bit sticks", 0.4)
    sticking = _sticking(grazing, free, ahead, progress)
    progress(_told(sticking), 0.9)
    fold = _finely(fold_between(*sticking[-2:]).orbit, free) if len(sticking) > 1 else grazing
    points = (*turning, *sticking)
    return Bistability(free, threshold, input_of(grazing, free), input_of(fold, free), grazing, fold, points)


def _first_cycle(parameters: DrillstringParameters, critical: CriticalPoint, free: str) -> BranchPoint:
    """Return a small cycle next to the threshold, on a branch on which the least speed falls."""
    timing = Timing(0, np.array([2.0 * pi / critical.frequency]))
    mesh = cycle_mesh(parameters, timing, Resolution.coarse(0, LONGEST * parameters.travel_time))
    dip = FIRST_DIP * critical.speed
    speeds = critical.speed - dip * np.cos(critical.frequency * mesh.node_times)
    orbit = Orbit(parameters, critical.omega, critical.wob, mesh, speeds)
    orbit = resolved(orbit, free, slowest_at(critical.speed - dip), TOLERANCE)
    return branch_point(orbit, free, input_unit(orbit, free), lambda orbit: -slowest_at(0.0)(orbit)[1])


def _told(points: Sequence[BranchPoint]) -> str:
    """Say how many cycles there are, and where the last is."""
    return f"{len(points)} cycles, {points[-1].free} = {points[-1].input:.5g}"


def _sticking(grazing: Orbit, free: str, ahead: float, progress: Progress) -> list[BranchPoint]:
    """Return cycles in which the bit rests, from the shortest rest until the input has turned.

    If it turns at once there is only one.
    """
    rest = FIRST_REST * grazing.parameters.travel_time
    timing = Timing(1, np.array([grazing.timing.period - rest, grazing.timing.period]))
    resolution = Resolution.coarse(1, float(grazing.mesh.resolution.limits.max()))
    mesh = cycle_mesh(grazing.parameters, timing, replace(resolution, limits=grazing.mesh.resolution.limits))
    speeds = grazing.speed(mesh.node_times * (1.0 - 1e-14) * timing.period / float(timing.stops[0]))
    orbit = resolved(replace(grazing, mesh=mesh, values=speeds), free, stuck_for(rest), TOLERANCE)
    start = branch_point(orbit, free, input_unit(orbit, free), lambda orbit: stuck_for(0.0)(orbit)[1])
    if ahead * start.slope < 0.0:
        return [start]
    found = [start]
    for point in followed(start, STEP, STEP):
        if (broken := broken_law(point.orbit)) is not None:
            raise ArithmeticError(f"the cycles end before a fold, at {free} = {point.input:.9g}: {broken}")
        found.append(point)
        progress(_told(found), 0.4 + 0.5 * (1.0 - USUAL / (USUAL + len(found))))  # nobody knows how many there are
        if ahead * point.slope < 0.0:
            return found
    raise ArithmeticError(f"the cycles cannot be followed beyond {free} = {input_of(orbit, free):.9g}")


def _finely(orbit: Orbit, free: str) -> Orbit:
    """Return a cycle that grazes or folds, on finer pieces.

    What it rests, or its least speed, is kept: at a fold the input does not change with it to first order.
    """
    timing = orbit.timing
    resolution = replace(Resolution.fine(timing.slips, 1.0), limits=orbit.mesh.resolution.limits)
    finer = remeshed(orbit, replace(orbit.mesh, resolution=resolution))
    condition = stuck_for(timing.stuck) if timing.slips else slowest_at(_least_speed(orbit))
    return resolved(finer, free, condition)


def _least_speed(orbit: Orbit) -> float:
    """Return the speed of a bit that never rests where it is slowest [rad/s]."""
    return float(orbit.values[orbit.mesh.columns[0, 0]])
