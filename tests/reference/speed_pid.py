"""Reference experiments of SpeedPid: docs/cures.md, equations 14 to 17, with 40 digits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mpmath

from tests.reference.experiment import Experiment, Tolerance
from tests.reference.stepwise import Law, Row, Stepwise
from tests.reference.sweep import spread
from tests.reference.virtual_drive import STRING, frequency

STEP = 0.0078125
"""A number without rounding [s]."""
GIVEN = {"rate_limit": 2.0, "filter_time": 0.05, "torque_initial": 0.0, "torque_min": 0.0, "torque_max": 6e4}
OWN = {"K_p": 2000.0, "K_i": 9000.0, "K_d": 150.0}
OTHER = {"rate_limit": 6.0, "filter_time": 0.1, "torque_initial": 6000.0, "torque_min": -2000.0, "torque_max": 14000.0}


class _Controller:
    def __init__(self, parameters: Mapping[str, float], own: Mapping[str, float] | None) -> None:
        p = {name: mpmath.mpf(value) for name, value in {**GIVEN, **STRING, **parameters}.items()}
        impedance = mpmath.sqrt(p["I"] * p["G"] * p["J"])
        tuned = {"K_p": 4 * impedance, "K_i": frequency(p, impedance) ** 2 * 2900, "K_d": 0}
        self.p, self.gains = p, {name: mpmath.mpf(value) for name, value in (own or tuned).items()}

    def begin(self, row: Row) -> Row:
        self.set_point = self.smooth = row["Omega"]
        self.sum = self.p["torque_initial"]
        return self._row(row)

    def go_on(self, row: Row, step: Any) -> Row:
        early = self.set_point - row["Omega"]
        way = row["speed_ref"] - self.set_point
        self.set_point += mpmath.sign(way) * min(abs(way), self.p["rate_limit"] * step)
        self.smooth += (row["Omega"] - self.smooth) * (1 - mpmath.exp(-step / self.p["filter_time"]))
        late = self.set_point - row["Omega"]
        before, self.sum = self.sum, self.sum + self.gains["K_i"] * step * (early + late) / 2
        wanted = self._wanted(row)
        if wanted != self._within(wanted) and (wanted > 0) == (late > 0):
            self.sum = before
        return self._row(row)

    def _wanted(self, row: Row) -> Any:
        slope = (row["Omega"] - self.smooth) / self.p["filter_time"]
        return self.gains["K_p"] * (self.set_point - row["Omega"]) + self.sum - self.gains["K_d"] * slope

    def _within(self, torque: Any) -> Any:
        return min(max(torque, self.p["torque_min"]), self.p["torque_max"])

    def _row(self, row: Row) -> Row:
        wanted = self._wanted(row)
        return {"motor_torque": self._within(wanted), "limit_active": bool(wanted != self._within(wanted))}


def _law(parameters: Mapping[str, float], own: Mapping[str, float] | None) -> Law:
    def fresh() -> Any:
        controller = _Controller(parameters, own)
        return controller.begin, controller.go_on

    return fresh


_INPUTS = {
    "speed_ref": tuple(8.0 + 2.0 * (index // 30) for index in range(120)),
    "Omega": spread(120, 6.0, 11.0, 0.618),
}
_TUNED = Stepwise(_law({}, None), _INPUTS, STEP)
_OWN = Stepwise(_law(OTHER, OWN), _INPUTS, STEP)
_TOLERANCES = {
    "motor_torque": Tolerance("rounding: torques of at most 6e4 N m through some hundred steps, in 1.1e-16", 1e-8),
    "limit_active": Tolerance("no sample lies within 1e-6 N m of a limit"),
}

EXPERIMENTS = (
    Experiment(
        "tuned", "Tuned gains from a torque of 0 on, the set point going up in steps",
        _TUNED.stop_time, STEP, 1, _TUNED.answer, _TOLERANCES, inputs=_TUNED.inputs,
    ),
    Experiment(
        "own", "Gains of all three parts given, against both limits",
        _OWN.stop_time, STEP, 1, _OWN.answer, _TOLERANCES, {"mode": "own", **OWN, **OTHER}, _OWN.inputs,
    ),
)  # fmt: skip
