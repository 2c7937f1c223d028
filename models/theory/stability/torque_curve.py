"""The torque on bit, eqs. (3) and (4), as a curve over the speed, with its slope: what stability and cycles need."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, log
from typing import overload

import numpy as np

from ...plant.friction import Friction
from ...plant.parameters import DrillstringParameters
from ..numerics.arrays import FloatArray


@dataclass(frozen=True)
class TorqueCurve:
    """Torque on a bit that turns forwards, T(v) = c_b v + dry friction.

    It is analytic, and continued as such to v <= 0, where it is not the torque of a bit.

    Attributes
    ----------
    viscosity : float
        c_b [N m s/rad].
    friction : Friction
        Dry friction at the lever W R_b [N m].
    """

    viscosity: float
    friction: Friction

    @classmethod
    def of(cls, parameters: DrillstringParameters, wob: float) -> TorqueCurve:
        """Return the curve under a weight on bit [N]; ValueError unless that is finite and >= 0."""
        if not isfinite(wob) or wob < 0.0:
            raise ValueError(f"WOB is {wob}; expected a finite value >= 0")
        return cls(viscosity=parameters.c_b, friction=Friction.of(parameters, wob * parameters.R_b))

    @property
    def static(self) -> float:
        """Greatest torque that holds a bit at rest [N m]."""
        return self.friction.static

    @overload
    def dry(self, speed: float) -> float: ...
    @overload
    def dry(self, speed: FloatArray) -> FloatArray: ...
    def dry(self, speed: float | FloatArray) -> float | FloatArray:
        """Return the dry friction in T [N m] at bit speeds [rad/s]."""
        return self.friction.at(1.0, speed, np.exp)[1]

    @overload
    def torque(self, speed: float) -> float: ...
    @overload
    def torque(self, speed: FloatArray) -> FloatArray: ...
    def torque(self, speed: float | FloatArray) -> float | FloatArray:
        """Return T [N m] at bit speeds [rad/s]."""
        return self.viscosity * speed + self.dry(speed)

    @overload
    def slope(self, speed: float) -> float: ...
    @overload
    def slope(self, speed: FloatArray) -> FloatArray: ...
    def slope(self, speed: float | FloatArray) -> float | FloatArray:
        """Return T' [N m s/rad] at bit speeds [rad/s]."""
        return self.viscosity + self.friction.at(1.0, speed, np.exp)[2]

    def speed_of_slope(self, slope: float) -> float | None:
        """Return the bit speed [rad/s] at which T' is `slope` [N m s/rad]; None if there is none above rest."""
        return self.friction.speed_of_slope(slope - self.viscosity, log)
