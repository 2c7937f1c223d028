"""Reference experiments of MudPulse: which frame has arrived when, in whole numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction

import numpy as np

from tests.reference.experiment import Answers, Experiment, Tolerance, held
from tests.reference.sweep import spread

STEP = 0.125
COUNT = 200
LOSSY: Mapping[str, float] = {"loss": 0.25, "seed": 77, "L": 1500.0, "bits": 6, "overhead": 4}
RANGED = {"value_min": -20.0, "range": 60.0}
_VALUES = spread(COUNT, -5.0, 45.0, 0.618)


def answer_with(bits: int, overhead: int, length: int, least: int, extent: int, loss: float = 0.0, seed: int = 1):
    """Return what gives the outputs at times, with 10 bit/s and 1200 m/s."""
    return _Answer(bits, overhead, length, least, extent, loss, seed).at


class _Answer:
    def __init__(self, bits: int, overhead: int, length: int, least: int, extent: int, loss: float, seed: int) -> None:
        self.frame = Fraction(bits + overhead, 10)
        self.latency = self.frame + Fraction(length, 1200)
        self.least, self.extent, self.quanta = Fraction(least), Fraction(extent), 2**bits - 1
        modulus = 2**31 - 1
        draws = [seed * pow(48271, k + 1, modulus) % modulus / modulus for k in range(200)]
        self.lost = [drawn < loss for drawn in draws]

    def at(self, times: np.ndarray, step_size: float) -> Answers:
        """Return the outputs at communication points."""
        rows = [self._row(Fraction(round(time / step_size)) * Fraction(step_size)) for time in times]
        names = ("measured", "age", "valid", "limit_active")
        return {name: np.array([row[place] for row in rows]) for place, name in enumerate(names)}

    def _row(self, time: Fraction) -> tuple[float, float, bool, bool]:
        come = int((time - self.latency) // self.frame) if time >= self.latency else -1
        whole = [k for k in range(come + 1) if not self.lost[k]]
        if not whole:
            return float(self.least), float(time), False, False
        sent = whole[-1] * self.frame
        value = Fraction(self._value(sent))
        code = min(max((value - self.least) / self.extent * self.quanta + Fraction(1, 2), 0) // 1, self.quanta)
        measured = self.least + self.extent * code / self.quanta
        return float(measured), float(time - sent), whole[-1] == come, bool(code in (0, self.quanta))

    def _value(self, time: Fraction) -> float:
        """Return the value in the step that ends at a time, or in which it lies."""
        return _VALUES[max(-int(-time // Fraction(STEP)) - 1, 0)]


_INPUTS = {"value": held(*((k * STEP, value) for k, value in enumerate(_VALUES)))}
_EXACT = "what has arrived is one of the quanta, and no value lies within 1e-4 of a quantum of a boundary"
_TOLERANCES = {
    "measured": Tolerance(f"rounding: {_EXACT}", 1e-13),
    "age": Tolerance("rounding in times of at most 25 s", 1e-12),
    "valid": Tolerance("no frame arrives within 1e-6 s of a communication point but at it"),
    "limit_active": Tolerance(_EXACT),
}

_Given = Callable[[np.ndarray, float], Answers]
_START: _Given = answer_with(8, 2, 1172, 0, 40)
_LOSSY: _Given = answer_with(6, 4, 1500, -20, 60, 0.25, 77)

EXPERIMENTS = (
    Experiment(
        "mud-pulse", "Values all over the range and beyond it, nothing set",
        COUNT * STEP, STEP, 1, _START, _TOLERANCES, inputs=_INPUTS,
    ),
    Experiment(
        "losses", "Six bits of another range, from deeper, a quarter of the frames lost",
        COUNT * STEP, STEP, 1, _LOSSY, _TOLERANCES, {**LOSSY, **RANGED}, _INPUTS,
    ),
)  # fmt: skip
