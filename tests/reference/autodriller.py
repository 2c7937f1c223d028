"""Reference experiments of Autodriller: docs/cures.md, equations 26 to 28, with 40 digits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mpmath

from tests.reference.experiment import Experiment, Tolerance
from tests.reference.stepwise import Law, Row, Stepwise
from tests.reference.sweep import spread

STEP = 0.125
"""A number without rounding [s]."""
GIVEN = {
    "k": 5.98e5, "a": 4.85e-9, "W_0": 5000.0, "K_p": 8.361204013377927e-08, "T_i": 60.0, "feed_max": 0.02,
    "WOB_max": 3e5, "WOB_initial": 0.0,
}  # fmt: skip
OTHER = {"k": 4e5, "a": 9e-9, "W_0": 8000.0, "K_p": 4e-7, "T_i": 15.0, "feed_max": 0.006, "WOB_initial": 9e4}


class _Driller:
    def __init__(self, parameters: Mapping[str, float]) -> None:
        self.p = {name: mpmath.mpf(value) for name, value in {**GIVEN, **parameters}.items()}

    def _rate(self, weight: Any, row: Row) -> Any:
        return self.p["a"] * max(weight - self.p["W_0"], 0) * max(row["bit_speed"], 0)

    def begin(self, row: Row) -> Row:
        self.weight, self.depth = self.p["WOB_initial"], mpmath.mpf(0)
        self.sum = min(self._rate(self.weight, row), self.p["feed_max"])
        return self._row(row, self._rate(self.weight, row) > self.p["feed_max"])

    def go_on(self, row: Row, step: Any) -> Row:
        p, before = self.p, self.weight
        error = row["WOB_ref"] - before
        wanted = p["K_p"] * error + self.sum
        feed = min(max(wanted, 0), p["feed_max"])
        if feed == wanted or (wanted > 0) != (error > 0):
            self.sum += p["K_p"] * error * step / p["T_i"]
        # (W1 - W) / h = k (f - a v ((W1 + W) / 2 - W_0)) while the bit drills
        slope = p["k"] * p["a"] * row["bit_speed"] if before > p["W_0"] and row["bit_speed"] > 0 else 0
        free = before + step * (p["k"] * feed - slope * (before - p["W_0"])) / (1 + slope * step / 2)
        self.weight = min(max(free, 0), p["WOB_max"])
        self.depth += step * (self._rate(before, row) + self._rate(self.weight, row)) / 2
        return self._row(row, feed != wanted or free != self.weight)

    def _row(self, row: Row, limited: Any) -> Row:
        rate = self._rate(self.weight, row)
        return {"WOB": self.weight, "rop": rate, "depth": self.depth, "limit_active": bool(limited)}


def _law(parameters: Mapping[str, float]) -> Law:
    def fresh() -> Any:
        driller = _Driller(parameters)
        return driller.begin, driller.go_on

    return fresh


_INPUTS = {
    "WOB_ref": tuple((97347.0, 60000.0, 250000.0)[index // 80] for index in range(240)),
    "bit_speed": tuple(round(6.0 + value, 3) for value in spread(240, -8.0, 12.0, 0.618)),
}
_START = Stepwise(_law({}), _INPUTS, STEP)
_OTHER = Stepwise(_law(OTHER), _INPUTS, STEP)
_TOLERANCES = {
    "WOB": Tolerance("rounding: a weight of at most 3e5 N through some hundred steps, in doubles of 1.1e-16", 1e-7),
    "rop": Tolerance("rounding: a rate of at most 0.03 m/s", 1e-14),
    "depth": Tolerance("rounding: a depth of at most 1 m, added up in some hundred steps", 1e-13),
    "limit_active": Tolerance("no sample lies within 1e-9 of a limit"),
}

EXPERIMENTS = (
    Experiment(
        "start", "Weight put on from 0, taken off and put on again, at bit speeds that jump and turn back",
        _START.stop_time, STEP, 1, _START.answer, _TOLERANCES, inputs=_START.inputs,
    ),
    Experiment(
        "limits", "A harder driller on another string, from weight on, up to the limits of the feed",
        _OTHER.stop_time, STEP, 1, _OTHER.answer, _TOLERANCES, OTHER, _OTHER.inputs,
    ),
)  # fmt: skip
