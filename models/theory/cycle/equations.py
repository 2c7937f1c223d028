"""A cycle as the solution of equations over one period.

While the bit slips it obeys model eq. (7); with the period T known, the incident wave at the bit is its own past,

    d(t) = D(t - Gamma) = c_a Omega / (2 Z) - sum over k >= 1 of Upsilon^k v(t - 2 k Gamma),    v(t + T) = v(t),

so that no wave is left as an unknown. What fixes when the bit stops and breaks loose is v = 0 at each stop and
2 Z d = W R_b mu_sb at each release; a bit that never rests has a least speed at the beginning of the period instead.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, log

import numpy as np

from ...plant.parameters import DrillstringParameters
from ..numerics.arrays import FloatArray
from ..numerics.interpolation import chebyshev, gauss
from ..stability.torque_curve import TorqueCurve
from .mesh import DEGREE, CycleMesh, Timing

FAINTEST = 1e-17
"""Echoes are added up while more of them than this is left."""
ROWS = 256
"""Times for which echoes are added up at once, to bound the memory."""


@dataclass(frozen=True)
class Orbit:
    """A periodic motion, or an approximation of one.

    Attributes
    ----------
    parameters : DrillstringParameters
        The string.
    omega, wob : float
        Drive speed [rad/s] and weight on bit [N].
    mesh : CycleMesh
        The pieces of a period.
    values : ndarray, shape (mesh.size,)
        Bit speed at the nodes [rad/s].
    """

    parameters: DrillstringParameters
    omega: float
    wob: float
    mesh: CycleMesh
    values: FloatArray

    @property
    def timing(self) -> Timing:
        """Return the times at which the bit slips."""
        return self.mesh.timing

    @property
    def curve(self) -> TorqueCurve:
        """The torque on bit."""
        return TorqueCurve.of(self.parameters, self.wob)

    def speed(self, times: FloatArray) -> FloatArray:
        """Return the bit speed at any times [rad/s], time 0 being the first release or, without one, the slowest."""
        return self.mesh.sample(self.values, np.mod(times, self.timing.period))

    def incident(self, times: FloatArray) -> FloatArray:
        """Return the down-going wave d incident at the bit at times of the period [rad/s]."""
        echoes, _ = echo_matrix(self, times, np.zeros((times.size, self.timing.vector.size)))
        return self.parameters.c_a * self.omega / (2.0 * self.parameters.impedance) - echoes @ self.values


@dataclass(frozen=True)
class Equations:
    """Residual of the equations of a cycle at an orbit, in rad/s, and its derivatives.

    Attributes
    ----------
    residual : ndarray, shape (m,)
        First of the motion, then one for each unknown time.
    by_values : ndarray, shape (m, mesh.size)
        Derivatives by the values.
    by_timing : ndarray, shape (m, timing.vector.size)
        By the timing's vector, the pieces moving with it and the values at their nodes kept.
    by_input : dict of str to ndarray, each of shape (m,)
        By "Omega" and "WOB".
    """

    residual: FloatArray
    by_values: FloatArray
    by_timing: FloatArray
    by_input: dict[str, FloatArray]


def echo_matrix(orbit: Orbit, times: FloatArray, by_timing: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the echoes that reach the bit, sum of Upsilon^k v(t - 2 k Gamma), as a matrix on the values.

    Parameters
    ----------
    orbit : Orbit
        The motion.
    times : ndarray, shape (n,)
        Within the period [s].
    by_timing : ndarray, shape (n, timing.vector.size)
        Derivatives of the times.

    Returns
    -------
    matrix : ndarray, shape (n, mesh.size)
    by_timing : ndarray, shape (n, timing.vector.size)
        Derivatives of the sums with the values kept.
    """
    reflection, mesh = abs(orbit.parameters.reflection), orbit.mesh
    matrix = np.zeros((times.size, mesh.size + 1))
    moved = np.zeros((times.size, orbit.timing.vector.size))
    if reflection == 0.0:
        return matrix[:, :-1], moved
    count = ceil(log(FAINTEST) / log(reflection))
    slopes = mesh.nodal(orbit.values) @ chebyshev(DEGREE).differentiation().T / mesh.lengths[:, None]
    for begin in range(0, times.size, ROWS):
        rows = slice(begin, begin + ROWS)
        _add_echoes(orbit, times[rows], by_timing[rows], slopes, matrix[rows], moved[rows], count)
    return matrix[:, :-1], moved


