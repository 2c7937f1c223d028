"""PI and PID control of the rotor's speed: stiff, or tuned to stick-slip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..numerics.low_pass import low_pass
from .virtual_drive import TopOfString


class PidGains(NamedTuple):
    """Gains of a speed controller, for speed, angle and acceleration [N m s/rad, N m/rad, N m s^2/rad]."""

    proportional: float
    integral: float
    derivative: float


def stiff(string: TopOfString, inertia: float) -> PidGains:
    """Return the gains of an ordinary drive with a rotor's inertia [kg m^2], 50 Z and 5 J."""
    return PidGains(50.0 * string.impedance, 5.0 * inertia, 0.0)


def tuned(string: TopOfString, inertia: float) -> PidGains:
    """Return the gains with which the rotor gives way at the stick-slip frequency, 4 Z and omega_s^2 J."""
    frequency = string.stick_slip_frequency
    return PidGains(4.0 * string.impedance, frequency * frequency * inertia, 0.0)


class PidState(NamedTuple):
    """State of a speed controller.

    Attributes
    ----------
    set_point : float
        As far as it may have changed [rad/s].
    integral : float
        Torque of the integral part [N m].
    smoothed : float
        The speed through the filter of the derivative part [rad/s].
    """

    set_point: float
    integral: float
    smoothed: float


@dataclass(frozen=True)
class SpeedPid:
    """A controller that makes a torque from a speed.

    Attributes
    ----------
    rate : float
        Greatest change of the set point [rad/s^2].
    filter_time : float
        Of the derivative part [s], above 0.
    least, greatest : float
        Limits of the torque [N m].
    """

    rate: float
    filter_time: float
    least: float
    greatest: float

    def begin(self, speed: float, torque: float) -> PidState:
        """Return the state that keeps a speed [rad/s] and a torque [N m]."""
        return PidState(speed, torque, speed)

    def advance(
        self, gains: PidGains, before: PidState, speed: float, slope: float, speed_ref: float, elapsed: float
    ) -> PidState:
        """Return the state after `elapsed` seconds.

        Parameters
        ----------
        speed, slope : float
            The rotor's speed at the beginning, and its derivative.
        speed_ref : float
            What is asked for, at the end [rad/s].
        """
        most = self.rate * elapsed
        change = speed_ref - before.set_point
        set_point = before.set_point + (most if change > most else -most if change < -most else change)
        smoothed = low_pass(before.smoothed, speed, slope, elapsed, self.filter_time)
        end = speed + slope * elapsed
        error = set_point - end
        middle = ((before.set_point - speed) + error) * 0.5
        after = PidState(set_point, before.integral + gains.integral * elapsed * middle, smoothed)
        wanted = self.wanted(gains, after, end)
        if (wanted > self.greatest and error > 0.0) or (wanted < self.least and error < 0.0):
            return PidState(set_point, before.integral, smoothed)
        return after

    def wanted(self, gains: PidGains, state: PidState, speed: float) -> float:
        """Return the torque before its limits [N m]."""
        hold = gains.derivative * ((speed - state.smoothed) / self.filter_time)
        return gains.proportional * (state.set_point - speed) + state.integral - hold

    def switched(self, before: PidGains, after: PidGains, state: PidState, speed: float) -> PidState:
        """Return the state from which other gains give the same torque."""
        gap = self.wanted(before, state, speed) - self.wanted(after, state, speed)
        return PidState(state.set_point, state.integral + gap, state.smoothed)
