"""The damped string by a method of lines: both waves on Chebyshev points, integrated by SciPy.

Eqs. (1) to (4) in characteristic variables. Where a wave begins it follows from the boundary condition; everywhere else
from collocation. It needs smooth motion, since a polynomial over the whole string rings at a jump; it follows
the bit while that slips ahead.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import exp

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tests.oracle.plant import OracleParameters

Vector = NDArray[np.float64]


def chebyshev(count: int) -> tuple[Vector, Vector]:
    """Return Chebyshev points on [0, 1] and their differentiation matrix (Trefethen, Spectral Methods in MATLAB)."""
    numbers = np.arange(count + 1)
    x = np.cos(np.pi * numbers / count)
    weights = np.ones(count + 1)
    weights[0] = weights[-1] = 2.0
    weights *= (-1.0) ** numbers
    distance = x[:, None] - x[None, :]
    matrix = np.outer(weights, 1.0 / weights) / (distance + np.eye(count + 1))
    matrix -= np.diag(matrix.sum(axis=1))
    return 0.5 * (1.0 - x), -2.0 * matrix


@dataclass(frozen=True)
class DampedLines:
    """The string in uniform rotation before the start, its torque that of its damping; the drive on a straight line.

    Attributes
    ----------
    beta : float
        Damping per unit length [N s/rad].
    weight : float
        On bit [N].
    omega : (float, float)
        Drive speed at the start [rad/s] and its slope [rad/s^2].
    points : int
        Degree of the polynomials.
    """

    parameters: OracleParameters
    beta: float
    weight: float
    omega: tuple[float, float]
    points: int = 64

    def follow(self, times: Vector) -> tuple[Vector, Vector, float | None]:
        """Return bit and top speed at times [rad/s], up to where the bit comes to rest, and when that is [s]."""

        def comes_to_rest(_: float, state: Vector) -> float:
            return state[-1]

        comes_to_rest.terminal = True  # type: ignore[attr-defined]
        run = solve_ivp(
            self._rate, (0.0, times[-1]), self._begin(), "DOP853", times, rtol=1e-9, atol=1e-9, events=comes_to_rest
        )
        tops = [np.add(*self._lines(state, time))[0] for state, time in zip(run.y.T, run.t, strict=True)]
        return run.y[-1], np.array(tops), float(run.t_events[0][0]) if run.status == 1 else None

    def _begin(self) -> Vector:
        p, n = self.parameters, self.points
        depth, _ = chebyshev(n)
        torque = p.initial_torque + self.beta * p.initial_speed * p.L * (1.0 - depth)
        up = 0.5 * p.initial_speed - torque / (2 * p.impedance)
        down = 0.5 * p.initial_speed + torque / (2 * p.impedance)
        return np.concatenate([up[:-1], down[1:], [p.initial_speed]])

    def _lines(self, state: Vector, time: float) -> tuple[Vector, Vector]:
        """Return the waves up and down at all points, what begins at an end by its boundary condition."""
        p, n = self.parameters, self.points
        omega = self.omega[0] + self.omega[1] * time
        up = np.append(state[:n], state[-1] - state[2 * n - 1])
        down = np.insert(state[n : 2 * n], 0, p.transmission * omega - p.reflection * state[0])
        return up, down

    def _rate(self, time: float, state: Vector) -> Vector:
        p = self.parameters
        up, down = self._lines(state, time)
        lost = self.beta / (2 * p.I) * (up + down)
        speed = state[-1]
        friction = p.mu_cb + (p.mu_sb - p.mu_cb) * exp(-p.gamma_b * abs(speed) / p.v_f)
        push = 2 * p.impedance * down[-1] - (p.impedance + p.c_b) * speed - self.weight * p.R_b * friction
        along = self._slopes
        return np.concatenate([(along @ up - lost)[:-1], (-(along @ down) - lost)[1:], [push / p.I_B]])

    @cached_property
    def _slopes(self) -> Vector:
        """The derivative along the string, per travel time."""
        return chebyshev(self.points)[1] / self.parameters.travel_time
