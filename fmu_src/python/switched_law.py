"""Do what the laws of the drive's speed have in common: `enabled`, the way there and back, and the limit.

While `enabled` is false, `speed_ref` passes through. What is asked for and what is put out differ by a rest that is as
large as the step which the switch would make, and dies away with `handover_time`; so there is no bump, from any state,
and none at the start, which is at `speed_ref`. Switched off, a law goes on observing. native/ds_switched_law.h follows.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

from fmu_src.python.law import Law, require_short
from models.numerics.low_pass import fading


class SwitchedLaw(Law):
    """A law from which `Omega` follows, with the inputs `speed_ref` and `enabled`.

    Its table has the outputs `Omega` and `limit_active` and the parameters `Omega_max` and `handover_time`; the memory
    begins with the rest and whether the law is engaged.
    """

    @abstractmethod
    def remember(self, values: list[Any]) -> tuple[float, ...]:
        """Return the law's own memory at the start from inputs and parameters."""

    @abstractmethod
    def go_on(self, own: tuple[float, ...], values: list[Any], elapsed: float) -> tuple[float, ...]:
        """Return its own memory after `elapsed` seconds in which the inputs are held."""

    @abstractmethod
    def ask(self, own: tuple[float, ...], values: list[Any]) -> float:
        """Return the drive's speed that the law asks for [rad/s]."""

    def begin(self, values: list[Any]) -> tuple[float, ...]:
        """Begin at the speed asked for."""
        own = self.remember(values)
        enabled = bool(values[self.at["enabled"]])
        rest = values[self.at["speed_ref"]] - self.ask(own, values) if enabled else 0.0
        return (rest, float(enabled), *own)

    def advance(self, values: list[Any], elapsed: float) -> tuple[float, ...]:
        """Let the rest die away, and add to it what a switch would make jump."""
        require_short(elapsed)
        rest, engaged, *before = self.memory
        own = self.go_on(tuple(before), values, elapsed)
        rest = rest * fading(elapsed, values[self.at["handover_time"]])
        enabled = float(bool(values[self.at["enabled"]]))
        if enabled != engaged:
            gap = self.ask(own, values) - values[self.at["speed_ref"]]
            rest = rest - gap if enabled else rest + gap
        return (rest, enabled, *own)

    def answer(self, memory: tuple[float, ...], values: list[Any]) -> None:
        """Answer within the limit."""
        rest, engaged, *own = memory
        wanted = (self.ask(tuple(own), values) if engaged else values[self.at["speed_ref"]]) + rest
        limit = values[self.at["Omega_max"]]
        values[self.at["limit_active"]] = wanted > limit or wanted < -limit
        values[self.at["Omega"]] = limit if wanted > limit else -limit if wanted < -limit else wanted

    def tell_changes(self, before: list[Any], values: list[Any], time: float) -> None:
        """Say when the limit begins and ends to hold."""
        at = self.at["limit_active"]
        if values[at] != before[at]:
            self.event(time, "Omega is held at its limit" if values[at] else "Omega is off its limit again")
