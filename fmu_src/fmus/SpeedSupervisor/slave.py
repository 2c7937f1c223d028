"""A supervisor of stick-slip as a pythonfmu slave."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fmu_src.fmus.SpeedSupervisor.interface import MODEL
from fmu_src.python.law import Law
from models.controllers.supervisor import BINS, Reading, Supervision
from models.controllers.supervisor import SpeedSupervisor as Supervisor

_PARAMETERS = ("window", "severity_max", "threshold", "interval", "speed_step", "speed_max")


class SpeedSupervisor(Law):
    """Severity of stick-slip, and a set point raised by it."""

    model = MODEL

    def check(self, values: Sequence[Any]) -> str | None:
        """Return that the speed would begin beyond its limit."""
        first, limit = values[self.at["speed_initial"]], values[self.at["speed_max"]]
        return f"speed_initial is {first!r}; expected at most speed_max, {limit!r}" if first > limit else None

    def begin(self, values: list[Any]) -> tuple[float, ...]:
        """Begin with nothing known."""
        return _flat(self._supervisor(values).begin(values[self.at["bit_speed"]], values[self.at["speed_initial"]]))

    def advance(self, values: list[Any], elapsed: float) -> tuple[float, ...]:
        """Measure, and decide."""
        bit_speed, measured = values[self.at["bit_speed"]], values[self.at["measured"]]
        valid, enabled = bool(values[self.at["valid"]]), bool(values[self.at["enabled"]])
        given = Reading(bit_speed, 0.0, measured, valid, enabled)
        return _flat(self._supervisor(values).advance(_supervision(self.memory), given, elapsed))

    def answer(self, memory: tuple[float, ...], values: list[Any]) -> None:
        """Answer with severity and set point."""
        state = _supervision(memory)
        values[self.at["severity"]] = state.severity
        values[self.at["speed_ref"]] = state.speed
        values[self.at["limit_active"]] = state.limited != 0.0

    def tell_changes(self, before: list[Any], values: list[Any], time: float) -> None:
        """Say when the speed is raised, and when no further."""
        if values[self.at["speed_ref"]] > before[self.at["speed_ref"]]:
            self.event(time, "the speed is raised")
        if values[self.at["limit_active"]] and not before[self.at["limit_active"]]:
            self.event(time, "the speed is held at its limit")

    def _supervisor(self, values: Sequence[Any]) -> Supervisor:
        return Supervisor(*(values[self.at[name]] for name in _PARAMETERS))


def _flat(state: Supervision) -> tuple[float, ...]:
    *plain, lows, highs, angles = state
    return (*plain, *lows, *highs, *angles)


def _supervision(flat: tuple[float, ...]) -> Supervision:
    clock, parts, low, high, turned, severity, speed, decisions, limited, *rest = flat
    lows, highs, angles = (tuple(rest[BINS * number : BINS * (number + 1)]) for number in range(3))
    return Supervision(clock, parts, low, high, turned, severity, speed, decisions, limited, lows, highs, angles)
