"""A top of the string that a law drives: what it reflects, and how fast small motions about uniform rotation die away.

With U the wave that comes up, D the one that goes down, speed U + D and torque Z (D - U), the top gives D = rho U and
the bit U = rho_b D, rho_b = (Z - a) / (Z + a) with a = I_B s + T'. So small motions are exp(s t) for the zeros of

    h(s) = (Z + a) down(s) - (Z - a) up(s) exp(-2 Gamma s),    rho = up / down,

where both parts are multiplied by what they have as denominators, so that h has no poles. Of a top that only slips,
rho = -Upsilon, and h is that of `models.theory.stability.characteristic`. Limits and noise are left out, and samples
are taken as half a sample time of delay.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ...controllers.speed_pid import PidGains
from ...controllers.virtual_drive import VirtualDrive
from ...plant.parameters import DrillstringParameters
from ..numerics.arrays import ComplexArray, FloatArray
from ..numerics.root_count import zeros_inside

FREQUENCIES = np.geomspace(1e-2, 1e3, 1200)
"""At which reflections are looked at [rad/s]."""
HIGHEST = 20.0
"""Frequency up to which modes are looked for, times Gamma."""
FASTEST = 50.0
"""Growth rate up to which modes are counted [1/s]."""
NEWTON_STEPS, SETTLED, APART = 12, 1e-9, 1e-6
REFINEMENTS = 4


class Top(Protocol):
    """The top of a string, by the waves that meet there."""

    @property
    def string(self) -> DrillstringParameters:
        """The string."""
        ...

    def waves(self, s: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return down and up, with down D = up U."""
        ...


@dataclass(frozen=True)
class Follower:
    """A drive that follows a speed: behind a lag or, with an inertia, as a rotor with a PI controller.

    Attributes
    ----------
    lag : float
        Time constant [s]; of a rotor not used.
    delay : float
        Until a command acts [s].
    inertia, proportional, integral : float
        Of the rotor [kg m^2], and of its controller [N m s/rad, N m/rad].
    """

    lag: float
    delay: float
    inertia: float = 0.0
    proportional: float = 0.0
    integral: float = 0.0

    def parts(self, s: ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return n, d and g of Omega = (n command - g torque) / d."""
        late = np.exp(-self.delay * s)
        if not self.inertia:
            return late, 1.0 + self.lag * s, 0.0 * s
        control = self.proportional * s + self.integral
        return control * late, self.inertia * s * s + control, s


@dataclass(frozen=True)
class VirtualTop:
    """A top whose drive is given the speed that a virtual drive would have; what the law assumes may be wrong.

    Attributes
    ----------
    string : DrillstringParameters
        The string.
    law : VirtualDrive
        By what it assumes of the string.
    drive : Follower
        The real drive.
    """

    string: DrillstringParameters
    law: VirtualDrive
    drive: Follower

    def waves(self, s: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return down and up: those of a slip whose drive's speed follows from speed and torque at the top."""
        law, (damping, stiffness, inertia) = self.law, self.law.gains
        taken, slip = law.impedance, law.slip
        resistance = taken + damping
        if stiffness:
            give, held = taken * s, inertia * s * s + resistance * s + stiffness
        else:
            give, held = taken + 0.0 * s, inertia * s + resistance
        wave, mean = 1.0 + law.filter_time * s, 1.0 + law.slip_time * s
        of_speed = 0.5 * ((slip + taken) * (2.0 * give - held) + (slip - taken) * held) * mean
        of_torque = -of_speed / taken
        if not law.compensated:
            of_torque = of_torque - (slip + taken) * (held - give) * wave / slip
        below = slip * held * wave * mean
        command, follows, yields = self.drive.parts(s)
        impedance, c_a = self.string.impedance, self.string.c_a
        rest = impedance * (follows + c_a * yields) * below
        own = c_a * follows * below
        fed = c_a * command * of_speed, c_a * command * of_torque * impedance
        return rest + own - fed[0] - fed[1], rest - own + fed[0] - fed[1]


@dataclass(frozen=True)
class RotorTop:
    """A top that slips on a rotor whose motor is controlled by its speed.

    Attributes
    ----------
    string : DrillstringParameters
        The string.
    gains : PidGains
        Of the controller.
    filter_time : float
        Of its derivative part [s].
    inertia : float
        Of the rotor [kg m^2].
    delay : float
        Until a torque acts [s].
    """

    string: DrillstringParameters
    gains: PidGains
    filter_time: float
    inertia: float
    delay: float

    def waves(self, s: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return down and up: those of rotor, controller and slip in a row."""
        proportional, integral, derivative = self.gains
        smooth, late = 1.0 + self.filter_time * s, np.exp(-self.delay * s)
        shown = self.inertia * s * smooth + (proportional * smooth + derivative * s) * late
        below = smooth
        if integral:
            shown, below = shown * s + integral * smooth * late, below * s
        impedance, c_a = self.string.impedance, self.string.c_a
        both, met = impedance * (shown + c_a * below), c_a * shown
        return both + met, both - met


def greatest_reflection(top: Top) -> float:
    """Return the greatest part of a wave that comes back from the top, of all frequencies: above 1 it amplifies."""
    down, up = top.waves(np.asarray(1j * FREQUENCIES, np.complex128))
    with np.errstate(all="ignore"):
        return float(np.max(np.abs(up / down)))


def modal_damping(top: Top, slope: float) -> float:
    """Return the rate at which the slowest of the small motions about uniform rotation dies away [1/s].

    Modes of a frequency up to 20 / Gamma are found by Newton's method; the argument principle tells that none to the
    right of them is left out.

    Parameters
    ----------
    top : Top
        The top of the string.
    slope : float
        T' of the torque on bit [N m s/rad].

    Returns
    -------
    float
        Negative if one grows.

    Raises
    ------
    ArithmeticError
        The slowest cannot be found.
    """
    p = top.string

    def value(s: ComplexArray) -> ComplexArray:
        down, up = top.waves(s)
        a = p.I_B * s + slope
        return (p.impedance + a) * down - (p.impedance - a) * np.exp(-2.0 * p.travel_time * s) * up

    height = HIGHEST / p.travel_time
    spacing = 0.8 / p.travel_time
    for _ in range(REFINEMENTS):
        rates = _modes(value, height, spacing)
        if rates.size:
            greatest = float(rates.max())
            edge = greatest + APART * (1.0 + abs(greatest))
            if edge >= FASTEST or not zeros_inside(value, (edge, FASTEST), (-height, height), 0.2 / p.travel_time):
                return -greatest
        spacing *= 0.5
    raise ArithmeticError("the slowest of the small motions cannot be found")


def _modes(value: Callable[[ComplexArray], ComplexArray], height: float, spacing: float) -> FloatArray:
    """Return the real parts of zeros up to a height [1/s], by Newton's method from a grid."""
    real, imaginary = np.meshgrid([-0.5, 0.3], np.arange(0.0, height, spacing))
    s = np.asarray((real + 1j * imaginary).ravel(), np.complex128)
    step = s
    with np.errstate(all="ignore"):
        for _ in range(NEWTON_STEPS):
            reach = APART * (1.0 + np.abs(s))
            step = value(s) * 2.0 * reach / (value(s + reach) - value(s - reach))
            s = s - step
        settled = np.isfinite(s) & (np.abs(step) <= SETTLED * (1.0 + np.abs(s)))
    s = s[settled]
    return np.asarray(s.real[np.abs(s.imag) <= height], np.float64)
