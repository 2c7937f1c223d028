"""Energy of the string under law (9): eq. (8) with the law put in, Proposition 1 and what follows from it.

As printed, (8) becomes, I L / 2 times and so in W,

    -W R_b mu_b |v| - integral of beta theta_t^2 - c_a (sqrt(1 - c_1) ydot - sqrt(c_b / c_a) v - sqrt(c_2) r)^2,

which is never above 0, if the law is obeyed at every instant. In uniform rotation the energy stands still, so that
there is none in which this is below 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from ..controllers.laws import DissipativeLaw
from ..plant.parameters import DrillstringParameters
from .numerics.arrays import FloatArray
from .stability.torque_curve import TorqueCurve


@dataclass(frozen=True)
class TopMotion:
    """Integrals of the motion of a string over intervals of time, each of shape (n,).

    Attributes
    ----------
    duration : ndarray
        Of the intervals [s].
    top, bit : ndarray
        Of the speeds of top and bit, which are the angles they turn [rad].
    top_square : ndarray
        Of the square of the top speed [rad^2/s].
    product : ndarray
        Of top speed times bit speed [rad^2/s].
    """

    duration: FloatArray
    top: FloatArray
    bit: FloatArray
    top_square: FloatArray
    product: FloatArray


def lawful_work(
    law: DissipativeLaw, top_damping: float, motion: TopMotion, speed_ref: FloatArray, torque_ref: FloatArray
) -> FloatArray:
    """Return the work into the string at its top, had the drive turned as the law says at every instant [J].

    That is the integral of c_a (Omega - ydot) ydot with Omega of the law at the motion there was, neither guarded nor
    limited. The product with ydot has no pole.

    Parameters
    ----------
    law : DissipativeLaw
        Of either form.
    top_damping : float
        c_a of the string [N m s/rad].
    motion : TopMotion
        Of the string.
    speed_ref, torque_ref : ndarray, shape (n,)
        Wanted bit speed [rad/s] and torque on bit [N m] in the intervals.
    """
    ratio, rest = law.c_b / law.c_a, 1.0 - law.c_1
    cross = 2.0 * sqrt(ratio * rest)
    shared = cross * motion.product - rest * motion.top_square
    if law.form == "printed":
        driven = 2.0 * sqrt(law.c_2 * rest) * speed_ref * motion.top
        poles = law.c_2 * np.square(speed_ref) * motion.duration
        return top_damping * (shared + driven - poles - 2.0 * sqrt(law.c_2 * ratio) * speed_ref * motion.bit)
    wanted = (rest - cross) * speed_ref + torque_ref / law.c_a
    return top_damping * (shared + wanted * motion.top)


def lawful_angle(law: DissipativeLaw, motion: TopMotion, speed_ref: FloatArray, torque_ref: FloatArray) -> FloatArray:
    """Return the angle through which the drive would have turned as the tracking form says at every instant [rad].

    The parameters are those of :func:`lawful_work`. As printed, the law has a pole that this would have to pass.
    """
    cross = 2.0 * sqrt(law.c_b / law.c_a * (1.0 - law.c_1))
    rest = (1.0 - law.c_1 - cross) * speed_ref + torque_ref / law.c_a
    return law.c_1 * motion.top + cross * motion.bit + rest * motion.duration


def drain(
    parameters: DrillstringParameters,
    law: DissipativeLaw,
    wob: float,
    speed_ref: float,
    speed: ArrayLike,
    beta: float = 0.0,
) -> FloatArray:
    """Return what the string loses each second in uniform rotation under law (9) as printed [W].

    An equilibrium needs 0. With dry friction this is above 0 at every speed but 0, and there the law has no value: so
    there is no equilibrium.

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    law : DissipativeLaw
        With the c_a and c_b of the string.
    wob : float
        Weight on bit [N].
    speed_ref : float
        Wanted bit speed [rad/s].
    speed : array_like
        Of the rotation, of any sign [rad/s].
    beta : float
        Damping along the string [N s/rad].

    Raises
    ------
    ValueError
        WOB is not finite and >= 0, or c_a or c_b of the law are not those of the string.
    """
    if (law.c_a, law.c_b) != (parameters.c_a, parameters.c_b):
        raise ValueError(
            f"the law has c_a = {law.c_a} and c_b = {law.c_b}; "
            f"expected {parameters.c_a} and {parameters.c_b} as the string"
        )
    speeds = np.asarray(speed, np.float64)
    curve = TorqueCurve.of(parameters, wob)
    dry = np.abs(speeds) * curve.dry(np.abs(speeds))
    off = _turning(law) * speeds - sqrt(law.c_2) * speed_ref
    return dry + beta * parameters.L * np.square(speeds) + law.c_a * np.square(off)


def unloaded_speed(law: DissipativeLaw, speed_ref: float) -> float:
    """Return the one speed at which law (9) as printed holds a string without dry friction and damping [rad/s].

    Raises
    ------
    ValueError
        There is none, since 1 - c_1 = c_b / c_a.
    """
    turning = _turning(law)
    if turning == 0.0:
        raise ValueError(f"c_1 is {law.c_1} and c_b / c_a is {law.c_b / law.c_a}; expected 1 - c_1 to differ from it")
    return sqrt(law.c_2) * speed_ref / turning


def _turning(law: DissipativeLaw) -> float:
    """Return sqrt(1 - c_1) - sqrt(c_b / c_a), what multiplies a uniform rotation in the completed square."""
    return sqrt(1.0 - law.c_1) - sqrt(law.c_b / law.c_a)
