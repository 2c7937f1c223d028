"""The weight on bit of eq. (22) as a pythonfmu slave."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fmu_src.fmus.WeightOnBitLaw.interface import MODEL
from fmu_src.python.slave import TableSlave
from models.controllers.laws import WeightOnBitLaw as Law

_AT = {variable.name: index for index, variable in enumerate(MODEL.variables)}


class WeightOnBitLaw(TableSlave):
    """WOB from the bit speed."""

    model = MODEL
    limited = False

    def check(self, values: Sequence[Any]) -> str | None:
        """Return what is wrong between the limits."""
        return self.below(values, "WOB_max", "WOB_0")

    def start(self, values: list[Any], time: float) -> None:
        """Answer the input as it is."""
        self._answer(values, time)

    def step(self, values: list[Any], time: float, end: float) -> None:
        """Answer the input as it is."""
        self._answer(values, end)

    def _answer(self, values: list[Any], time: float) -> None:
        law = Law(values[_AT["K_w"]], values[_AT["WOB_0"]], values[_AT["WOB_max"]])
        values[_AT["WOB"]] = law.weight(values[_AT["bit_speed"]])
        if law.limited(values[_AT["bit_speed"]]) != self.limited:
            self.limited = not self.limited
            self.event(time, "WOB is held at its limit" if self.limited else "WOB is off its limit again")

    def state(self) -> object:
        """Return whether the limit holds, which is all that is remembered."""
        return self.limited

    def restore(self, state: Any) -> None:
        """Remember whether the limit held."""
        self.limited = bool(state)
