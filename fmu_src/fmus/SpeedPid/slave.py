"""PI and PID control of the rotor's speed as a pythonfmu slave."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fmu_src.fmus.SpeedPid.interface import MODEL
from fmu_src.python.law import Law, require_short
from models.controllers.speed_pid import PidGains, PidState, stiff, tuned
from models.controllers.speed_pid import SpeedPid as Controller
from models.controllers.virtual_drive import TopOfString

_TUNED, _STIFF = 1, 2


class SpeedPid(Law):
    """A torque of the motor from the rotor's speed; the memory is the controller's state and whether it is engaged."""

    model = MODEL

    def check(self, values: Sequence[Any]) -> str | None:
        """Return that the limits of the torque exclude each other."""
        return self.below(values, "torque_max", "torque_min")

    def begin(self, values: list[Any]) -> tuple[float, ...]:
        """Begin with the speed that is, and the torque given."""
        state = self._controller(values).begin(values[self.at["Omega"]], values[self.at["torque_initial"]])
        return (*state, float(bool(values[self.at["enabled"]])))

    def advance(self, values: list[Any], elapsed: float) -> tuple[float, ...]:
        """Add up the error, and hand over at a switch."""
        require_short(elapsed)
        engaged, enabled = self.memory[3], float(bool(values[self.at["enabled"]]))
        controller, gains = self._controller(values), self._gains(values, engaged)
        speed = values[self.at["Omega"]]
        before = PidState(*self.memory[:3])
        state = controller.advance(gains, before, speed, 0.0, values[self.at["speed_ref"]], elapsed)
        if enabled != engaged:
            state = controller.switched(gains, self._gains(values, enabled), state, speed)
        return (*state, enabled)

    def answer(self, memory: tuple[float, ...], values: list[Any]) -> None:
        """Answer within the limits."""
        least, greatest = values[self.at["torque_min"]], values[self.at["torque_max"]]
        gains = self._gains(values, memory[3])
        wanted = self._controller(values).wanted(gains, PidState(*memory[:3]), values[self.at["Omega"]])
        values[self.at["motor_torque"]] = greatest if wanted > greatest else least if wanted < least else wanted
        values[self.at["limit_active"]] = wanted > greatest or wanted < least

    def tell_changes(self, before: list[Any], values: list[Any], time: float) -> None:
        """Say when the limit begins and ends to hold."""
        at = self.at["limit_active"]
        if values[at] != before[at]:
            self.event(time, f"motor_torque is {'held at its limit' if values[at] else 'off its limit again'}")

    def _controller(self, values: list[Any]) -> Controller:
        names = ("rate_limit", "filter_time", "torque_min", "torque_max")
        return Controller(*(values[self.at[name]] for name in names))

    def _gains(self, values: list[Any], engaged: float) -> PidGains:
        """Return the gains of the mode; switched off, those of an ordinary drive."""
        mode = values[self.at["mode"]] if engaged else _STIFF
        if mode not in (_TUNED, _STIFF):
            return PidGains(*(values[self.at[name]] for name in ("K_p", "K_i", "K_d")))
        string = TopOfString(*(values[self.at[name]] for name in ("G", "J", "I", "L", "I_B")))
        return (tuned if mode == _TUNED else stiff)(string, values[self.at["J_r"]])