def _add_echoes(
    orbit: Orbit,
    times: FloatArray,
    by_timing: FloatArray,
    slopes: FloatArray,
    matrix: FloatArray,
    moved: FloatArray,
    count: int,
) -> None:
    """Add `count` echoes to the rows of `matrix`, whose last column takes what is multiplied by a speed of zero."""
    mesh, period = orbit.mesh, orbit.timing.period
    k = np.arange(1, count + 1)
    past = times[:, None] - 2.0 * orbit.parameters.travel_time * k
    periods = np.maximum(np.ceil(-past / period), 0.0)
    piece, place = mesh.locate((past + periods * period).ravel())
    row, number = np.divmod(np.flatnonzero(piece >= 0), count)
    piece, place = piece[piece >= 0], place[piece >= 0]
    weights = chebyshev(DEGREE).at(place) * np.power(orbit.parameters.reflection, k)[number, None]
    columns = mesh.columns[piece]
    flat = row[:, None] * matrix.shape[1] + np.where(columns < 0, matrix.shape[1] - 1, columns)
    matrix += np.bincount(flat.ravel(), weights.ravel(), matrix.size).reshape(matrix.shape)
    drift = by_timing[row] + periods[row, number, None] * orbit.timing.derivatives[2]
    drift -= mesh.starts_by[piece] + place[:, None] * mesh.lengths_by[piece]
    np.add.at(moved, row, np.einsum("ij,ij->i", weights, slopes[piece])[:, None] * drift)


def equations(orbit: Orbit) -> Equations:
    """Return the equations of a cycle for an orbit."""
    p, mesh, curve = orbit.parameters, orbit.mesh, orbit.curve
    times, times_by = mesh.spread(gauss(DEGREE).nodes)
    releases_by = orbit.timing.derivatives[0]
    all_times = np.concatenate([times, orbit.timing.releases])
    echoes, echoes_by = echo_matrix(orbit, all_times, np.concatenate([times_by, releases_by]))
    drive = p.c_a / (2.0 * p.impedance)
    incident = drive * orbit.omega - echoes @ orbit.values
    motion = Motion.of(mesh)
    at, change = motion.at[:, :-1], motion.change[:, :-1]
    speed = at @ orbit.values
    inertia, twice = motion.lengths / p.I_B, 2.0 * p.impedance
    accelerating = twice * incident[: mesh.size] - p.impedance * speed - curve.torque(speed)
    damping = inertia * (p.impedance + curve.slope(speed))
    events = _event_rows(orbit)
    count = orbit.timing.slips
    held = incident[mesh.size :] - curve.static / twice
    residual = np.concatenate([change @ orbit.values - inertia * accelerating, events @ orbit.values, held])
    pushed = (twice * inertia)[:, None]
    by_values = change + damping[:, None] * at + pushed * echoes[: mesh.size]
    by_lengths = -(accelerating / p.I_B)[:, None] * np.repeat(mesh.lengths_by, DEGREE, axis=0)
    by_timing = by_lengths + pushed * echoes_by[: mesh.size]
    none = np.zeros(len(events))
    dry = curve.dry(speed) / orbit.wob
    return Equations(
        residual,
        np.concatenate([by_values, events, -echoes[mesh.size :]]),
        np.concatenate([by_timing, np.zeros((len(events), times_by.shape[1])), -echoes_by[mesh.size :]]),
        {
            "Omega": np.concatenate([-twice * drive * inertia, none, np.full(count, drive)]),
            "WOB": np.concatenate([inertia * dry, none, np.full(count, -curve.static / twice / orbit.wob)]),
        },
    )


@dataclass(frozen=True)
class Motion:
    """Matrices from the values to what the equation of motion needs at the Gauss points of all pieces.

    Attributes
    ----------
    at, change : ndarray, shape (mesh.size, mesh.size + 1)
        To the speed, and to its derivative times the length of the piece; the last column belongs to the value that
        the mesh takes for zero.
    lengths : ndarray, shape (mesh.size,)
        Of the piece of each point [s].
    """

    at: FloatArray
    change: FloatArray
    lengths: FloatArray

    @classmethod
    def of(cls, mesh: CycleMesh) -> Motion:
        """Return the matrices of a mesh."""
        basis = chebyshev(DEGREE)
        to_points = basis.at(gauss(DEGREE).nodes)
        shape = mesh.size, mesh.size + 1
        at, change = np.zeros(shape), np.zeros(shape)
        rows = np.arange(mesh.size).reshape(-1, DEGREE, 1)
        columns = mesh.columns[:, None, :]
        at[rows, columns] = to_points
        change[rows, columns] = to_points @ basis.differentiation()
        return cls(at, change, np.repeat(mesh.lengths, DEGREE))


def _event_rows(orbit: Orbit) -> FloatArray:
    """Return rows that are zero on the values where the bit rests at each stop, or is slowest at the beginning."""
    mesh = orbit.mesh
    if orbit.timing.slips:
        last = np.flatnonzero(np.diff(mesh.slip, append=orbit.timing.slips))
        return np.eye(mesh.size)[mesh.columns[last, -1]]
    row = np.zeros((1, mesh.size + 1))
    row[0, mesh.columns[0]] = chebyshev(DEGREE).differentiation()[0]
    return row[:, :-1]


def with_input(orbit: Orbit, name: str, value: float) -> Orbit:
    """Return an orbit with another "Omega" [rad/s] or "WOB" [N]."""
    return replace(orbit, omega=value) if name == "Omega" else replace(orbit, wob=value)
