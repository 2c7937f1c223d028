"""Measures of a torsional oscillation: peak, period, stuck fraction, mean speed and stick-slip index.

They come from what the plant accumulates between communication points, so their digits do not depend on the step
size: stops and releases are known to the instant, extremes are those within steps, and the mean speed is an angle over
a time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cosim.drilling.cycle import find_stops
from cosim.drilling.window import Window, choose_window
from cosim.recording.result import Result
from cosim.system.signals import FloatArray

# A mean speed below this, rad/s, is none.
_NO_SPEED = 1e-9
NEEDED = (
    "bit_speed", "bit_angle", "bit_speed_min", "bit_speed_max", "stuck_time", "last_stop_time", "last_release_time",
    "slip_count", "bit_stuck",
)  # fmt: skip
"""Outputs of a plant from which it is measured."""


@dataclass(frozen=True)
class Measures:
    """What an oscillation amounts to over a window at the end of a run.

    Attributes
    ----------
    component : str
        Whose bit it is.
    window : str
        What the window is, in words.
    start, end : float
        Of the window, s.
    period : float or None
        s; None without a cycle that repeats.
    stops_per_period : int or None
        More than one if the cycle holds extra slips.
    peak, minimum : float
        Greatest and least bit speed, rad/s.
    stuck_fraction : float
        Part of the window in which the bit is held, 0 to 1.
    mean_speed : float
        Mean bit speed, rad/s.
    ssi : float
        Stick-slip index (peak - minimum) / (2 mean), infinite if the mean is below 1e-9 rad/s.
    """

    component: str
    window: str
    start: float
    end: float
    period: float | None
    stops_per_period: int | None
    peak: float
    minimum: float
    stuck_fraction: float
    mean_speed: float
    ssi: float


def measure(result: Result, component: str = "plant") -> Measures | None:
    """Measure the bit's oscillation at the end of a run.

    The window is chosen by `cosim.drilling.window.choose_window`.

    Parameters
    ----------
    result : Result
        A run.
    component : str
        Name of the plant.

    Returns
    -------
    Measures or None
        None if the component lacks the outputs this is taken from.
    """
    if any(f"{component}.{name}" not in result for name in NEEDED):
        return None
    bit = {name: np.asarray(result[f"{component}.{name}"], dtype=np.float64) for name in NEEDED}
    events = (bit[name] for name in ("last_stop_time", "last_release_time", "slip_count", "bit_stuck"))
    stops = find_stops(result.time, *events)
    window = choose_window(result.time, stops)
    steps = slice(window.first_step, window.last + 1)
    peak = max(float(bit["bit_speed"][window.first]), float(bit["bit_speed_max"][steps].max()))
    minimum = min(float(bit["bit_speed"][window.first]), float(bit["bit_speed_min"][steps].min()))
    mean = _mean_speed(result.time, bit["bit_angle"], window)
    stuck = _stuck_until(result.time, bit, window.last, window.end)
    stuck -= _stuck_until(result.time, bit, window.first, window.start)
    return Measures(
        component=component,
        window=window.text,
        start=window.start,
        end=window.end,
        period=window.period,
        stops_per_period=window.stops_per_period,
        peak=peak,
        minimum=minimum,
        stuck_fraction=min(1.0, max(0.0, stuck / (window.end - window.start))),
        mean_speed=mean,
        ssi=(peak - minimum) / (2.0 * mean) if mean >= _NO_SPEED else math.inf,
    )


def _mean_speed(time: FloatArray, bit_angle: FloatArray, window: Window) -> float:
    """Divide angle by time; while the bit is held its angle is what it was at the stop."""
    angle = bit_angle[window.last] - bit_angle[window.first]
    duration = window.end - window.start if window.held else time[window.last] - time[window.first]
    return float(angle / duration)


def _stuck_until(time: FloatArray, bit: dict[str, FloatArray], row: int, until: float) -> float:
    """Return the stuck time up to an instant since which the bit has stopped no more before the row's time."""
    release = bit["last_release_time"][row]
    held_until = release if release > until else time[row]
    return float(bit["stuck_time"][row] - (held_until - until))
