"""The drillstring as a neutral system in the paper's matrix form, eqs. (17) to (20)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...plant.parameters import DrillstringParameters
from ..numerics.arrays import FloatArray
from .difference import DifferenceOperator
from .linear_neutral import LinearNeutral

BIT_SPEED = 1
"""Place of w' in the state (w, w', y)."""


@dataclass(frozen=True)
class NeutralForm:
    """Eq. (17) with x = (w, w', y), u = Omega and f = T, the torque on bit as it acts.

    x'(t) = sum_{k>=1} E_k x'(t - k Gamma) + sum_{k>=0} [A_k x(t - k Gamma) + B_k u(t - k Gamma) + C_k f(t - k Gamma)]

    The paper sums C_k f(x(t - k Gamma)) with f the law (3); while the bit is stuck the torque is no function of x, so
    here it is a signal of its own.

    Attributes
    ----------
    delay : float
        Gamma [s].
    E : ndarray, shape (2, 3, 3)
        E_1 and E_2, eq. (19).
    A : ndarray, shape (3, 3, 3)
        A_0, A_1 = 0 and A_2.
    B, C : ndarray, shape (3, 3)
        B_0, B_1, B_2 and C_0, C_1, C_2, one a row.
    """

    delay: float
    E: FloatArray
    A: FloatArray
    B: FloatArray
    C: FloatArray

    @property
    def difference(self) -> DifferenceOperator:
        """The difference operator, whose stability is the formal stability of the system, eqs. (18) and (20)."""
        return DifferenceOperator.of(self.delay, tuple(self.E))

    def residual(self, rates: FloatArray, states: FloatArray, omegas: FloatArray, torques: FloatArray) -> FloatArray:
        """Return by how much eq. (17) fails along a motion, right side less left.

        Parameters
        ----------
        rates, states : ndarray, shape (..., 3, 3)
            x' and x at t, t - Gamma and t - 2 Gamma, in this order on the axis before the last.
        omegas, torques : ndarray, shape (..., 3)
            Omega [rad/s] and the torque on bit [N m] at these times.

        Returns
        -------
        ndarray, shape (..., 3)
            In rad/s, rad/s^2 and rad/s.
        """
        neutral = np.einsum("kij,...kj->...i", self.E, rates[..., 1:, :])
        retarded = np.einsum("kij,...kj->...i", self.A, states)
        forced = np.einsum("ki,...k->...i", self.B, omegas) + np.einsum("ki,...k->...i", self.C, torques)
        return neutral + retarded + forced - rates[..., 0, :]

    def linearised(self, slope: float) -> LinearNeutral:
        """Return the system about uniform rotation at which the torque on bit has a slope T' [N m s/rad].

        Beside the roots of the drillstring it has two at 0, for the angles w and y, which nothing holds, and the
        chain of 1 + Upsilon exp(-2 Gamma s), which eliminating the waves from the top has brought into eq. (15): no
        motion of the string has it.
        """
        acts = np.zeros_like(self.A)
        acts[:, :, BIT_SPEED] = slope * self.C
        return LinearNeutral(self.delay, self.E, self.A + acts)


def neutral_form(parameters: DrillstringParameters) -> NeutralForm:
    """Return eqs. (14) and (15) as eq. (17)."""
    upsilon, inertia = parameters.reflection, parameters.I_B
    psi = parameters.impedance / inertia
    inverse = 1.0 / (parameters.c_a + parameters.impedance)  # 1 / Lambda
    drive = parameters.transmission  # c_a / Lambda
    E, A, B, C = np.zeros((2, 3, 3)), np.zeros((3, 3, 3)), np.zeros((3, 3)), np.zeros((3, 3))
    E[0, 2, 1] = -2.0 * inertia * inverse
    E[1] = np.diag([0.0, upsilon, -upsilon])
    A[0, 0, 1] = 1.0
    A[0, 1, 1] = -psi
    A[2, 1, 1] = -psi * upsilon
    B[0, 2] = B[2, 2] = drive
    B[1, 1] = 2.0 * psi * drive
    C[0, 1] = -1.0 / inertia
    C[1, 2] = -2.0 * inverse
    C[2, 1] = upsilon / inertia
    return NeutralForm(parameters.travel_time, E, A, B, C)
