"""The stick-slip limit cycle: period, peak, share of rest and stability, found as a solution of its own equations."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from scipy.optimize import minimize_scalar

from ...plant.parameters import DrillstringParameters
from ..numerics.arrays import ComplexArray, FloatArray
from ..numerics.interpolation import chebyshev, gauss
from .equations import Orbit
from .floquet import difference_radius, leading_multiplier, multipliers
from .guess import simulated_cycle
from .mesh import DEGREE, echo_cuts
from .solver import held_at, piece_defects, resolved

LONGEST = 0.25
"""Longest piece that is tried, in travel times."""
ALLOWED = 1e-9
"""By how much, relative to the static torque or in rad/s, rounding may seem to break the law of friction."""


@dataclass(frozen=True)
class LimitCycle:
    """A cycle of the bit under constant Omega and WOB.

    Attributes
    ----------
    omega, wob : float
        Drive speed [rad/s] and weight on bit [N].
    period : float
        In s.
    peak : float
        Greatest bit speed [rad/s].
    stuck_fraction : float
        Part of the period in which the bit is held, 0 to 1.
    multiplier : float
        What is left of a small disturbance after a period, in the long run: the modulus of the greatest Floquet
        multiplier but that of a shift in time. Above 1 the cycle is unstable. It is never below
        `difference_multiplier`.
    multipliers : ndarray of complex
        All Floquet multipliers outside the circle of radius `difference_multiplier`, that of a shift in time, 1,
        among them.
    difference_multiplier : float
        |Upsilon|^(period / 2 Gamma), by which the waves alone shrink.
    releases, stops : tuple of float
        When the bit breaks loose and stops [s], the first release being 0; empty if it never rests.
    defect : float
        By how much the cycle fails its equation of motion between the points at which that was imposed [rad/s].
    orbit : Orbit
        The motion itself.
    """

    omega: float
    wob: float
    period: float
    peak: float
    stuck_fraction: float
    multiplier: float
    multipliers: ComplexArray
    difference_multiplier: float
    releases: tuple[float, ...]
    stops: tuple[float, ...]
    defect: float
    orbit: Orbit

    def bit_speed(self, times: FloatArray) -> FloatArray:
        """Return the bit speed [rad/s] at times [s] since the first release, or since it was slowest."""
        return self.orbit.speed(np.asarray(times, dtype=np.float64))


def limit_cycle(parameters: DrillstringParameters, omega: float, wob: float) -> LimitCycle:
    """Return the stick-slip cycle at a drive speed and a weight on bit.

    A short coarse run of the plant from rest, or from stick-slip at a lower drive speed if that ends in steady
    rotation, tells how the bit slips. The cycle itself is the solution of its equations over one period (see
    :mod:`models.theory.cycle.equations`), by collocation on pieces that end at all echoes of stops and releases, and
    Newton's method. Source: Saldivar et al. (2011), eqs. (2) to (4) and (14).

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    omega, wob : float
        Drive speed [rad/s] and weight on bit [N], both above 0.

    Returns
    -------
    LimitCycle
        The cycle with its measures.

    Raises
    ------
    ValueError
        Omega or WOB are not finite and > 0, or the run does not end in a cycle in which the bit sticks and slips
        forwards.
    ArithmeticError
        The equations cannot be solved, or what solves them breaks the law of friction.
    """
    for name, value in (("Omega", omega), ("WOB", wob)):
        if not 0.0 < value < inf:
            raise ValueError(f"{name} is {value}; expected a finite value > 0")
    guess = simulated_cycle(parameters, omega, wob, LONGEST * parameters.travel_time)
    orbit = resolved(guess, "Omega", held_at("Omega", omega))
    if (broken := broken_law(orbit)) is not None:
        raise ArithmeticError(f"no stick-slip cycle at Omega = {omega} rad/s, WOB = {wob} N: {broken}")
    return measured(orbit)


def measured(orbit: Orbit) -> LimitCycle:
    """Measure a cycle: period, peak, share of rest and Floquet multipliers.

    Parameters
    ----------
    orbit : Orbit
        A solution of the equations of a cycle, as of :func:`models.theory.cycle.solver.resolved`.

    Returns
    -------
    LimitCycle
        The cycle with its measures, of which each has its unit there.
    """
    found, timing = multipliers(orbit), orbit.timing
    circle, leading = difference_radius(orbit), leading_multiplier(found)
    return LimitCycle(
        omega=orbit.omega,
        wob=orbit.wob,
        period=timing.period,
        peak=peak_speed(orbit),
        stuck_fraction=timing.stuck / timing.period,
        multiplier=circle if leading is None else abs(leading),
        multipliers=found,
        difference_multiplier=circle,
        releases=tuple(timing.releases.tolist()),
        stops=tuple(timing.stops.tolist()),
        defect=float(piece_defects(orbit).max()),
        orbit=orbit,
    )


def peak_speed(orbit: Orbit) -> float:
    """Return the greatest bit speed in a cycle.

    Parameters
    ----------
    orbit : Orbit
        The cycle.

    Returns
    -------
    float
        Greatest speed, between the nodes too [rad/s].
    """
    nodal, basis = orbit.mesh.nodal(orbit.values), chebyshev(DEGREE)
    piece, node = divmod(int(np.argmax(nodal)), DEGREE + 1)
    around = nodal[[piece - 1, piece, (piece + 1) % len(nodal)]]

    def negative_speed(place: float) -> float:
        """Of places 0 to 3 on the piece with the greatest value and its neighbours."""
        number = min(int(place), 2)
        return -float((basis.at(np.array([place - number])) @ around[number])[0])

    middle, reach = 1.0 + float(basis.nodes[node]), 0.1
    found = minimize_scalar(negative_speed, bounds=(middle - reach, middle + reach), method="bounded")
    return max(float(nodal.max()), -float(found.fun))


def broken_law(orbit: Orbit) -> str | None:
    """Return how a solution of the equations of a cycle breaks the part of the law of friction they leave out, if so.

    While the bit rests the string's torque must stay below the static one, and while it slips it must turn forwards.
    Source: Saldivar et al. (2011), eqs. (3) and (4).

    Parameters
    ----------
    orbit : Orbit
        A solution of the equations of a cycle.

    Returns
    -------
    str or None
        What would break the law, as the end of a sentence; None if nothing does.
    """
    if float(orbit.values.min()) < -ALLOWED:
        return "it would turn backwards before it stops"
    times = _resting_times(orbit)
    if not times.size:
        return None
    share = 2.0 * orbit.parameters.impedance * orbit.incident(times) / orbit.curve.static
    if float(np.abs(share).max()) <= 1.0 + ALLOWED:
        return None
    excess = 100.0 * (float(np.abs(share).max()) - 1.0)
    return f"the string's torque on the resting bit would be {excess:.3g} % above what can hold it"


def _resting_times(orbit: Orbit) -> FloatArray:
    """Return times at which the bit rests: at all echoes, where the torque has its kinks, and between them."""
    timing = orbit.timing
    echoes = [cut.time for cut in echo_cuts(orbit.parameters, timing, orbit.mesh.resolution)] if timing.slips else []
    times: list[FloatArray] = []
    for stop, release in zip(timing.stops.tolist(), [*timing.releases[1:].tolist(), timing.period], strict=False):
        marks = np.array([stop, *(time for time in echoes if stop < time < release), release])
        times.append((marks[:-1, None] + np.diff(marks)[:, None] * np.array([0.0, *gauss(4).nodes])).ravel())
    return np.concatenate(times) if times else np.zeros(0)
