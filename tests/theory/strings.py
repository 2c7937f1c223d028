"""The strings the theory is tested on, once for the theory and once for the oracle."""

from __future__ import annotations

from dataclasses import asdict, replace

from models.plant.parameters import DrillstringParameters
from tests.oracle import OracleParameters

PAPER = DrillstringParameters()
NOMINAL, LIGHT = 97347.0, 31649.0
STRINGS = {
    "paper": PAPER,
    "heavy bit": replace(PAPER, I_B=311.0),
    "very heavy bit": replace(PAPER, I_B=12000.0),
    "light bit": replace(PAPER, I_B=3.0),
    "damped bit": replace(PAPER, c_b=150.0),
    "long": replace(PAPER, L=5000.0),
    "hard top": replace(PAPER, c_a=20000.0),
    "nearly matched top": replace(PAPER, c_a=320.0),
    "soft top": replace(PAPER, c_a=120.0),
    "very soft top": replace(PAPER, c_a=20.0),
}


def oracle_of(parameters: DrillstringParameters, speed: float = 0.0, torque: float = 0.0) -> OracleParameters:
    """Return the same string for the oracle, with a uniform rotation [rad/s] and torque [N m] before the start."""
    return OracleParameters(**asdict(parameters), initial_speed=speed, initial_torque=torque)
