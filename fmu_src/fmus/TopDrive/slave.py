"""A rotary drive as a pythonfmu slave."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

from fmu_src.fmus.TopDrive.interface import MODEL
from fmu_src.python.law import Law
from models.controllers.top_drive import LONGEST_QUEUE, DriveState, Signals
from models.controllers.top_drive import TopDrive as Drive

_MODES: dict[int, Literal["speed", "servo", "torque"]] = {1: "speed", 2: "servo", 3: "torque"}
_INPUTS = ("Omega_command", "motor_torque", "top_torque", "top_speed")
_HELD = Signals(0.0, 0.0, 0.0, 0.0)


class TopDrive(Law):
    """Omega from what is asked for, and the torque of the string."""

    model = MODEL

    def check(self, values: Sequence[Any]) -> str | None:
        """Return that a delay is too long to be kept."""
        delay, most = values[self.at["delay"]], LONGEST_QUEUE * values[self.at["sample_time"]]
        return f"delay is {delay!r} s; expected at most 64 sample times, {most!r} s" if delay > most else None

    def begin(self, values: list[Any]) -> tuple[float, ...]:
        """Begin at the speed asked for."""
        return self._drive(values).begin(self._signals(values), values[self.at["seed"]]).flat()

    def advance(self, values: list[Any], elapsed: float) -> tuple[float, ...]:
        """Follow what is asked for from sample to sample."""
        state = DriveState.of(self.memory)
        return self._drive(values).advance(state, self._signals(values), _HELD, elapsed).flat()

    def answer(self, memory: tuple[float, ...], values: list[Any]) -> None:
        """Answer with speed, torque and what the sensors show."""
        state = DriveState.of(memory)
        values[self.at["Omega"]] = state.turning
        values[self.at["motor_torque_applied"]] = state.motor
        values[self.at["limit_active"]] = state.limited != 0.0
        values[self.at["Omega_measured"]] = state.seen_speed
        values[self.at["top_torque_measured"]] = state.seen_torque
        values[self.at["top_speed_measured"]] = state.seen_top

    def tell_changes(self, before: list[Any], values: list[Any], time: float) -> None:
        """Say when a limit begins and ends to hold."""
        at = self.at["limit_active"]
        if values[at] != before[at]:
            limited = "torque or power of the motor is at its limit"
            self.event(time, limited if values[at] else "the motor is off its limits again")

    def _signals(self, values: list[Any]) -> Signals:
        return Signals(*(values[self.at[name]] for name in _INPUTS))

    def _drive(self, values: list[Any]) -> Drive:
        def of(name: str) -> float:
            return values[self.at[name]]

        return Drive(
            mode=_MODES[values[self.at["mode"]]],
            lag=of("lag"),
            rate=of("rate_limit"),
            inertia=of("J_r"),
            proportional=of("K_p"),
            integral=of("K_i"),
            least=of("torque_min"),
            greatest=of("torque_max"),
            power=of("power_max"),
            sample_time=of("sample_time"),
            delay=of("delay"),
            speed_noise=of("speed_noise"),
            torque_noise=of("torque_noise"),
        )
