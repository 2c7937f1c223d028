"""Soft torque and impedance matching as a pythonfmu slave."""

from __future__ import annotations

from typing import Any

from fmu_src.fmus.SoftTorque.interface import MODEL
from fmu_src.python.virtual_drive_law import VirtualDriveLaw
from models.controllers.virtual_drive import Gains, TopOfString, soft_torque

_RATIOS = {1: 1.5, 2: 1.0}
"""P / Z by mode."""


class SoftTorque(VirtualDriveLaw):
    """Omega from speed and torque at the top of the string."""

    model = MODEL

    def gains_of(self, values: list[Any], string: TopOfString) -> Gains:
        """Return the gains of the mode."""
        mode = values[self.at["mode"]]
        if mode in _RATIOS:
            return soft_torque(string, _RATIOS[mode])
        return Gains(*(values[self.at[name]] for name in ("P", "K", "J_v")))
