"""Uniform rotation and rest: the equilibria of the drillstring under constant Omega and WOB."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import copysign, isfinite

from scipy.optimize import brentq

from ...plant.parameters import DrillstringParameters
from .torque_curve import TorqueCurve


@dataclass(frozen=True)
class Equilibrium:
    """A uniform motion of the string.

    Attributes
    ----------
    speed : float
        Of bit and top [rad/s].
    torque : float
        That the string transmits [N m].
    slope : float or None
        T' of the torque on bit there [N m s/rad]; None for a stuck bit.
    """

    speed: float
    torque: float
    slope: float | None

    @property
    def stuck(self) -> bool:
        """Tell whether the bit is held by friction."""
        return self.slope is None


def equilibria(parameters: DrillstringParameters, omega: float, wob: float) -> tuple[Equilibrium, ...]:
    """Return all equilibria, slowest first.

    Rotation with w needs c_a (Omega - w) = T(w). T falls towards a line, so Omega = w + T(w) / c_a is convex in w and
    has at most two solutions above rest. At rest the string winds up to the torque c_a Omega, which friction holds
    up to its static limit.

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    omega, wob : float
        Drive speed [rad/s], of any sign, and weight on bit [N].

    Raises
    ------
    ValueError
        Omega is not finite, or WOB not finite and >= 0.
    """
    if not isfinite(omega):
        raise ValueError(f"Omega is {omega} rad/s; expected a finite value")
    curve = TorqueCurve.of(parameters, wob)
    reach = parameters.c_a * abs(omega)
    speeds = _running_speeds(parameters, curve, abs(omega))
    found = [Equilibrium(copysign(w, omega), copysign(curve.torque(w), omega), float(curve.slope(w))) for w in speeds]
    if reach <= curve.static:
        found.insert(0, Equilibrium(0.0, copysign(reach, omega), None))
    return tuple(found)


def running_equilibrium(parameters: DrillstringParameters, omega: float, wob: float) -> Equilibrium:
    """Return the equilibrium in which the bit turns, of two the faster.

    Raises
    ------
    ValueError
        The inputs are refused as by :func:`equilibria`, or the bit turns in none of them.
    """
    found = equilibria(parameters, omega, wob)
    if not found or found[-1].stuck:
        least = least_running_omega(parameters, wob)
        raise ValueError(
            f"no running equilibrium at Omega = {omega} rad/s, WOB = {wob} N; expected |Omega| > {least:.9g}"
        )
    return found[-1]


def least_running_omega(parameters: DrillstringParameters, wob: float) -> float:
    """Return the drive speed [rad/s] down to which there is a running equilibrium."""
    curve = TorqueCurve.of(parameters, wob)
    speed = curve.speed_of_slope(-parameters.c_a) or 0.0
    return speed + float(curve.torque(speed)) / parameters.c_a


def _running_speeds(parameters: DrillstringParameters, curve: TorqueCurve, omega: float) -> list[float]:
    """Return the solutions w > 0 of w + T(w) / c_a = omega, increasing."""

    def excess(speed: float) -> float:
        return speed + curve.torque(speed) / parameters.c_a - omega

    turning = curve.speed_of_slope(-parameters.c_a) or 0.0
    speeds: list[float] = []
    if turning > 0.0 and excess(turning) < 0.0 < excess(0.0):
        speeds.append(_root(excess, 0.0, turning))
    if excess(turning) < 0.0 < omega:
        speeds.append(_root(excess, turning, omega))
    return speeds


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    return float(brentq(function, low, high, xtol=1e-15, rtol=1e-15))
