"""Eqs. (1)-(4) by discontinuous finite elements in space and SciPy's Runge-Kutta method of order 8 in time.

Another family of methods than delays and method of steps: the string is a field, no travel time appears anywhere.
Speed v and scaled torque s = GJ theta_xi / Z are polynomials on each element,

    v_t = c s_xi - (beta / I) v,    s_t = c v_xi,    c = sqrt(GJ / I),

tied to the neighbours by upwind fluxes; at both ends the flux is what the boundary conditions (2) make of the wave that
leaves. Stops and releases of the bit are events of the integrator. Kinks that run through elements are smeared over
their width, so accuracy is that of the elements: halve them to see it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from scipy.integrate import solve_ivp

from tests.oracle.plant import OracleParameters, Program

DEGREE = 6
TOLERANCE = 1e-6
"""Of the integrator, absolute [rad/s] and relative; far below what elements make of a kink."""
TIE = 1e-9
"""A torque that exceeds the static one by this much of it is equal to it; far below what the integrator leaves."""


@dataclass(frozen=True)
class FieldSolution:
    """The solution at the times asked for.

    Attributes
    ----------
    times, bit_speed, top_speed, energy, string_loss : ndarray, shape (n,)
        In s, rad/s, J; `energy` is that of string and bit, `string_loss` what beta has taken.
    stops, releases : ndarray
        When the bit came to rest and broke loose [s].
    """

    times: np.ndarray
    bit_speed: np.ndarray
    top_speed: np.ndarray
    energy: np.ndarray
    string_loss: np.ndarray
    stops: np.ndarray
    releases: np.ndarray


def _lobatto(degree: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return nodes on [-1, 1], the matrix that differentiates there, and the inverse of the mass matrix."""
    top = np.zeros(degree + 1)
    top[-1] = 1.0
    nodes = np.concatenate([[-1.0], legendre.legroots(legendre.legder(top)), [1.0]])
    values = legendre.legvander(nodes, degree)
    slopes = np.stack([legendre.legval(nodes, legendre.legder(row)) for row in np.eye(degree + 1)], axis=1)
    inverse = np.linalg.inv(values)
    norms = 2.0 / (2.0 * np.arange(degree + 1) + 1.0)
    return nodes, slopes @ inverse, values @ np.diag(1.0 / norms) @ values.T


class _String:
    """The right-hand side. State: v and s of all elements, then bit speed [rad/s] and energy lost along the string."""

    def __init__(self, p: OracleParameters, elements: int, beta: float, rigid: bool):
        self.p, self.elements, self.beta, self.rigid = p, elements, beta, rigid
        self.nodes, self.difference, inverse_mass = _lobatto(DEGREE)
        self.mass = np.linalg.inv(inverse_mass)
        self.left, self.right = inverse_mass[:, 0], inverse_mass[:, -1]
        self.rate = 2.0 * elements / (p.L * math.sqrt(p.I / (p.G * p.J)))
        self.direction = 0
        self.omega = self.wob = (0.0, 0.0, 0.0)  # start [s], value there, slope

    def start(self) -> np.ndarray:
        field = np.empty((2, self.elements, DEGREE + 1))
        field[0], field[1] = self.p.initial_speed, -self.p.initial_torque / self.p.impedance
        return np.concatenate([field.ravel(), [self.p.initial_speed, 0.0]])

    def field(self, state: np.ndarray) -> np.ndarray:
        return state[:-2].reshape(2, self.elements, DEGREE + 1)

    def top_speed(self, time: float, state: np.ndarray) -> float:
        """Return v at xi = 0 by the first of eqs. (2) and v + s, which arrives there."""
        omega = _line(self.omega, time)
        if self.rigid:
            return omega
        z, c_a = self.p.impedance, self.p.c_a
        arriving = state[0] + state[self.elements * (DEGREE + 1)]
        return (z * arriving + c_a * omega) / (z + c_a)

    def load(self, state: np.ndarray) -> float:
        """Return the torque with which the string drives the bit [N m]: v - s arrives there."""
        v, s = self.field(state)
        return -self.p.impedance * (state[-2] - (v[-1, -1] - s[-1, -1]))

    def static(self, time: float) -> float:
        return _line(self.wob, time) * self.p.R_b * self.p.mu_sb

    def excess(self, time: float, state: np.ndarray) -> float:
        """Return by how much the torque on the bit exceeds what can hold it, ties included [N m]."""
        static = self.static(time)
        return abs(self.load(state)) - static - TIE * max(1.0, static)

    def friction(self, time: float, speed: float) -> float:
        """Eqs. (3) and (4), with the direction of the slip for sgn so that it goes on smoothly through zero."""
        p = self.p
        # steps that the integrator tries and rejects may go far beyond zero
        fading = math.exp(min(-p.gamma_b / p.v_f * self.direction * speed, 50.0))
        dry = _line(self.wob, time) * p.R_b * (p.mu_cb + (p.mu_sb - p.mu_cb) * fading)
        return p.c_b * speed + self.direction * dry

    def __call__(self, time: float, state: np.ndarray) -> np.ndarray:
        v, s = self.field(state)
        top, bit = self.top_speed(time, state), state[-2]
        speed, torque = np.empty(self.elements + 1), np.empty(self.elements + 1)
        speed[1:-1] = 0.5 * (v[:-1, -1] + v[1:, 0] + s[1:, 0] - s[:-1, -1])
        torque[1:-1] = 0.5 * (s[:-1, -1] + s[1:, 0] + v[1:, 0] - v[:-1, -1])
        speed[0], torque[0] = top, v[0, 0] + s[0, 0] - top
        speed[-1], torque[-1] = bit, bit - v[-1, -1] + s[-1, -1]
        slope = np.empty_like(state)
        changes = self.field(slope)
        for change, values, faces in ((changes[0], s, torque), (changes[1], v, speed)):
            change[:] = values @ self.difference.T
            change += np.outer(faces[1:] - values[:, -1], self.right) - np.outer(faces[:-1] - values[:, 0], self.left)
            change *= self.rate
        changes[0] -= self.beta / self.p.I * v
        moving = self.direction != 0
        slope[-2] = (self.load(state) - self.friction(time, bit)) / self.p.I_B if moving else 0.0
        slope[-1] = self.beta * self.integral(v * (v @ self.mass)) if self.beta else 0.0
        return slope

    def integral(self, weighted: np.ndarray) -> float:
        """Return the integral along the string of what has been multiplied by the mass matrix of an element."""
        return float(weighted.sum()) * self.p.L / (2.0 * self.elements)

    def energy(self, state: np.ndarray) -> float:
        v, s = self.field(state)
        line = self.integral(v * (v @ self.mass)) + self.integral(s * (s @ self.mass))
        return 0.5 * self.p.I * line + 0.5 * self.p.I_B * state[-2] ** 2

    def outputs(self, time: float, state: np.ndarray) -> np.ndarray:
        """Return a row of a FieldSolution."""
        return np.array([time, state[-2], self.top_speed(time, state), self.energy(state), state[-1]])


