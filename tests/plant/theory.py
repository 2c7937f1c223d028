"""Closed forms of the paper's model, written from its equations alone."""

from __future__ import annotations

import cmath
import math

from scipy.optimize import brentq

from tests.oracle import OracleParameters


def torque_on_bit(p: OracleParameters, weight: float, speed: float) -> float:
    """Eqs. (3) and (4) at a speed that is not zero [N m]."""
    friction = p.mu_cb + (p.mu_sb - p.mu_cb) * math.exp(-p.gamma_b / p.v_f * abs(speed))
    return p.c_b * speed + math.copysign(weight * p.R_b * friction, speed)


def slope_of_torque(p: OracleParameters, weight: float, speed: float) -> float:
    """Derivative of eqs. (3) and (4) by a speed above zero [N m s/rad]."""
    rate = p.gamma_b / p.v_f
    return p.c_b - weight * p.R_b * (p.mu_sb - p.mu_cb) * rate * math.exp(-rate * speed)


def drive_of(p: OracleParameters, weight: float, speed: float) -> float:
    """Return the Omega at which string and bit turn steadily at a speed [rad/s]: eq. (2) with nothing accelerating."""
    return speed + torque_on_bit(p, weight, speed) / p.c_a


def equilibrium(p: OracleParameters, omega: float, weight: float) -> float:
    """Return the greatest steady speed at a given Omega [rad/s]; beyond the minimum of `drive_of` it is unique."""
    rate = p.gamma_b / p.v_f
    least = math.log(weight * p.R_b * (p.mu_sb - p.mu_cb) * rate / (p.c_a + p.c_b)) / rate
    return brentq(lambda speed: drive_of(p, weight, speed) - omega, max(least, 1e-9), omega, xtol=1e-14)


def characteristic(p: OracleParameters, weight: float, speed: float, s: complex) -> complex:
    """Eq. (14) about a steady speed: I_B s + T' + Z (1 + Y E) / (1 - Y E) with E = exp(-2 Gamma s)."""
    echo = p.reflection * cmath.exp(-2 * p.travel_time * s)
    return p.I_B * s + slope_of_torque(p, weight, speed) + p.impedance * (1 + echo) / (1 - echo)


def root_near(p: OracleParameters, weight: float, speed: float, guess: complex) -> complex:
    """Return a root of the characteristic equation [1/s] (secant method)."""
    before, root = guess + 1e-3, guess
    value = characteristic(p, weight, speed, before)
    for _ in range(60):
        here = characteristic(p, weight, speed, root)
        if here == value or abs(root - before) < 1e-15:
            break
        before, root, value = root, root - here * (root - before) / (here - value), here
    assert abs(characteristic(p, weight, speed, root)) < 1e-9
    return root


def running(p: OracleParameters, weight: float, speed: float) -> dict[str, float]:
    """Return the start values of steady rotation."""
    return {
        "initial_speed": speed,
        "initial_torque": torque_on_bit(p, weight, speed),
        "WOB": weight,
        "Omega": drive_of(p, weight, speed),
    }
