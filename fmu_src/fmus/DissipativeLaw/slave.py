"""The drive speed law of eq. (9) as a pythonfmu slave."""

from __future__ import annotations

from typing import Any

from fmu_src.fmus.DissipativeLaw.interface import MODEL
from fmu_src.python.slave import TableSlave
from models.controllers.laws import DissipativeLaw as Law

_AT = {variable.name: index for index, variable in enumerate(MODEL.variables)}


class DissipativeLaw(TableSlave):
    """Omega from the speeds at both ends."""

    model = MODEL

    def start(self, values: list[Any], time: float) -> None:
        """Answer the inputs as they are."""
        self._answer(values, time)

    def step(self, values: list[Any], time: float, end: float) -> None:
        """Answer the inputs as they are."""
        self._answer(values, end)

    def _answer(self, values: list[Any], time: float) -> None:
        guarded, limited = values[_AT["guard_active"]], values[_AT["limit_active"]]
        law = Law(
            values[_AT["c_1"]],
            values[_AT["c_2"]],
            values[_AT["c_a"]],
            values[_AT["c_b"]],
            "printed" if values[_AT["form"]] == 1 else "tracking",
            values[_AT["Omega_max"]],
            values[_AT["top_speed_min"]],
        )
        inputs = (values[_AT[name]] for name in ("top_speed", "bit_speed", "bit_speed_ref", "bit_torque_ref"))
        command = law.command(*inputs)
        values[_AT["Omega"]] = command.omega
        values[_AT["guard_active"]] = command.guard_active
        values[_AT["limit_active"]] = command.limit_active
        if command.guard_active != guarded:
            divisor = "held at top_speed_min" if command.guard_active else "the top speed again"
            self.event(time, f"the divisor of Omega is {divisor}")
        if command.limit_active != limited:
            self.event(time, "Omega is held at its limit" if command.limit_active else "Omega is off its limit again")

    def state(self) -> object:
        """Return None: the law has no memory."""
        return None

    def restore(self, state: Any) -> None:
        """Take nothing over."""
