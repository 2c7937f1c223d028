"""Bit speed and torque from the top of the string as a pythonfmu slave."""

from __future__ import annotations

from math import sqrt
from typing import Any

from fmu_src.fmus.BitSpeedObserver.interface import MODEL
from fmu_src.python.law import require_short
from fmu_src.python.slave import TableSlave
from models.controllers.observer import BitSpeedObserver as Observer
from models.controllers.observer import Observed, Sample


class BitSpeedObserver(TableSlave):
    """Bit speed, string torque and torque on bit, one travel time late."""

    model = MODEL
    memory: Observed

    def start(self, values: list[Any], time: float) -> None:
        """Begin as if nothing had ever changed."""
        self.memory = self._observer(values).begin(*self._top(values))
        self._answer(values)

    def step(self, values: list[Any], time: float, end: float) -> None:
        """Take speed and torque at the end of the step in."""
        require_short(end - time)
        self.memory = self._observer(values).advance(self.memory, *self._top(values), end - time)
        self._answer(values)

    def _answer(self, values: list[Any]) -> None:
        observer, state = self._observer(values), self.memory
        found = state.up + state.delayed
        values[self.at["bit_speed"]] = found
        values[self.at["string_torque"]] = observer.impedance * (state.delayed - state.up)
        values[self.at["bit_torque"]] = observer.bit_torque(state, found)
        values[self.at["valid"]] = state.valid != 0.0

    def _top(self, values: list[Any]) -> tuple[float, float]:
        return values[self.at["top_speed"]], values[self.at["top_torque"]]

    def _observer(self, values: list[Any]) -> Observer:
        shear, area, inertia, length, bit, smoothing, jump = (
            values[self.at[name]] for name in ("G", "J", "I", "L", "I_B", "filter_time", "jump")
        )
        travel_time = length * sqrt(inertia / (shear * area))
        return Observer(sqrt(inertia * shear * area), travel_time, bit, smoothing, jump)

    def state(self) -> object:
        """Return what has been observed, the samples flat at its end."""
        return [*self.memory[:-1], [list(sample) for sample in self.memory.samples]]

    def restore(self, state: Any) -> None:
        """Take over what had been observed."""
        clock, up, up_change, delayed, valid, speed, torque, samples = state
        kept = tuple(Sample(*sample) for sample in samples)
        self.memory = Observed(clock, up, up_change, delayed, valid, speed, torque, kept)
