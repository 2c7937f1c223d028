"""Newton's method for cycles, with one input or another left free and one condition in its place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..numerics.arrays import FloatArray, IntArray
from ..numerics.interpolation import chebyshev, gauss
from .equations import Orbit, equations, with_input
from .mesh import DEGREE, CycleMesh, Timing, bins, cycle_mesh

Condition = Callable[[Orbit], tuple[float, FloatArray]]
"""Of an orbit: the residual, and its derivatives by values, timing and the free input."""

SETTLED = 1e-10
"""The last step of Newton's method is below this [rad/s, s, or relative to the free input]."""
PATIENT, IMPATIENT = (40, 1e-3), (8, 0.1)
"""Most steps of Newton's method, and the part below which a step is not shortened to make it an improvement."""
LARGEST_CHANGE = 0.5
"""Of a speed in one step, relative to the greatest."""
MOST_UNKNOWNS = 6000
RESOLVED = 1e-8
"""Defect of an orbit whose pieces are short enough, relative to its greatest speed."""
REFINEMENTS = 10


def settled(orbit: Orbit, free: str, condition: Condition, patience: tuple[int, float] = PATIENT) -> Orbit:
    """Return the cycle next to an orbit.

    Parameters
    ----------
    orbit : Orbit
        An approximation.
    free : str
        The input to be found, "Omega" or "WOB".
    condition : callable
        What is asked for instead of its value.
    patience : tuple
        `PATIENT` or `IMPATIENT`.

    Raises
    ------
    ArithmeticError
        Newton's method goes astray, or needs more unknowns than are allowed.
    """
    here = _System.of(remeshed(orbit, orbit.mesh), free, condition)
    most_steps, least_share = patience
    for _ in range(most_steps):
        step, share = here.newton_step(), 1.0
        while share >= least_share:
            tried = advanced(here.orbit, free, share * step)
            if tried is not None and share * _size(step, here.orbit, free) < SETTLED:
                return tried
            there = None if tried is None else _System.of(tried, free, condition)
            if there is not None and there.size < (1.0 - 0.1 * share) * here.size:
                here = there
                break
            share *= 0.5
        else:
            break
    raise ArithmeticError(f"no cycle found next to Omega = {orbit.omega:.9g} rad/s, WOB = {orbit.wob:.9g} N")


def resolved(
    orbit: Orbit,
    free: str,
    condition: Condition,
    tolerance: float = RESOLVED,
    patience: tuple[int, float] = PATIENT,
) -> Orbit:
    """Return the cycle next to an orbit as :func:`settled`, its pieces short enough to follow it.

    Pieces are halved where the defect exceeds `tolerance` times the greatest speed.
    """
    for _ in range(REFINEMENTS):
        orbit = settled(orbit, free, condition, patience)
        coarse = np.flatnonzero(piece_defects(orbit) > tolerance * float(np.abs(orbit.values).max()))
        if not coarse.size:
            return orbit
        orbit = remeshed(orbit, _halved(orbit.mesh, coarse))
    raise ArithmeticError(
        f"the cycle at Omega = {orbit.omega:.9g} rad/s, WOB = {orbit.wob:.9g} N is too steep to resolve"
    )


def _halved(mesh: CycleMesh, pieces: IntArray) -> CycleMesh:
    """Return a mesh whose resolution asks for half of some pieces."""
    limits, spans = mesh.resolution.limits.copy(), slip_spans(mesh.timing)
    for piece in pieces.tolist():
        slip, start, length = int(mesh.slip[piece]), float(mesh.starts[piece]), float(mesh.lengths[piece])
        begin, whole = float(spans[0, slip]), float(spans[1, slip] - spans[0, slip])
        part = bins((start - begin) / whole, (start + length - begin) / whole)
        limits[slip, part] = np.minimum(limits[slip, part], 0.5 * length)
    return replace(mesh, resolution=replace(mesh.resolution, limits=limits))


def free_row(orbit: Orbit) -> FloatArray:
    """Return the derivatives of the free input itself by all unknowns."""
    row = np.zeros(orbit.mesh.size + orbit.timing.vector.size + 1)
    row[-1] = 1.0
    return row


def held_at(free: str, value: float) -> Condition:
    """Return the condition that an input has a value after all."""
    return lambda orbit: ((orbit.omega if free == "Omega" else orbit.wob) - value, free_row(orbit))


def stuck_for(duration: float) -> Condition:
    """Return the condition that the bit rests for a time in each period [s]."""

    def condition(orbit: Orbit) -> tuple[float, FloatArray]:
        releases_by, stops_by, period_by = orbit.timing.derivatives
        row = free_row(orbit)
        row[-1] = 0.0
        row[orbit.mesh.size : -1] = period_by - stops_by.sum(axis=0) + releases_by.sum(axis=0)
        return orbit.timing.stuck - duration, row

    return condition


