"""Reference experiments of SpeedSupervisor: severities of windows that are laid out at once, in fractions."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

import numpy as np

from tests.reference.experiment import Answers, Experiment, Tolerance, held
from tests.reference.sweep import spread

STEP = Fraction(1, 8)
COUNT = 800
GIVEN = {
    "window": 20.0, "severity_max": 5.0, "threshold": 0.3, "interval": 30.0, "speed_step": 1.0, "speed_initial": 10.0,
    "speed_max": 20.0,
}  # fmt: skip
OTHER = {
    "window": 10.0, "severity_max": 1.5, "threshold": 0.75, "interval": 6.25, "speed_step": 1.5, "speed_initial": 4.0,
    "speed_max": 9.0,
}  # fmt: skip
_SPEEDS = tuple(round(4.0 + 0.01 * place + value, 3) for place, value in enumerate(spread(COUNT, -7.0, 9.0, 0.618)))
_MEASURED = spread(COUNT, -0.5, 2.0, 0.382)
_VALID = tuple(place % 7 != 3 for place in range(COUNT))
_ENABLED = tuple(not 400 <= place < 520 for place in range(COUNT))


class _Answer:
    def __init__(self, parameters: Mapping[str, float]) -> None:
        self.p = {name: Fraction(value) for name, value in {**GIVEN, **parameters}.items()}
        self.speeds = [Fraction(value) for value in _SPEEDS]

    def at(self, times: np.ndarray, step_size: float) -> Answers:
        """Return the outputs at communication points."""
        assert Fraction(step_size) == STEP
        rows = [self._row(Fraction(round(time / step_size)) * STEP) for time in times]
        names = ("severity", "speed_ref", "limit_active")
        return {name: np.array([row[place] for row in rows]) for place, name in enumerate(names)}

    def _row(self, time: Fraction) -> tuple[float, float, bool]:
        speed, limited = self.p["speed_initial"], False
        for number in range(1, int(time // self.p["interval"]) + 1):
            last = int(number * self.p["interval"] / STEP) - 1
            raised = _VALID[last] and _ENABLED[last] and _MEASURED[last] > self.p["threshold"]
            wanted = speed + self.p["speed_step"] * raised
            speed, limited = min(wanted, self.p["speed_max"]), wanted > self.p["speed_max"]
        return float(self._severity(time)), float(speed), limited

    def _severity(self, time: Fraction) -> Fraction:
        """Return that of the window whose last fortieth is complete; the speed at its beginning is one of it."""
        part = self.p["window"] / 40
        end = time // part * part
        if end < self.p["window"]:
            return Fraction(0)
        first, last = int((end - self.p["window"]) / STEP), int(end / STEP)
        inside = self.speeds[max(first - 1, 0) : last]
        mean = sum(self.speeds[first:last], Fraction(0)) / (last - first)
        most = self.p["severity_max"]
        return min((max(inside) - min(inside)) / (2 * mean), most) if mean > 0 else most


_INPUTS = {
    name: held(*((float(place * STEP), float(value)) for place, value in enumerate(values)))
    for name, values in {
        "bit_speed": _SPEEDS, "measured": _MEASURED, "valid": _VALID, "enabled": _ENABLED,
    }.items()
}  # fmt: skip
_TOLERANCES = {
    "severity": Tolerance("rounding: severities of about 1 from sums of 160 angles, in doubles of 1.1e-16", 1e-12),
    "speed_ref": Tolerance("numbers without rounding, and nothing that arrives lies within 1e-4 of the threshold"),
    "limit_active": Tolerance("numbers without rounding"),
}

EXPERIMENTS = (
    Experiment(
        "start", "Bit speeds all over a range that rises, anything that arrives, nothing set",
        float(COUNT * STEP), float(STEP), 1, _Answer({}).at, _TOLERANCES, inputs=_INPUTS,
    ),
    Experiment(
        "limits", "A shorter window and quicker decisions, up to the greatest severity and speed",
        float(COUNT * STEP), float(STEP), 1, _Answer(OTHER).at, _TOLERANCES, OTHER, _INPUTS,
    ),
)  # fmt: skip
