"""Reference experiments of TopDrive: docs/cures.md, equations 9 to 13, from sample to sample with 40 digits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mpmath

from tests.reference.experiment import Experiment, Tolerance
from tests.reference.stepwise import Law, Row, Stepwise
from tests.reference.sweep import spread

STEP = 0.0078125
"""A number without rounding [s]."""
NOMINAL = {
    "lag": 0.02, "rate_limit": 10.0, "J_r": 2900.0, "K_p": 15000.0, "K_i": 14500.0, "torque_min": 0.0,
    "torque_max": 6e4, "power_max": 8e5, "speed_noise": 0.0, "torque_noise": 0.0, "seed": 1,
}  # fmt: skip


class _Drive:
    """A drive that takes a sample every so many communication points, its commands late by so many samples."""

    def __init__(self, parameters: Mapping[str, Any], servo: bool, every: int, late: int) -> None:
        given = {**NOMINAL, **parameters}
        self.p = {name: mpmath.mpf(value) for name, value in given.items()}
        self.seed, self.drawn = int(given["seed"]), 0
        self.servo, self.every, self.late = servo, every, late
        self.count = 0

    def begin(self, row: Row) -> Row:
        self.speed = self.set_point = row["Omega_command"]
        self.motor = self.sum = self._within(row["top_torque"])
        self.limited = self.motor != row["top_torque"]
        self.shown = {"Omega": self.speed, "top_torque": row["top_torque"], "top_speed": row["top_speed"]}
        self.waiting = [row["Omega_command"]] * self.late
        return self._row()

    def go_on(self, row: Row, step: Any) -> Row:
        if self.servo:
            self.speed += step * (self.motor - row["top_torque"]) / self.p["J_r"]
        else:
            self.speed = self._approached(step)
        self.count += 1
        if self.count % self.every == 0:
            self._sample(row, step * self.every)
        return self._row()

    def _approached(self, step: Any) -> Any:
        """Return where a speed comes to that goes at the rate until the lag is slower."""
        gap, way = abs(self.set_point - self.speed), mpmath.sign(self.set_point - self.speed)
        slow = self.p["rate_limit"] * self.p["lag"]
        straight = max(gap - slow, 0) / self.p["rate_limit"]
        if straight >= step:
            return self.speed + way * self.p["rate_limit"] * step
        return self.set_point - way * min(gap, slow) * mpmath.exp(-(step - straight) / self.p["lag"])

    def _sample(self, row: Row, between: Any) -> None:
        self.shown = {
            "Omega": self.speed + self._noise("speed_noise"),
            "top_speed": row["top_speed"] + self._noise("speed_noise"),
            "top_torque": row["top_torque"] + self._noise("torque_noise"),
        }
        self.waiting.append(row["Omega_command"])
        asked = self.waiting.pop(0)
        if not self.servo:
            self.set_point, self.motor, self.limited = asked, self._within(row["top_torque"]), False
            return
        most = self.p["rate_limit"] * between
        self.set_point += min(max(asked - self.set_point, -most), most)
        error = self.set_point - self.shown["Omega"]
        wanted = self.p["K_p"] * error + self.sum + self.p["K_i"] * between * error
        self.motor = self._within(wanted)
        self.limited = bool(self.motor != wanted)
        if not self.limited or (wanted - self.motor) * error <= 0:
            self.sum += self.p["K_i"] * between * error

    def _noise(self, name: str) -> Any:
        if not self.p[name]:
            return mpmath.mpf(0)
        total = mpmath.mpf(0)
        for _ in range(12):
            self.drawn += 1
            total += mpmath.mpf(self.seed * pow(48271, self.drawn, 2**31 - 1) % (2**31 - 1)) / (2**31 - 1)
        return self.p[name] * (total - 6)

    def _within(self, torque: Any) -> Any:
        most = min(self.p["torque_max"], self.p["power_max"] / abs(self.speed))
        return min(max(torque, self.p["torque_min"]), most)

    def _row(self) -> Row:
        shown = {f"{name}_measured": value for name, value in self.shown.items()}
        return {"Omega": self.speed, "motor_torque_applied": self.motor, "limit_active": bool(self.limited), **shown}


def _law(parameters: Mapping[str, Any], servo: bool, every: int, late: int) -> Law:
    def fresh() -> Any:
        drive = _Drive(parameters, servo, every, late)
        return drive.begin, drive.go_on

    return fresh


_INPUTS = {
    "Omega_command": tuple(round(8.0 + 3.0 * (index // 12 % 3) + 0.03 * (index % 12), 3) for index in range(96)),
    "top_torque": spread(96, 2000.0, 14000.0, 0.755),
    "top_speed": spread(96, 2.0, 14.0, 0.618),
}
_NOISY = {"speed_noise": 0.05, "torque_noise": 150.0, "seed": 20111}
_LIMITED = {"rate_limit": 30.0, "torque_max": 25000.0, "power_max": 2e5, "J_r": 1500.0}
_SPEED = Stepwise(_law(_NOISY, False, 1, 0), _INPUTS, STEP)
_SERVO = Stepwise(_law(_LIMITED, True, 2, 3), _INPUTS, STEP)
_SPEEDS = Tolerance("rounding: a speed of at most 20 rad/s through a hundred steps, in doubles of 1.1e-16", 1e-12)
_TORQUES = Tolerance("rounding: gains of 1.5e4 N m s/rad take up errors of the speed of 1e-13 rad/s", 1e-8)
_TOLERANCES = {
    "Omega": _SPEEDS, "Omega_measured": _SPEEDS, "top_speed_measured": _SPEEDS,
    "motor_torque_applied": _TORQUES, "top_torque_measured": _TORQUES,
    "limit_active": Tolerance("no sample lies within 1e-6 N m of a limit"),
}  # fmt: skip

EXPERIMENTS = (
    Experiment(
        "speed", "A speed behind lag and rate limit, with noisy sensors, sampled at every communication point",
        _SPEED.stop_time, STEP, 1, _SPEED.answer, _TOLERANCES, {**_NOISY, "sample_time": STEP}, _SPEED.inputs,
    ),
    Experiment(
        "servo", "A rotor with its controller, sampled at every other point, late by three samples, at its limits",
        _SERVO.stop_time, STEP, 1, _SERVO.answer, _TOLERANCES,
        {"mode": "servo", **_LIMITED, "sample_time": 2 * STEP, "delay": 6 * STEP}, _SERVO.inputs,
    ),
)  # fmt: skip
