"""Reference experiments of BitSpeedObserver: waves on a string of which both ends are known in closed form."""

from __future__ import annotations

import mpmath
import numpy as np

from tests.reference.experiment import Answers, Experiment, Points, Tolerance, held
from tests.reference.stepwise import DIGITS

STEP = 0.0078125
"""A number without rounding [s]."""
COUNT, LATE = 400, 96
"""Steps, and how many of them two travel times take."""
STRING = {"G": 8e10, "J": 1.2e-5, "I": 0.09, "I_B": 75.0, "filter_time": 0.05}


def _length() -> mpmath.mpf:
    """Return the length at which two travel times are a whole number of steps, but for what a double cannot hold."""
    speed = mpmath.sqrt(mpmath.mpf(STRING["G"]) * mpmath.mpf(STRING["J"]) / mpmath.mpf(STRING["I"]))
    return mpmath.mpf(float(mpmath.mpf(STEP) * LATE / 2 * speed))


def _top() -> tuple[list[float], list[float]]:
    """Return speed and torque at the top: swings of three frequencies, held for a step each."""
    times = STEP * np.arange(1, COUNT + 1)
    speed = np.round(6.0 + 2.0 * np.sin(2.1 * times) + 0.5 * np.cos(7.3 * times), 6)
    torque = np.round(7000.0 + 3000.0 * np.sin(2.1 * times + 1.0) + 400.0 * np.sin(5.7 * times), 4)
    return speed.tolist(), torque.tolist()


def answer(times: np.ndarray, step_size: float) -> Answers:
    """Return what the sum and the difference of waves give, with 40 digits."""
    with mpmath.workdps(DIGITS):
        Z = mpmath.sqrt(mpmath.mpf(STRING["I"]) * mpmath.mpf(STRING["G"]) * mpmath.mpf(STRING["J"]))
        top = [(mpmath.mpf(y), mpmath.mpf(tau)) for y, tau in zip(*_top(), strict=True)]
        top.insert(0, top[0])
        smooth_v, smooth_t = top[0]
        share = 1 - mpmath.exp(-mpmath.mpf(step_size) / mpmath.mpf(STRING["filter_time"]))
        rows: list[tuple[float, float, float, bool]] = []
        for index, (y, tau) in enumerate(top):
            early_y, early_tau = top[max(index - LATE, 0)]
            v = (y + early_y + (early_tau - tau) / Z) / 2
            pull = (tau + early_tau + Z * (early_y - y)) / 2
            if index:
                smooth_v, smooth_t = smooth_v + share * (v - smooth_v), smooth_t + share * (pull - smooth_t)
            bit = smooth_t - mpmath.mpf(STRING["I_B"]) * (v - smooth_v) / mpmath.mpf(STRING["filter_time"])
            rows.append((float(v), float(pull), float(bit), index >= LATE))
        kept = [rows[round(time / step_size)] for time in times]
        names = ("bit_speed", "string_torque", "bit_torque", "valid")
        return {name: np.array([row[place] for row in kept]) for place, name in enumerate(names)}


def _inputs() -> dict[str, Points]:
    columns = zip(("top_speed", "top_torque"), _top(), strict=True)
    return {name: held(*((k * STEP, value) for k, value in enumerate(values))) for name, values in columns}


_LATER = "the length is rounded: a wave arrives 1e-16 s away from a sample, and rounding"

EXPERIMENTS = (
    Experiment(
        "swings", "Swings of three frequencies at the top, in steps that divide the time a wave takes both ways",
        COUNT * STEP, STEP, 1, answer,
        {
            "bit_speed": Tolerance(_LATER, 1e-11),
            "string_torque": Tolerance(_LATER, 1e-8),
            "bit_torque": Tolerance(f"{_LATER}, of speeds divided by the filter time", 1e-7),
            "valid": Tolerance("no change of a wave is four times that of the step before"),
        },
        {**STRING, "L": float(_length()), "jump": 0.5}, _inputs(),
    ),
)  # fmt: skip
