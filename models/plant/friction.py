"""The torque on bit, eqs. (3) and (4): viscous damping and set-valued dry friction.

Another friction law is written here and nowhere else in Python: its torque, slope and inverse are methods of
:class:`Friction`, which the bit, the drilling program, equilibria, spectrum and cycles all ask.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from ..numerics.exponential import exponential
from .parameters import DrillstringParameters

GREATEST_EXPONENT = 4.0
"""Greatest exponent of the friction where it is continued beyond rest."""

TUNABLE = ("c_b", "mu_cb", "mu_sb", "gamma_b")
"""Parameters of the friction that may change during a run."""

Real: TypeAlias = Any
"""A float, or an array of them in the theory: the formulas hold elementwise."""


def fading(exponent: float) -> float:
    """Return the exponential of eq. (4), continued smoothly through rest.

    Beyond rest it only serves the search for the stop; there it is capped.
    """
    return exponential(exponent if exponent < GREATEST_EXPONENT else GREATEST_EXPONENT)


@dataclass(frozen=True)
class Friction:
    """Dry friction of eq. (4) at a lever: mu_b(v) times a lever that is 1, R_b or W R_b.

    Attributes
    ----------
    coulomb, excess, static : float
        Lever times mu_cb, mu_sb - mu_cb and mu_sb.
    rate : float
        gamma_b / v_f, by which the slope itself changes with the speed, relative to its value [s/rad].
    """

    coulomb: float
    excess: float
    static: float
    rate: float

    @classmethod
    def of(cls, parameters: DrillstringParameters, lever: float) -> Friction:
        """Derive the constants for a lever."""
        return cls(
            coulomb=lever * parameters.mu_cb,
            excess=lever * (parameters.mu_sb - parameters.mu_cb),
            static=lever * parameters.mu_sb,
            rate=parameters.gamma_b / parameters.v_f,
        )

    def at(self, load: float, speed: Real, fade: Callable[[Real], Real] = fading) -> tuple[Real, Real, Real]:
        """Return the friction in a slip: without the load, with it, and the derivative of the latter by the speed.

        Parameters
        ----------
        load : float
            What the lever does not contain: the weight on bit [N], the weight times R_b [N m], or 1.
        speed : float or ndarray
            Bit speed in the direction of the slip [rad/s]; the friction acts against it.
        fade : callable
            The exponential; that of NumPy for arrays.
        """
        falling = self.excess * fade(-self.rate * speed)
        arm = self.coulomb + falling
        return arm, load * arm, -(load * falling * self.rate)

    def speed_of_slope(self, slope: float, log: Callable[[float], float]) -> float | None:
        """Return the speed of slip [rad/s] at which the derivative is `slope` at load 1; None if none is above rest.

        The logarithm is handed in, since what FMUs compute uses none.
        """
        if slope >= 0.0 or -slope >= self.excess * self.rate:
            return None
        return log(self.excess * self.rate / -slope) / self.rate


def torque_on_bit(parameters: DrillstringParameters, weight: float, speed: float) -> float:
    """Return T of eq. (3) while the bit turns [N m]; 0 at rest, where the torque is the reaction of the rock.

    Parameters
    ----------
    parameters : DrillstringParameters
        Friction parameters.
    weight : float
        Weight on bit [N], at least 0.
    speed : float
        Bit speed [rad/s]; the torque has its sign.
    """
    if speed == 0.0:
        return 0.0
    direction = 1 if speed > 0.0 else -1
    _, dry, _ = Friction.of(parameters, 1.0).at(weight * parameters.R_b, direction * speed)
    return parameters.c_b * speed + dry * direction


@dataclass(frozen=True)
class BitLaw:
    """Constants of the bit equation, derived once from the parameters."""

    twice_impedance: float
    damping: float  # Z + c_b
    viscosity: float  # c_b
    inertia: float
    friction: Friction  # at the lever R_b

    @classmethod
    def of(cls, parameters: DrillstringParameters) -> BitLaw:
        """Derive the constants."""
        impedance = parameters.impedance
        return cls(
            twice_impedance=2.0 * impedance,
            damping=impedance + parameters.c_b,
            viscosity=parameters.c_b,
            inertia=parameters.I_B,
            friction=Friction.of(parameters, parameters.R_b),
        )
