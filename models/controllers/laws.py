"""The control laws of the paper: the drive speed that keeps the energy from growing (9), the weight on bit (22)."""

from __future__ import annotations

from dataclasses import dataclass
from math import copysign, sqrt
from typing import Literal, NamedTuple


class DriveCommand(NamedTuple):
    """Command of a drive law: Omega [rad/s], and whether the singularity guard or saturation made it."""

    omega: float
    guard_active: bool
    limit_active: bool


@dataclass(frozen=True)
class DissipativeLaw:
    """Drive speed law of eq. (9), as printed and in tracking form.

    As printed, with k/g = c_b/c_a and the root over k (1 - c_1) / g only, it cannot hold a drilling speed: with dry
    friction it drains the energy for as long as the bit turns, and it divides by the top speed. The tracking form is
    the same completion of the square in deviations from the wanted rotation.

    Attributes
    ----------
    c_1, c_2 : float
        Free design parameters, c_1 < 1 and c_2 > 0.
    c_a, c_b : float
        Damping of the sliding top and of the bit [N m s/rad].
    form : {"printed", "tracking"}
        Which of the two.
    omega_max : float
        Saturation of Omega, in both directions [rad/s].
    top_speed_min : float
        Singularity guard of the printed form, its least divisor [rad/s]; a smaller top speed is replaced by it, with
        the sign of the speed.
    """

    c_1: float = 0.3
    c_2: float = 2.0
    c_a: float = 2000.0
    c_b: float = 0.03
    form: Literal["printed", "tracking"] = "printed"
    omega_max: float = 40.0
    top_speed_min: float = 0.01

    def command(self, top_speed: float, bit_speed: float, speed_ref: float, torque_ref: float) -> DriveCommand:
        """Return the drive speed.

        Parameters
        ----------
        top_speed, bit_speed, speed_ref : float
            Speeds of top and bit and the speed the bit is to reach [rad/s].
        torque_ref : float
            Torque on bit at that speed [N m]; the tracking form only.
        """
        guarded = False
        if self.form == "printed":
            guarded = abs(top_speed) < self.top_speed_min
            divisor = copysign(self.top_speed_min, top_speed) if guarded else top_speed
            omega = self._printed(top_speed, bit_speed, speed_ref, divisor)
        else:
            omega = self._tracking(top_speed, bit_speed, speed_ref, torque_ref)
        if omega > self.omega_max:
            return DriveCommand(self.omega_max, guarded, True)
        if omega < -self.omega_max:
            return DriveCommand(-self.omega_max, guarded, True)
        return DriveCommand(omega, guarded, False)

    def _printed(self, top_speed: float, bit_speed: float, speed_ref: float, divisor: float) -> float:
        ratio = self.c_b / self.c_a
        rest = 1.0 - self.c_1
        omega = self.c_1 * top_speed
        omega = omega + 2.0 * sqrt(ratio * rest) * bit_speed
        omega = omega + 2.0 * sqrt(self.c_2 * rest) * speed_ref
        omega = omega - self.c_2 * (speed_ref * speed_ref) / divisor
        return omega - 2.0 * sqrt(self.c_2 * ratio) * bit_speed * speed_ref / divisor

    def _tracking(self, top_speed: float, bit_speed: float, speed_ref: float, torque_ref: float) -> float:
        ratio = self.c_b / self.c_a
        rest = 1.0 - self.c_1
        omega = speed_ref + torque_ref / self.c_a
        omega = omega + self.c_1 * (top_speed - speed_ref)
        return omega + 2.0 * sqrt(ratio * rest) * (bit_speed - speed_ref)


@dataclass(frozen=True)
class WeightOnBitLaw:
    """Weight on bit of eq. (22), K_w |bit speed| + WOB_0, at most WOB_max.

    Attributes
    ----------
    gain : float
        K_w [N s/rad]; not in the paper.
    least, greatest : float
        WOB_0 > 0, and WOB_max at which the law saturates [N].
    """

    gain: float = 5000.0
    least: float = 97347.0
    greatest: float = 300000.0

    def weight(self, bit_speed: float) -> float:
        """Return the weight on bit [N] at a bit speed [rad/s]."""
        weight = self._unlimited(bit_speed)
        return weight if weight <= self.greatest else self.greatest

    def limited(self, bit_speed: float) -> bool:
        """Return whether the law is saturated at a bit speed [rad/s]."""
        return self._unlimited(bit_speed) > self.greatest

    def _unlimited(self, bit_speed: float) -> float:
        return self.gain * abs(bit_speed) + self.least
