"""A driller that holds the weight on bit as a pythonfmu slave."""

from __future__ import annotations

from typing import Any

from fmu_src.fmus.Autodriller.interface import MODEL
from fmu_src.python.law import Law, require_short
from models.controllers.autodriller import Autodriller as Driller
from models.controllers.autodriller import Drilling

_PARAMETERS = ("k", "a", "W_0", "K_p", "T_i", "feed_max", "WOB_max", "feed_min")


class Autodriller(Law):
    """Weight on bit, rate of penetration and depth."""

    model = MODEL

    def begin(self, values: list[Any]) -> tuple[float, ...]:
        """Begin with the weight given."""
        start = (values[self.at[name]] for name in ("WOB_initial", "bit_speed", "enabled"))
        return (*self._driller(values).begin(*start),)

    def advance(self, values: list[Any], elapsed: float) -> tuple[float, ...]:
        """Feed the string, and drill."""
        require_short(elapsed)
        weight_ref, bit_speed = values[self.at["WOB_ref"]], values[self.at["bit_speed"]]
        enabled = bool(values[self.at["enabled"]])
        return (*self._driller(values).advance(Drilling(*self.memory), weight_ref, bit_speed, enabled, elapsed),)

    def answer(self, memory: tuple[float, ...], values: list[Any]) -> None:
        """Answer with the weight, and what goes with it."""
        state = Drilling(*memory)
        values[self.at["WOB"]] = state.weight
        values[self.at["rop"]] = self._driller(values).rate(state.weight, values[self.at["bit_speed"]])
        values[self.at["depth"]] = state.depth
        values[self.at["limit_active"]] = state.limited != 0.0

    def tell_changes(self, before: list[Any], values: list[Any], time: float) -> None:
        """Say when a limit begins and ends to hold."""
        at = self.at["limit_active"]
        if values[at] != before[at]:
            limited = "feed or weight is held at its limit"
            self.event(time, limited if values[at] else "feed and weight are off their limits again")

    def _driller(self, values: list[Any]) -> Driller:
        return Driller(*(values[self.at[name]] for name in _PARAMETERS))
