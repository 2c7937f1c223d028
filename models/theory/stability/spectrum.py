"""Small motions about uniform rotation: rightmost characteristic roots, and where stability is lost."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, inf, pi, sin

import numpy as np
from scipy.optimize import brentq

from ...plant.friction import greatest_fall
from ...plant.parameters import DrillstringParameters
from ..numerics.arrays import ComplexArray
from .characteristic import Characteristic
from .equilibrium import Equilibrium, running_equilibrium
from .torque_curve import TorqueCurve

SAME = 1e-9
"""Roots that differ by less, relative to 1 + |s|, are one."""
LARGEST_DEGREE = 1000


def rightmost_roots(parameters: DrillstringParameters, omega: float, wob: float, count: int) -> ComplexArray:
    """Return the rightmost characteristic roots about the running equilibrium.

    They are found among the eigenvalues of the discretised generator of the linearised eq. (14), improved by Newton's
    method, and counted by the argument principle.

    All roots lie between the vertical line they tend to and the line Re s = -T' / I_B (see
    :mod:`models.theory.stability.characteristic`). If the former is on the right of the latter, no root is rightmost;
    those of least frequency are then returned, and the real part of no other is above that of the line. Without any
    reflection (c_a = Z) there is only one root.

    Source: Saldivar et al. (2011), eq. (14), linearised about the equilibrium.

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    omega, wob : float
        Drive speed [rad/s], of any sign, and weight on bit [N], at least 0.
    count : int
        Number of roots, at least 1.

    Returns
    -------
    ndarray of complex, shape (count,), or (1,) if there is only one
        Roots [1/s], the rightmost first; of a pair the upper first, which can be the last that was asked for.

    Raises
    ------
    ValueError
        `count` is below 1, or there is no running equilibrium.
    ArithmeticError
        The roots found are not all there are.
    """
    equilibrium = running_equilibrium(parameters, omega, wob)
    return roots_about(parameters, equilibrium, count)


def roots_about(parameters: DrillstringParameters, equilibrium: Equilibrium, count: int) -> ComplexArray:
    """Return the rightmost characteristic roots about an equilibrium in which the bit turns.

    See :func:`rightmost_roots` for the method and the source.

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    equilibrium : Equilibrium
        With a slope, as of :func:`models.theory.stability.equilibrium.running_equilibrium`.
    count : int
        Number of roots, at least 1.

    Returns
    -------
    ndarray of complex, shape (count,), or (1,) if there is only one
        Roots [1/s], the rightmost first.

    Raises
    ------
    ValueError
        `count` is below 1, or the bit is stuck.
    ArithmeticError
        The roots found are not all there are.
    """
    if count < 1:
        raise ValueError(f"count is {count}; expected at least 1")
    if equilibrium.slope is None:
        raise ValueError("the bit is stuck; expected an equilibrium in which it turns")
    function = Characteristic(parameters, equilibrium.slope)
    if parameters.reflection == 0.0:
        return np.array([-(equilibrium.slope + parameters.impedance) / parameters.I_B + 0.0j])
    number = count // 2 + 2
    while True:
        height = function.between_chain_zeros(number)
        roots = _roots_up_to(function, height)
        if function.local <= function.chain:
            nearest = roots[np.argsort(np.abs(roots.imag), kind="stable")]
            return nearest[:count][np.argsort(-nearest[:count].real, kind="stable")]
        if roots.size >= count and function.none_beyond(height, float(roots[count - 1].real)):
            return roots[:count]
        number *= 2


def spectral_abscissa(parameters: DrillstringParameters, equilibrium: Equilibrium) -> float:
    """Return the rate at which small disturbances of an equilibrium grow in the end [1/s]: negative if it is stable.

    It is the supremum of the real parts of all roots. Of a stuck bit they are those of the waves between it and the
    top, which form a chain. Source: Saldivar et al. (2011), eq. (14), and eq. (2) at the top.

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    equilibrium : Equilibrium
        Of any kind.

    Returns
    -------
    float
        Growth rate [1/s].

    Raises
    ------
    ArithmeticError
        The rightmost root cannot be found.
    """
    function = Characteristic(parameters, equilibrium.slope or 0.0)
    if equilibrium.slope is None or (function.local <= function.chain and parameters.reflection):
        return function.chain
    return float(roots_about(parameters, equilibrium, 1)[0].real)


def unstable_count(parameters: DrillstringParameters, equilibrium: Equilibrium) -> int:
    """Return the number of roots with a positive real part, by the argument principle.

    Source: Saldivar et al. (2011), eq. (14), linearised about the equilibrium.

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    equilibrium : Equilibrium
        Of any kind; with a stuck bit no root is unstable.

    Returns
    -------
    int
        Number of unstable roots, at least 0, a pair counted as two.

    Raises
    ------
    ArithmeticError
        A root lies on the imaginary axis, or too near to be counted.
    """
    return 0 if equilibrium.slope is None else Characteristic(parameters, equilibrium.slope).count_right_of(0.0)


def _roots_up_to(function: Characteristic, height: float) -> ComplexArray:
    """Return all roots whose imaginary part does not exceed `height` [1/s], the rightmost first."""
    left, right = sorted((function.chain, function.local))
    margin = 0.05 / function.parameters.travel_time
    expected = function.count_in(left - margin, right + margin, height)
    degree = 16 + round(2.0 * height * function.parameters.travel_time)
    while degree <= LARGEST_DEGREE:
        guesses = np.linalg.eigvals(function.system().generator(degree)).astype(np.complex128)
        roots = _distinct(function.refined(guesses[np.abs(guesses.imag) <= 1.2 * height]))
        roots = roots[np.abs(roots.imag) <= height]
        if roots.size == expected:
            return roots
        degree *= 2
    raise ArithmeticError(f"{expected} characteristic roots have |Im s| <= {height:.9g} 1/s; not all could be found")


def _distinct(roots: ComplexArray) -> ComplexArray:
    """Return roots without repetitions, the conjugate of each exactly so, the rightmost first, upper before lower."""
    kept: list[complex] = []
    for root in sorted(roots.tolist(), key=lambda root: (-root.real, abs(root.imag))):
        near = SAME * (1.0 + abs(root))
        upper = complex(root.real, abs(root.imag) if abs(root.imag) > near else 0.0)
        if all(abs(upper - other) > near for other in kept):
            kept.append(upper)
    return np.array([s for root in kept for s in ((root, root.conjugate()) if root.imag else (root,))], np.complex128)


@dataclass(frozen=True)
class CriticalPoint:
    """Point at which the running equilibrium loses its stability.

    Attributes
    ----------
    omega, wob : float
        Drive speed [rad/s] and weight on bit [N].
    speed : float
        Of the bit [rad/s].
    frequency : float
        Of the oscillation that begins to grow [rad/s]; 0 where the equilibrium meets a slower one and ends.
    slope : float
        T' [N m s/rad].
    """

    omega: float
    wob: float
    speed: float
    frequency: float
    slope: float


def critical_omega(parameters: DrillstringParameters, wob: float) -> float:
    """Return the drive speed at which the running equilibrium loses its stability as the drive is slowed.

    See :func:`critical_point`, which also tells how it does. Source: Saldivar et al. (2011), eqs. (3), (4) and (14).

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    wob : float
        Weight on bit [N], at least 0.

    Returns
    -------
    float
        Critical drive speed [rad/s], above 0.

    Raises
    ------
    ValueError
        WOB is not finite and >= 0, or the running equilibrium is stable down to rest.
    """
    return critical_point(parameters, wob).omega


def critical_point(parameters: DrillstringParameters, wob: float) -> CriticalPoint:
    """Return where the running equilibrium loses its stability as the drive is slowed.

    It is stable as long as T' is above that of :func:`critical_slope`; a slower bit is on a steeper part of (4).
    Source: Saldivar et al. (2011), eqs. (3), (4) and (14).

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    wob : float
        Weight on bit [N], at least 0.

    Returns
    -------
    CriticalPoint
        Inputs, bit speed, frequency and slope at the loss of stability.

    Raises
    ------
    ValueError
        WOB is not finite and >= 0, or so small that the friction is nowhere steep enough: the running equilibrium is
        then stable down to rest.
    """
    curve = TorqueCurve.of(parameters, wob)
    frequency, slope = critical_slope(parameters)
    speed = curve.speed_of_slope(slope)
    if speed is None:
        steepest = -float(curve.slope(0.0))
        raise ValueError(
            f"the running equilibrium is stable at every Omega at WOB = {wob} N, where the torque on bit falls by "
            f"{steepest:.9g} N m s/rad at most; expected more than {-slope:.9g} N m s/rad"
        )
    return CriticalPoint(speed + float(curve.torque(speed)) / parameters.c_a, wob, speed, frequency, slope)


def critical_wob(parameters: DrillstringParameters, omega: float) -> float:
    """Return the weight on bit above which the running equilibrium at a drive speed is unstable.

    Source: Saldivar et al. (2011), eqs. (3), (4) and (14); the inverse of :func:`critical_omega`.

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    omega : float
        Drive speed [rad/s], above 0.

    Returns
    -------
    float
        Critical weight on bit [N], above 0.

    Raises
    ------
    ValueError
        Omega is not finite and > 0, the friction does not fall, or the equilibrium is stable up to the weight at which
        it comes to rest.
    """
    if not 0.0 < omega < inf:
        raise ValueError(f"Omega is {omega} rad/s; expected a finite value > 0")
    fall = greatest_fall(parameters)
    _, slope = critical_slope(parameters)

    def surplus(wob: float) -> float:
        return critical_point(parameters, wob).omega - omega

    least = (parameters.c_b - slope) / fall
    low = least * (1.0 + 1e-12)
    if surplus(low) >= 0.0:
        rest = parameters.c_a * omega / TorqueCurve.of(parameters, 1.0).static
        raise ValueError(
            f"the running equilibrium at Omega = {omega} rad/s is stable up to WOB = {rest:.9g} N, where it comes to "
            f"rest; expected Omega > {critical_point(parameters, low).omega:.9g} rad/s"
        )
    high = 2.0 * low
    while surplus(high) < 0.0:
        high *= 2.0
    return float(brentq(surplus, low, high, xtol=1e-12 * high, rtol=1e-14))


def critical_slope(parameters: DrillstringParameters) -> tuple[float, float]:
    """Return the frequency and the slope T' of the torque on bit at which stability is lost as T' falls.

    With u = 2 Gamma omega a root i omega needs

        T' = -Z (1 - Upsilon^2) / (1 - 2 Upsilon cos u + Upsilon^2),
        I_B = 4 Z Gamma Upsilon (sin u / u) / (1 - 2 Upsilon cos u + Upsilon^2),    or omega = 0 and T' = -c_a.

    For Upsilon > 0 the right side of the second falls in 0 < u < pi from Gamma (c_a^2 - Z^2) / Z to 0. A lighter bit
    therefore has one solution there, and it has the greatest T' of all solutions. In any other case that is -c_a.
    Source: Saldivar et al. (2011), eq. (14), at a root on the imaginary axis.

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.

    Returns
    -------
    frequency : float
        Of the oscillation that begins to grow [rad/s], at least 0.
    slope : float
        Critical T' [N m s/rad], below 0.
    """
    upsilon, inertia = parameters.reflection, parameters.I_B
    scale = 4.0 * parameters.impedance * parameters.travel_time * upsilon

    def mismatch(u: float) -> float:
        return inertia * u * (1.0 - 2.0 * upsilon * cos(u) + upsilon * upsilon) - scale * sin(u)

    if inertia * (1.0 - upsilon) ** 2 >= scale:
        return 0.0, -parameters.c_a
    low = pi
    while mismatch(low) >= 0.0:
        low *= 0.5
    u = float(brentq(mismatch, low, pi, xtol=1e-15, rtol=1e-15))
    slope = -parameters.impedance * (1.0 - upsilon * upsilon) / (1.0 - 2.0 * upsilon * cos(u) + upsilon * upsilon)
    return u / (2.0 * parameters.travel_time), slope
