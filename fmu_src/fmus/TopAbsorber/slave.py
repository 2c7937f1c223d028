"""A table on spring and damper at the top of the string as a pythonfmu slave."""

from __future__ import annotations

from typing import Any

from fmu_src.fmus.TopAbsorber.interface import MODEL
from fmu_src.python.virtual_drive_law import VirtualDriveLaw
from models.controllers.virtual_drive import Gains, TopOfString, absorber


class TopAbsorber(VirtualDriveLaw):
    """Omega from speed and torque at the top of the string."""

    model = MODEL

    def gains_of(self, values: list[Any], string: TopOfString) -> Gains:
        """Return damping, stiffness and inertia of the table."""
        if values[self.at["mode"]] == 1:
            return absorber(string)
        return Gains(*(values[self.at[name]] for name in ("c_f", "k_f", "J_a")))
