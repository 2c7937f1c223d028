"""The torque on bit, eqs. (3) and (4), as a curve over the speed, with its slope: what stability and cycles need."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import overload

import numpy as np

from ...plant.parameters import DrillstringParameters
from ..arrays import FloatArray


@dataclass(frozen=True)
class TorqueCurve:
    """T(v) = c_b v + coulomb + excess exp(-rate v), the torque on a bit that turns forwards.

    It is analytic, and continued as such to v <= 0, where it is not the torque of a bit.

    Attributes
    ----------
    viscosity : float
        c_b [N m s/rad].
    coulomb, excess : float
        W R_b mu_cb and W R_b (mu_sb - mu_cb) [N m].
    rate : float
        gamma_b / v_f [s/rad].
    """

    viscosity: float
    coulomb: float
    excess: float
    rate: float

    @classmethod
    def of(cls, parameters: DrillstringParameters, wob: float) -> TorqueCurve:
        """Return the curve under a weight on bit [N]; ValueError unless that is finite and >= 0."""
        if not isfinite(wob) or wob < 0.0:
            raise ValueError(f"WOB is {wob}; expected a finite value >= 0")
        lever = wob * parameters.R_b
        return cls(
            viscosity=parameters.c_b,
            coulomb=lever * parameters.mu_cb,
            excess=lever * (parameters.mu_sb - parameters.mu_cb),
            rate=parameters.gamma_b / parameters.v_f,
        )

    @property
    def static(self) -> float:
        """Greatest torque that holds a bit at rest [N m]."""
        return self.coulomb + self.excess

    @overload
    def torque(self, speed: float) -> float: ...
    @overload
    def torque(self, speed: FloatArray) -> FloatArray: ...
    def torque(self, speed: float | FloatArray) -> float | FloatArray:
        """Return T [N m] at bit speeds [rad/s]."""
        return self.viscosity * speed + self.coulomb + self.excess * np.exp(-self.rate * speed)

    @overload
    def slope(self, speed: float) -> float: ...
    @overload
    def slope(self, speed: FloatArray) -> FloatArray: ...
    def slope(self, speed: float | FloatArray) -> float | FloatArray:
        """Return T' [N m s/rad] at bit speeds [rad/s]."""
        return self.viscosity - self.excess * self.rate * np.exp(-self.rate * speed)

    def speed_of_slope(self, slope: float) -> float | None:
        """Return the bit speed [rad/s] at which T' is `slope` [N m s/rad]; None if there is none above rest."""
        fall = self.viscosity - slope
        if fall <= 0.0 or fall >= self.excess * self.rate:
            return None
        return float(np.log(self.excess * self.rate / fall)) / self.rate
