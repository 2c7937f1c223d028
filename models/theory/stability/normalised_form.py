"""The drillstring in the paper's normalised form, eqs. (5) and (6), with its energy (7) and the rate of that, (8).

z(sigma, t) is the angle at xi = L sigma, so that z_sigma = L times the twist per length:

    z_tt = a z_ss - d z_t,    0 < sigma < 1,
    z_s(0) = g (z_t(0) - Omega),    z_s(1) = -k z_t(1) - q mu_b sgn z_t(1) - h z_tt(1).

Where the paper prints GL in g, k, q and h it means GJ: only then are these the boundary conditions (2).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from ...plant.parameters import DrillstringParameters
from ..numerics.arrays import FloatArray


@dataclass(frozen=True)
class NormalisedForm:
    """The coefficients of eqs. (5) and (6).

    Attributes
    ----------
    a, d : float
        GJ / (I L^2) [1/s^2] and beta / I [1/s].
    g, k : float
        c_a L / (GJ) and c_b L / (GJ) [s].
    q : float
        W R_b L / (GJ) [1].
    h : float
        I_B L / (GJ) [s^2].
    unit : float
        I L / 2, the energy in J of what eq. (7) counts as one [kg m^2].
    """

    a: float
    d: float
    g: float
    k: float
    q: float
    h: float
    unit: float

    @classmethod
    def of(cls, parameters: DrillstringParameters, wob: float, beta: float = 0.0) -> NormalisedForm:
        """Return the form under a weight on bit [N], with a damping along the string [N s/rad].

        Raises
        ------
        ValueError
            WOB or beta are not finite and >= 0.
        """
        for name, value in (("WOB", wob), ("beta", beta)):
            if not 0.0 <= value < inf:
                raise ValueError(f"{name} is {value}; expected a finite value >= 0")
        p = parameters
        softness = p.L / (p.G * p.J)
        return cls(
            a=1.0 / (softness * p.I * p.L),
            d=beta / p.I,
            g=p.c_a * softness,
            k=p.c_b * softness,
            q=wob * p.R_b * softness,
            h=p.I_B * softness,
            unit=0.5 * p.I * p.L,
        )

    def top_slope(self, top_speed: FloatArray, omega: FloatArray) -> FloatArray:
        """Return z_s(0, t) by the first of eqs. (6), for speeds of the top and the drive [rad/s]."""
        return self.g * (top_speed - omega)

    def bit_slope(self, bit_speed: FloatArray, friction: FloatArray, acceleration: FloatArray) -> FloatArray:
        """Return z_s(1, t) by the second of eqs. (6).

        Parameters
        ----------
        bit_speed, acceleration : ndarray
            z_t(1, t) [rad/s] and z_tt(1, t) [rad/s^2].
        friction : ndarray
            mu_b sgn z_t(1, t), at rest whatever holds the bit.
        """
        return -self.k * bit_speed - self.q * friction - self.h * acceleration

    def energy(self, slopes: FloatArray, speeds: FloatArray, weights: FloatArray, bit_speed: float) -> float:
        """Return E of eq. (7) [1/s^2].

        Parameters
        ----------
        slopes, speeds, weights : ndarray, shape (n,)
            z_s and z_t [rad/s] at points of a quadrature over 0 < sigma < 1, and its weights.
        bit_speed : float
            z_t(1, t) [rad/s].
        """
        string = float(weights @ (self.a * np.square(slopes) + np.square(speeds)))
        return string + self.a * self.h * (bit_speed * bit_speed)

    def energy_rate(
        self, speeds: FloatArray, weights: FloatArray, ends: tuple[float, float], friction: float, omega: float
    ) -> float:
        """Return dE/dt by eq. (8) [1/s^3].

        Parameters
        ----------
        speeds, weights : ndarray, shape (n,)
            As in :meth:`energy`.
        ends : (float, float)
            z_t(0, t) and z_t(1, t) [rad/s].
        friction : float
            As in :meth:`bit_slope`.
        omega : float
            Speed of the drive [rad/s].
        """
        top, bit = ends
        lost = 2.0 * self.d * float(weights @ np.square(speeds))
        lost += 2.0 * self.a * (self.q * friction * bit + self.k * (bit * bit))
        return -2.0 * self.a * self.g * top * (top - omega) - lost
