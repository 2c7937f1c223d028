"""The drive speed law of eq. (9) as a pythonfmu slave."""

from __future__ import annotations

from typing import Any

from fmu_src.fmus.DissipativeLaw.interface import MODEL
from fmu_src.python.law import MemorylessLaw
from models.controllers.laws import DissipativeLaw as Law


class DissipativeLaw(MemorylessLaw):
    """Omega from the speeds at both ends."""

    model = MODEL

    def answer(self, values: list[Any], time: float) -> None:
        """Answer the inputs as they are."""
        guarded, limited = values[self.at["guard_active"]], values[self.at["limit_active"]]
        law = Law(
            values[self.at["c_1"]],
            values[self.at["c_2"]],
            values[self.at["c_a"]],
            values[self.at["c_b"]],
            "printed" if values[self.at["form"]] == 1 else "tracking",
            values[self.at["Omega_max"]],
            values[self.at["top_speed_min"]],
        )
        inputs = (values[self.at[name]] for name in ("top_speed", "bit_speed", "bit_speed_ref", "bit_torque_ref"))
        command = law.command(*inputs)
        values[self.at["Omega"]] = command.omega
        values[self.at["guard_active"]] = command.guard_active
        values[self.at["limit_active"]] = command.limit_active
        if command.guard_active != guarded:
            divisor = "held at top_speed_min" if command.guard_active else "the top speed again"
            self.event(time, f"the divisor of Omega is {divisor}")
        if command.limit_active != limited:
            self.event(time, "Omega is held at its limit" if command.limit_active else "Omega is off its limit again")
