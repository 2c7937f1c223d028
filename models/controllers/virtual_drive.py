"""A drive that meets the string as damper, spring and mass do: soft torque, impedance matching, absorber at the top.

The wave that comes up the string follows from speed and torque at its top, and the wave sent down is chosen such that
both together are the motion of a virtual drive, J_v u' + P u + K q = torque with q' = u and u = r - speed. Torque alone
does not do: a law Omega = r - (1/P - 1/c_a) torque has a loop gain of 1 at P = Z, and diverges.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

from ..numerics.low_pass import low_pass
from ..numerics.trigonometry import sine_and_cosine

NEWTON_STEPS = 8
"""Steps in which x tan x = k is solved for every k > 0 to rounding."""
FIRST_GUESS = 0.4052847345693511
"""(2 / pi)^2: the first guess then has the right limits for small and large k."""


@dataclass(frozen=True)
class TopOfString:
    """The string as its drive meets it.

    Attributes
    ----------
    G, J, I, L, I_B, c_a : float
        Parameters of the plant, by the paper's symbols.
    """

    G: float = 79.3e9
    J: float = 1.19e-5
    I: float = 0.095  # noqa: E741 (the paper's symbol)
    L: float = 1172.0
    I_B: float = 89.0
    c_a: float = 2000.0

    @property
    def impedance(self) -> float:
        """Wave impedance Z = sqrt(I G J) [N m s/rad]."""
        return sqrt(self.I * self.G * self.J)

    @property
    def stick_slip_frequency(self) -> float:
        """Lowest frequency omega_s of the string with its top held, tan(omega Gamma) = Z / (omega I_B) [rad/s].

        By Newton's method for x sin x = k cos x with x = omega Gamma and k = Z Gamma / I_B.
        """
        away = self.L * sqrt(self.I / (self.G * self.J))
        k = self.impedance * away / self.I_B
        x = sqrt(k / (1.0 + FIRST_GUESS * k))
        for _ in range(NEWTON_STEPS):
            sine, cosine = sine_and_cosine(x)
            x = x - (x * sine - k * cosine) / (sine + x * cosine + k * sine)
        return x / away


class Gains(NamedTuple):
    """Damping, spring and mass the string meets at its top: P + K / s + J_v s.

    Attributes
    ----------
    damping : float
        P [N m s/rad].
    stiffness : float
        K [N m/rad].
    inertia : float
        J_v [kg m^2].
    """

    damping: float
    stiffness: float
    inertia: float


def soft_torque(string: TopOfString, ratio: float = 1.5) -> Gains:
    """Return the gains of soft torque, P = ratio Z and K = P omega_s / 6; the ratio 1 is impedance matching."""
    damping = ratio * string.impedance
    return Gains(damping, damping * string.stick_slip_frequency / 6.0, 0.0)


def absorber(string: TopOfString) -> Gains:
    """Return the gains of a table tuned to stick-slip, c_f = 1.5 Z, J_a = c_f / (4 omega_s), k_f = J_a omega_s^2.

    Source: Jansen and van den Steen (1995), active damping of self-excited torsional vibrations in oil well
    drillstrings.
    """
    frequency = string.stick_slip_frequency
    damping = 1.5 * string.impedance
    inertia = damping / (4.0 * frequency)
    return Gains(damping, inertia * (frequency * frequency), inertia)


class Motion(NamedTuple):
    """State of a virtual drive.

    Attributes
    ----------
    wave : float
        The filtered wave that comes up [rad/s].
    torque : float
        The torque filtered for the slip [N m].
    speed, angle : float
        u [rad/s], which follows from the others where there is no inertia, and q [rad].
    """

    wave: float
    torque: float
    speed: float
    angle: float


class Ends(NamedTuple):
    """Inputs at an instant: speed and torque at the top of the string, and the speed asked for."""

    top_speed: float
    top_torque: float
    speed_ref: float


@dataclass(frozen=True)
class VirtualDrive:
    """A law of the drive's speed that makes it a damper, spring and mass.

    Attributes
    ----------
    impedance, slip : float
        Z of the string and c_a of the plant, through which the drive's speed acts [N m s/rad].
    gains : Gains
        What the string is to meet.
    filter_time : float
        T_f, with which the wave that comes up is filtered; 0: not at all [s].
    slip_time : float
        With which the torque is filtered from which the slip follows [s].
    compensated : bool
        Whether the string's top turns as asked for, rather than slower by its slip, torque / c_a.
    """

    impedance: float
    slip: float
    gains: Gains
    filter_time: float
    slip_time: float
    compensated: bool

    def wave(self, ends: Ends) -> float:
        """Return the wave that comes up, (speed - torque / Z) / 2 [rad/s]."""
        return (ends.top_speed - ends.top_torque / self.impedance) * 0.5

    def begin(self, ends: Ends) -> Motion:
        """Return the state in which these ends have been so for ever: the spring bears the torque, nothing moves."""
        torque = ends.top_torque
        wave = self.wave(ends)
        pull = self.impedance * (self._turning(torque, ends) - 2.0 * wave)
        angle = pull / self.gains.stiffness if self.gains.stiffness > 0.0 else 0.0
        speed = 0.0 if self.gains.stiffness > 0.0 else pull / (self.impedance + self.gains.damping)
        return Motion(wave, torque, speed, angle)

    def advance(self, before: Motion, begin: Ends, end: Ends, slopes: Ends, elapsed: float) -> Motion:
        """Return the state after `elapsed` seconds, in which the ends go from `begin` to `end` along slopes."""
        rise = (slopes.top_speed - slopes.top_torque / self.impedance) * 0.5
        first = self.wave(begin)
        wave = low_pass(before.wave, first, rise, elapsed, self.filter_time)
        torque = low_pass(before.torque, begin.top_torque, slopes.top_torque, elapsed, self.slip_time)
        early = before.wave if self.filter_time > 0.0 else first
        pull = self.impedance * (self._turning(before.torque, begin) - 2.0 * early)
        pull = (pull + self.impedance * (self._turning(torque, end) - 2.0 * wave)) * 0.5
        damping, stiffness, inertia = self.gains
        resistance = self.impedance + damping
        if inertia > 0.0:
            half = 0.5 * elapsed * (resistance + 0.5 * elapsed * stiffness)
            net = elapsed * (pull - stiffness * before.angle)
            speed = (before.speed * (inertia - half) + net) / (inertia + half)
            return Motion(wave, torque, speed, before.angle + 0.5 * elapsed * (before.speed + speed))
        give = elapsed / resistance
        angle = (before.angle * (1.0 - 0.5 * give * stiffness) + give * pull) / (1.0 + 0.5 * give * stiffness)
        return Motion(wave, torque, 0.0, angle)

    def command(self, motion: Motion, ends: Ends) -> float:
        """Return the drive's speed [rad/s]."""
        wave = motion.wave if self.filter_time > 0.0 else self.wave(ends)
        turning = self._turning(motion.torque, ends)
        speed = motion.speed
        if self.gains.inertia <= 0.0:
            pull = self.impedance * (turning - 2.0 * wave) - self.gains.stiffness * motion.angle
            speed = pull / (self.impedance + self.gains.damping)
        down = turning - speed - wave
        return ((self.slip + self.impedance) * down + (self.slip - self.impedance) * wave) / self.slip

    def _turning(self, torque: float, ends: Ends) -> float:
        """Return the speed r that the string's top is to turn with, given the filtered torque."""
        return ends.speed_ref if self.compensated else ends.speed_ref - torque / self.slip