def slowest_at(speed: float) -> Condition:
    """Return the condition that a bit that never rests has a speed at the beginning of the period [rad/s]."""

    def condition(orbit: Orbit) -> tuple[float, FloatArray]:
        column = orbit.mesh.columns[0, 0]
        row = free_row(orbit)
        row[-1], row[column] = 0.0, 1.0
        return float(orbit.values[column]) - speed, row

    return condition


def jacobian(orbit: Orbit, free: str) -> tuple[FloatArray, FloatArray]:
    """Return the equations' residual and its derivatives by values, timing and the free input."""
    found = equations(orbit)
    return found.residual, np.column_stack([found.by_values, found.by_timing, found.by_input[free]])


def _size(step: FloatArray, orbit: Orbit, free: str) -> float:
    """Return the size of a step, that of the free input relative to its value."""
    value = orbit.omega if free == "Omega" else orbit.wob
    return max(float(np.abs(step[:-1]).max()), abs(float(step[-1])) / (1.0 + value))


@dataclass(frozen=True)
class _System:
    """An orbit, the residual of its equations and of the condition, and the derivatives of that."""

    orbit: Orbit
    residual: FloatArray
    matrix: FloatArray

    @classmethod
    def of(cls, orbit: Orbit, free: str, condition: Condition) -> _System:
        residual, matrix = jacobian(orbit, free)
        further, row = condition(orbit)
        return cls(orbit, np.append(residual, further), np.vstack([matrix, row]))

    @property
    def size(self) -> float:
        return float(np.abs(self.residual).max())

    def newton_step(self) -> FloatArray:
        try:
            return np.asarray(np.linalg.solve(self.matrix, -self.residual), np.float64)
        except np.linalg.LinAlgError:
            return np.full(self.residual.size, np.nan)


def advanced(orbit: Orbit, free: str, step: FloatArray) -> Orbit | None:
    """Return the orbit after a step of all unknowns; None if that makes no sense."""
    size, times = orbit.mesh.size, step[orbit.mesh.size : -1]
    if not np.isfinite(step).all() or float(np.abs(step[:size]).max()) > LARGEST_CHANGE * float(orbit.values.max()):
        return None
    value = (orbit.omega if free == "Omega" else orbit.wob) + float(step[-1])
    moved = orbit.mesh.moved(times)
    if not moved.timing.ordered or value <= 0.0:
        return None
    return remeshed(replace(with_input(orbit, free, value), values=orbit.values + step[:size]), moved)


def remeshed(orbit: Orbit, moved: CycleMesh) -> Orbit:
    """Return an orbit whose pieces have been moved, on those that its timing and resolution ask for.

    Where these are the same pieces, the values are kept as they are; otherwise the speed is.
    """
    mesh = cycle_mesh(orbit.parameters, moved.timing, moved.resolution)
    if mesh.size > MOST_UNKNOWNS:
        raise ArithmeticError(f"a cycle of {mesh.size} unknowns was met; expected at most {MOST_UNKNOWNS}")
    same = mesh.size == moved.size and float(np.abs(mesh.starts - moved.starts).max()) < 1e-9
    if same:
        return replace(orbit, mesh=mesh)
    if float(moved.lengths.min()) > 0.0:
        return replace(orbit, mesh=mesh, values=moved.sample(orbit.values, mesh.node_times))
    return stretched(orbit, mesh)


def stretched(orbit: Orbit, mesh: CycleMesh) -> Orbit:
    """Return an orbit on other pieces, each slip stretched to its new place."""
    old, new = slip_spans(orbit.timing), slip_spans(mesh.timing)
    slip = np.repeat(mesh.slip, DEGREE)
    share = (mesh.node_times - new[0, slip]) / (new[1] - new[0])[slip]
    # what ends at a stop has to stay on its piece in spite of rounding
    times = old[0, slip] + np.minimum(share, 1.0 - 1e-14) * (old[1] - old[0])[slip]
    return replace(orbit, mesh=mesh, values=orbit.mesh.sample(orbit.values, times))


def slip_spans(timing: Timing) -> FloatArray:
    """Return where slips begin and end, shape (2, slips); without any, the period."""
    begins, ends = (timing.releases, timing.stops) if timing.slips else (np.zeros(1), timing.vector)
    return np.array([begins, ends])


def piece_defects(orbit: Orbit) -> FloatArray:
    """Return by how much an orbit fails its equation of motion on each piece [rad/s].

    It is measured where no equation was imposed, as the change of speed over the piece that it would make.
    """
    p, mesh = orbit.parameters, orbit.mesh
    basis, between = chebyshev(DEGREE), gauss(DEGREE + 1).nodes
    times, _ = mesh.spread(between)
    nodal = mesh.nodal(orbit.values)
    speed = (nodal @ basis.at(between).T).ravel()
    change = nodal @ (basis.at(between) @ basis.differentiation()).T
    rate = (2.0 * p.impedance * orbit.incident(times) - p.impedance * speed - orbit.curve.torque(speed)) / p.I_B
    return np.abs(change - mesh.lengths[:, None] * rate.reshape(change.shape)).max(axis=1)
