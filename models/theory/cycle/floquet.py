"""Small disturbances of a cycle: its Floquet multipliers.

A disturbance is carried by the up-going wave u that left the bit during the last round trip, and by the bit itself
unless it has just been at rest. Through a period it obeys the linearised equations: while the bit slips,

    I_B dv' = 2 Z dd - (Z + T'(v)) dv,    dd(t) = -Upsilon du(t - 2 Gamma),    du = dv - dd,

from dv = 0 at each release (the bit starts with no acceleration, so it does not matter to first order when it does);
from each stop on dv = 0 again, whatever it was. The multipliers are the eigenvalues of the map over a period. One is
1: the disturbance that shifts the motion in time. The waves alone would shrink by |Upsilon| in a round trip: within a
circle of radius |Upsilon|^(T / 2 Gamma) the map, which is not compact, has a spectrum that is not made of
eigenvalues, and what is found there means nothing: Hale and Verduyn Lunel (1993), chapter 9.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import ceil

import numpy as np

from ..numerics.arrays import ComplexArray, FloatArray
from ..numerics.interpolation import chebyshev, gauss
from .equations import Motion, Orbit
from .mesh import DEGREE, Cut, CycleMesh, echo_cuts, thinned

APART = 1.02
"""Eigenvalues count as such where they exceed the radius of the circle by this factor."""


def difference_radius(orbit: Orbit) -> float:
    """Return |Upsilon|^(T / 2 Gamma), by which the waves alone would shrink in a period."""
    return abs(orbit.parameters.reflection) ** (0.5 * orbit.timing.period / orbit.parameters.travel_time)


def multipliers(orbit: Orbit) -> ComplexArray:
    """Return the Floquet multipliers outside the circle of the difference part, the greatest first.

    That of a shift in time, 1, is among them.
    """
    found = np.linalg.eigvals(PeriodMap(orbit).matrix).astype(np.complex128)
    outside = found[np.abs(found) > APART * difference_radius(orbit)]
    return outside[np.lexsort((-outside.imag, -np.abs(outside)))]


def leading_multiplier(found: ComplexArray) -> complex | None:
    """Return the greatest multiplier but that of a shift in time; None if there is no other outside the circle."""
    rest = np.delete(found, int(np.abs(found - 1.0).argmin())) if found.size else found
    return complex(rest[0]) if rest.size else None


@dataclass(frozen=True)
class PeriodMap:
    """The linear map of disturbances over a period, as a matrix.

    A disturbance is the wave u at the Gauss points of pieces of the last round trip, and, of a bit that never rests,
    its speed.

    Attributes
    ----------
    orbit : Orbit
        The cycle.
    """

    orbit: Orbit

    @cached_property
    def mesh(self) -> CycleMesh:
        """The pieces of the cycle, the speed at the beginning being no unknown."""
        mesh = self.orbit.mesh
        columns = mesh.columns.copy()
        columns[0, 0] = -1
        return replace(mesh, columns=columns)

    @cached_property
    def window(self) -> tuple[FloatArray, FloatArray]:
        """Starts and lengths [s] of the pieces of the wave before the period, from -2 Gamma to 0."""
        round_trip, timing = 2.0 * self.orbit.parameters.travel_time, self.orbit.timing
        events = [Cut(time, 1.0, timing.vector) for time in (*timing.releases.tolist(), *timing.stops.tolist())]
        cuts = [Cut(-round_trip, 1.0, timing.vector), Cut(0.0, 1.0, timing.vector)]
        echoes = echo_cuts(self.orbit.parameters, timing, self.mesh.resolution)
        for number in range(1, ceil(round_trip / timing.period) + 1):
            for cut in (*events, *echoes):
                place = cut.time - number * timing.period
                if -round_trip < place < 0.0:
                    cuts.append(replace(cut, time=place))
        longest = float(self.mesh.lengths.max())
        starts: list[float] = []
        lengths: list[float] = []
        for left, right in pairwise(thinned(sorted(cuts, key=lambda cut: (cut.time, -cut.strength)))):
            count = ceil((right.time - left.time) / longest)
            lengths += [(right.time - left.time) / count] * count
            starts += [left.time + k * (right.time - left.time) / count for k in range(count)]
        return np.array(starts), np.array(lengths)

    @cached_property
    def matrix(self) -> FloatArray:
        """The map, shape (n, n)."""
        orbit, mesh = self.orbit, self.mesh
        p, motion = orbit.parameters, Motion.of(mesh)
        times, _ = mesh.spread(gauss(DEGREE).nodes)
        inertia = motion.lengths / p.I_B
        damping = inertia * (p.impedance + orbit.curve.slope(orbit.speed(times)))
        echo_values, echo_waves = self._echoes(times)
        system = motion.change + damping[:, None] * motion.at + (2.0 * p.impedance * inertia)[:, None] * echo_values
        forcing = np.column_stack([(2.0 * p.impedance * inertia)[:, None] * echo_waves, system[:, -1]])
        speeds = np.zeros((mesh.size + 1, forcing.shape[1]))
        speeds[:-1] = np.linalg.solve(system[:, :-1], -forcing)
        speeds[-1, -1] = 1.0  # the last value is the speed at the beginning
        last = self._last_round_trip(speeds)
        if orbit.timing.slips:
            return last[:, :-1]
        return np.vstack([last, speeds[-2]])

    def _last_round_trip(self, speeds: FloatArray) -> FloatArray:
        """Return the map to the wave of the last round trip of the period."""
        starts, lengths = self.window
        times = (starts[:, None] + lengths[:, None] * gauss(DEGREE).nodes).ravel() + self.orbit.timing.period
        rows = np.zeros((times.size, speeds.shape[1]))
        inside = times > 0.0  # a period may be shorter than a round trip
        echo_values, echo_waves = self._echoes(times[inside])
        rows[inside] = (self._values_at(times[inside]) + echo_values) @ speeds
        rows[inside, :-1] += echo_waves
        rows[~inside, :-1] = self._waves_at(times[~inside])
        return rows

    def _echoes(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return -d at times of the period, as matrices on the values and on the wave before the period."""
        round_trip, reflection = 2.0 * self.orbit.parameters.travel_time, self.orbit.parameters.reflection
        back = np.ceil(times / round_trip).astype(np.intp)
        on_values = np.zeros((times.size, self.mesh.size + 1))
        for number in range(1, int(back.max(initial=0))):
            later = np.flatnonzero(back > number)
            on_values[later] += reflection**number * self._values_at(times[later] - number * round_trip)
        on_waves = self._waves_at(times - back * round_trip)
        return on_values, np.power(reflection, back)[:, None] * on_waves

    def _values_at(self, times: FloatArray) -> FloatArray:
        """Return the matrix from the values, the speed at the beginning being the last, to the speed at times > 0."""
        piece, place = self.mesh.locate(times)
        matrix = np.zeros((times.size, self.mesh.size + 1))
        moving = np.flatnonzero(piece >= 0)
        matrix[moving[:, None], self.mesh.columns[piece[moving]]] = chebyshev(DEGREE).at(place[moving])
        return matrix

    def _waves_at(self, times: FloatArray) -> FloatArray:
        """Return the matrix from the wave before the period to its values at times in (-2 Gamma, 0]."""
        starts, lengths = self.window
        piece = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, None)
        matrix = np.zeros((times.size, starts.size * DEGREE))
        columns = piece[:, None] * DEGREE + np.arange(DEGREE)
        place = (times - starts[piece]) / lengths[piece]
        matrix[np.arange(times.size)[:, None], columns] = gauss(DEGREE).at(place)
        return matrix
