"""The torque on bit, eqs. (3) and (4): viscous damping and set-valued dry friction.

Another friction law is written here and nowhere else: its parameters, and its torque, slope and inverse, which the
bit, the drilling program, equilibria, spectrum and cycles all ask of :class:`Friction`. Parameters that users set have
their rows in the tables of the FMUs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from math import isfinite
from typing import Any, ClassVar, TypeAlias

from ..numerics.exponential import exponential

GREATEST_EXPONENT = 4.0
"""Greatest exponent of the friction where it is continued beyond rest."""

TUNABLE = ("c_b", "mu_cb", "mu_sb", "gamma_b")
"""Parameters of the friction that may change during a run."""

ORDERED = ("mu_sb", "mu_cb")
"""Parameters of which the first must not be below the second."""

Real: TypeAlias = Any
"""A float, or an array of them in the theory: the formulas hold elementwise."""


@dataclass(frozen=True, kw_only=True)
class FrictionParameters:
    """Parameters of the torque on bit by the paper's symbols; the defaults are the paper's values (section 3).

    Attributes
    ----------
    c_b : float
        Damping of the bit [N m s/rad].
    R_b : float
        Bit radius [m].
    mu_cb, mu_sb : float
        Coulomb and static friction coefficients, 0 <= mu_cb <= mu_sb <= 1.
    gamma_b : float
        Velocity decrease rate, in [0, 1].
    v_f : float
        Velocity that makes ``gamma_b |v| / v_f`` a number [rad/s].
    """

    c_b: float = 0.03
    R_b: float = 0.155575
    mu_cb: float = 0.5
    mu_sb: float = 0.8
    gamma_b: float = 0.9
    v_f: float = 1.0

    POSITIVE: ClassVar[frozenset[str]] = frozenset({"R_b", "v_f"})
    """Fields that must not be zero either."""

    def __post_init__(self) -> None:
        """Refuse what is not physical: ValueError with name, value and expected range."""
        for field in fields(self):
            value = getattr(self, field.name)
            if not isfinite(value) or value < 0.0 or (value == 0.0 and field.name in self.POSITIVE):
                bound = "> 0" if field.name in self.POSITIVE else ">= 0"
                raise ValueError(f"parameter {field.name} is {value}; expected a finite value {bound}")
        if self.mu_sb < self.mu_cb or self.mu_sb > 1.0:
            raise ValueError(f"parameter mu_sb is {self.mu_sb}; expected mu_cb = {self.mu_cb} <= mu_sb <= 1")
        if self.gamma_b > 1.0:
            raise ValueError(f"parameter gamma_b is {self.gamma_b}; expected 0 <= gamma_b <= 1")


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
    def of(cls, parameters: FrictionParameters, lever: float) -> Friction:
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


def greatest_fall(parameters: FrictionParameters) -> float:
    """Return by how much the dry friction falls with the bit speed, at most, per weight on bit [m s/rad].

    Raises
    ------
    ValueError
        It does not fall.
    """
    fall: float = -Friction.of(parameters, parameters.R_b).at(1.0, 0.0)[2]
    if fall == 0.0:
        raise ValueError("the friction does not fall with the bit speed; expected mu_sb > mu_cb and gamma_b > 0")
    return fall


def torque_on_bit(parameters: FrictionParameters, weight: float, speed: float) -> float:
    """Return T of eq. (3) while the bit turns [N m]; 0 at rest, where the torque is the reaction of the rock.

    Parameters
    ----------
    parameters : FrictionParameters
        Of the bit.
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