def _line(line: tuple[float, float, float], time: float) -> float:
    start, value, slope = line
    return value + slope * (time - start)


def solve_field(
    parameters: OracleParameters,
    omega: Program,
    wob: Program,
    times: np.ndarray,
    *,
    elements: int,
    beta: float = 0.0,
    rigid: bool = False,
) -> FieldSolution:
    """Solve eqs. (1)-(4) with set-valued dry friction from uniform rotation and torque.

    Parameters
    ----------
    parameters : OracleParameters
        Constants and initial history.
    omega, wob : Program
        Speed of the drive [rad/s] and weight on bit [N].
    times : ndarray
        Where the solution is wanted, increasing from above 0 [s].
    elements : int
        Of the string.
    beta : float
        Damping along the string [N s/rad].
    rigid : bool
        Whether the top turns with the drive itself, which is the limit of c_a.

    Raises
    ------
    ArithmeticError
        If the integrator fails.
    """
    string = _String(parameters, elements, beta, rigid)
    state, now, end = string.start(), 0.0, float(times[-1])
    string.direction = int(np.sign(state[-2]))
    breaks = sorted({time for program in (omega, wob) for time in program.times if 0.0 < time < end} | {end})
    rows: list[np.ndarray] = []
    events: dict[bool, list[float]] = {True: [], False: []}
    while now < end:
        until = next(time for time in breaks if time > now)
        string.omega, string.wob = ((now, *program.line(0.5 * (now + until), now)) for program in (omega, wob))
        if string.direction == 0 and string.excess(now, state) >= 0:
            string.direction = int(np.sign(string.load(state)))
        wanted = times[(times > now) & (times < until)]
        run = solve_ivp(
            string,
            (now, until),
            state,
            "DOP853",
            [*wanted, until],
            events=_event(string, now, from_rest=state[-2] == 0),
            rtol=TOLERANCE,
            atol=TOLERANCE,
        )
        if run.status < 0:
            raise ArithmeticError(f"the integrator failed at t = {now:.6g} s: {run.message}")
        rows += [string.outputs(*pair) for pair in zip(run.t, np.transpose(run.y), strict=True) if pair[0] in times]
        if run.status == 0:
            now, state = until, run.y[:, -1]
            continue
        before, now, state = now, float(run.t_events[0][0]), run.y_events[0][0]
        if now == before:
            raise ArithmeticError(f"the bit neither sticks nor slips at t = {now:.6g} s")
        events[string.direction != 0].append(now)
        state[-2], string.direction = 0.0, 0 if string.direction else int(np.sign(string.load(state)))
    return FieldSolution(*np.array(rows).T, np.array(events[True]), np.array(events[False]))


def _event(string: _String, start: float, *, from_rest: bool) -> Callable[[float, np.ndarray], float]:
    """Return what falls through zero where a slip ends or, at rest, where the static torque is exceeded.

    The speed of a slip from rest is zero at its start too. The integrator would take that zero for the end of a slip
    that is over within its first step, so it is divided out: what is left starts with the acceleration, above zero.
    """

    def margin(time: float, state: np.ndarray) -> float:
        if not string.direction:
            return -string.excess(time, state)
        if not from_rest:
            return string.direction * state[-2]
        return string.direction * (state[-2] / (time - start) if time > start else string(time, state)[-2])

    margin.terminal, margin.direction = True, -1.0
    return margin
