"""The weight on bit of eq. (22) as a pythonfmu slave."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fmu_src.fmus.WeightOnBitLaw.interface import MODEL
from fmu_src.python.law import MemorylessLaw
from models.controllers.laws import WeightOnBitLaw as Law


class WeightOnBitLaw(MemorylessLaw):
    """WOB from the bit speed."""

    model = MODEL
    limited = False

    def check(self, values: Sequence[Any]) -> str | None:
        """Return what is wrong between the limits."""
        return self.below(values, "WOB_max", "WOB_0")

    def answer(self, values: list[Any], time: float) -> None:
        """Answer the inputs as they are."""
        law = Law(values[self.at["K_w"]], values[self.at["WOB_0"]], values[self.at["WOB_max"]])
        values[self.at["WOB"]] = law.weight(values[self.at["bit_speed"]])
        if law.limited(values[self.at["bit_speed"]]) != self.limited:
            self.limited = not self.limited
            self.event(time, "WOB is held at its limit" if self.limited else "WOB is off its limit again")

    def state(self) -> object:
        """Return whether the limit holds, which is all that is remembered."""
        return self.limited

    def restore(self, state: Any) -> None:
        """Remember whether the limit held."""
        self.limited = bool(state)
