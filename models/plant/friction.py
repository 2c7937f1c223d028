"""The torque on bit, eqs. (3) and (4): viscous damping and set-valued dry friction."""

from __future__ import annotations

from dataclasses import dataclass

from ..numerics.exponential import exponential
from .parameters import DrillstringParameters

GREATEST_EXPONENT = 4.0
"""Where the friction is continued beyond rest, its exponent is kept below this."""


def friction_coefficient(parameters: DrillstringParameters, speed: float) -> float:
    """Return mu_b of eq. (4) at a bit speed [rad/s]."""
    rate = parameters.gamma_b / parameters.v_f
    return parameters.mu_cb + (parameters.mu_sb - parameters.mu_cb) * exponential(-rate * abs(speed))


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
    dry = weight * parameters.R_b * friction_coefficient(parameters, speed)
    return parameters.c_b * speed + (dry if speed > 0.0 else -dry)


@dataclass(frozen=True)
class BitLaw:
    """Constants of the bit equation, derived once from the parameters."""

    twice_impedance: float
    damping: float  # Z + c_b
    viscosity: float  # c_b
    inertia: float
    coulomb: float  # R_b mu_cb
    excess: float  # R_b (mu_sb - mu_cb)
    static: float  # R_b mu_sb
    rate: float  # gamma_b / v_f

    @classmethod
    def of(cls, parameters: DrillstringParameters) -> BitLaw:
        """Derive the constants."""
        impedance = parameters.impedance
        return cls(
            twice_impedance=2.0 * impedance,
            damping=impedance + parameters.c_b,
            viscosity=parameters.c_b,
            inertia=parameters.I_B,
            coulomb=parameters.R_b * parameters.mu_cb,
            excess=parameters.R_b * (parameters.mu_sb - parameters.mu_cb),
            static=parameters.R_b * parameters.mu_sb,
            rate=parameters.gamma_b / parameters.v_f,
        )

    def fading(self, direction: int, speed: float) -> float:
        """Return the exponential of eq. (4) in a slip in `direction` (1 or -1), continued smoothly through rest.

        Beyond rest it only serves the search for the stop; there it is capped.
        """
        exponent = -self.rate * (direction * speed)
        return exponential(exponent if exponent < GREATEST_EXPONENT else GREATEST_EXPONENT)
