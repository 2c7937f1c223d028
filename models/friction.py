"""The torque on bit, eqs. (3) and (4): viscous damping and set-valued dry friction."""

from __future__ import annotations

from models.exponential import exponential
from models.parameters import DrillstringParameters


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
