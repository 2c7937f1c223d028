"""The solvable set of law (9) as printed: the loop it forms with the sliding top, a quadratic in the top speed.

The top answers the drive at once, ydot = u + b Omega, where b = c_a / Lambda and u = (2 Z / Lambda) U is what the
incident wave U brings. With Omega = c_1 ydot + sigma - q / ydot, which is law (9), this is

    (1 - b c_1) ydot^2 - (u + b sigma) ydot + b q = 0,
    sigma = 2 sqrt(c_b (1 - c_1) / c_a) v + 2 sqrt(c_2 (1 - c_1)) r,  q = c_2 r^2 + 2 sqrt(c_2 c_b / c_a) v r,

so that between two waves no drive speed at all obeys the law. A damping along the string changes the incident
wave and nothing else.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt

import numpy as np
from numpy.typing import ArrayLike

from ..controllers.laws import DissipativeLaw
from ..plant.parameters import DrillstringParameters
from .numerics.arrays import BoolArray, FloatArray


@dataclass(frozen=True)
class PrintedLoop:
    """The loop between a string and law (9) as printed, for one wanted bit speed; neither guarded nor limited.

    Arguments of the methods are broadcast against each other, and results have their shape.

    Attributes
    ----------
    transmission : float
        b = c_a / Lambda, at once from the drive to the top, in (0, 1).
    wave_gain : float
        2 Z / Lambda, from the incident wave to the top speed.
    c_1 : float
        Of the law, below 1.
    steady, steady_bit : float
        sigma = steady + steady_bit v [rad/s], [1].
    pole, pole_bit : float
        q = pole + pole_bit v [rad^2/s^2], [rad/s].
    """

    transmission: float
    wave_gain: float
    c_1: float
    steady: float
    steady_bit: float
    pole: float
    pole_bit: float

    @classmethod
    def of(cls, parameters: DrillstringParameters, law: DissipativeLaw, speed_ref: float) -> PrintedLoop:
        """Return the loop of a string and a law, with a wanted bit speed [rad/s].

        Raises
        ------
        ValueError
            The wanted speed is not finite, or c_1 < 1 or c_2 >= 0 do not hold.
        """
        if not -inf < speed_ref < inf:
            raise ValueError(f"speed_ref is {speed_ref} rad/s; expected a finite value")
        if not law.c_1 < 1.0 or law.c_2 < 0.0:
            raise ValueError(f"c_1 is {law.c_1} and c_2 is {law.c_2}; expected c_1 < 1 and c_2 >= 0")
        ratio, rest = law.c_b / law.c_a, 1.0 - law.c_1
        return cls(
            transmission=parameters.transmission,
            wave_gain=2.0 * parameters.impedance / (parameters.c_a + parameters.impedance),
            c_1=law.c_1,
            steady=2.0 * sqrt(law.c_2 * rest) * speed_ref,
            steady_bit=2.0 * sqrt(ratio * rest),
            pole=law.c_2 * speed_ref * speed_ref,
            pole_bit=2.0 * sqrt(law.c_2 * ratio) * speed_ref,
        )

    def wave(self, top_speed: ArrayLike, bit_speed: ArrayLike) -> FloatArray:
        """Return the incident wave [rad/s] with which a top speed, not 0 [rad/s], solves the loop."""
        top, bit = np.asarray(top_speed, np.float64), np.asarray(bit_speed, np.float64)
        b = self.transmission
        own = (1.0 - b * self.c_1) * top + b * (self.pole + self.pole_bit * bit) / top
        return (own - b * (self.steady + self.steady_bit * bit)) / self.wave_gain

    def gap(self, bit_speed: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return between which waves [rad/s] there is no solution; both are NaN where there is one for all waves."""
        bit = np.asarray(bit_speed, np.float64)
        b = self.transmission
        product = b * (self.pole + self.pole_bit * bit) * (1.0 - b * self.c_1)
        half = 2.0 * np.sqrt(np.where(product > 0.0, product, np.nan)) / self.wave_gain
        middle = -b * (self.steady + self.steady_bit * bit) / self.wave_gain
        return middle - half, middle + half

    def solvable(self, bit_speed: ArrayLike, wave: ArrayLike) -> BoolArray:
        """Return whether any drive speed obeys the law."""
        low, high = self.gap(bit_speed)
        incident = np.asarray(wave, np.float64)
        return ~((incident > low) & (incident < high))

    def top_speeds(self, bit_speed: ArrayLike, wave: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return both top speeds that solve the loop, the one nearer to 0 first [rad/s]; NaN where there is none."""
        bit, incident = np.broadcast_arrays(np.asarray(bit_speed, np.float64), np.asarray(wave, np.float64))
        b = self.transmission
        square = 1.0 - b * self.c_1
        linear = self.wave_gain * incident + b * (self.steady + self.steady_bit * bit)
        constant = b * (self.pole + self.pole_bit * bit)
        discriminant = linear * linear - 4.0 * square * constant
        # the greater first, from which the other follows without cancellation
        greater = np.copysign(np.sqrt(np.where(discriminant >= 0.0, discriminant, np.nan)), linear) + linear
        return 2.0 * constant / greater, 0.5 * greater / square
