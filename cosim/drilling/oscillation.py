"""Measure a torsional oscillation: peak, period, stuck fraction, mean speed and stick-slip index.

They come from what the plant accumulates between communication points, so their digits do not depend on the step size:
stops and releases are known to the instant, extremes are those within steps, and the mean speed is an angle over a
time.

Each measure is one entry of `MEASURES`, a function with its name, unit and text. Manifest, table and streaming take
them from there. All look at the same `BitMotion`, over a window at the end of the run that its stops suggest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.recording.result import Result
from cosim.system.signals import FloatArray

# A mean speed below this, rad/s, is none.
_NO_SPEED = 1e-9
NEEDED = (
    "bit_speed", "bit_angle", "bit_speed_min", "bit_speed_max", "stuck_time", "last_stop_time", "last_release_time",
    "slip_count", "bit_stuck",
)  # fmt: skip
"""Outputs of a plant without which nothing is measured."""


@dataclass(frozen=True)
class BitMotion:
    """Motion of a bit, and the window over which it is measured.

    Attributes
    ----------
    time : ndarray, shape (rows,)
        Communication points, s.
    outputs : mapping of str to ndarray, shape (rows,)
        Of the plant, by name: those of `NEEDED`, and those that measures ask for besides.
    window : MeasuringWindow
        Times and rows between which to measure.
    """

    time: FloatArray
    outputs: Mapping[str, FloatArray]
    window: MeasuringWindow

    @cached_property
    def steps(self) -> slice:
        """Give the rows at the ends of the steps whose extremes count."""
        return slice(self.window.first_step, self.window.last + 1)

    @property
    def first_speed(self) -> float:
        """Give the bit speed at the first row [rad/s]."""
        return float(self.outputs["bit_speed"][self.window.first])


@dataclass(frozen=True)
class Measure:
    """One measure.

    Parameters
    ----------
    name : str
        Key in manifests, and attribute of `Measures`.
    unit : str
        Empty for what has none.
    text : str
        What it is; heads its column in a table.
    function : callable
        Takes a `BitMotion`; returns a number, or None if there is none.
    decimals : int, optional
        In a table; by default it has no column there.
    outputs : tuple of str
        Outputs of the plant that it takes besides `NEEDED`; without them there is no number.
    """

    name: str
    unit: str
    text: str
    function: Callable[[BitMotion], float | int | None]
    decimals: int | None = None
    outputs: tuple[str, ...] = ()

    @property
    def heading(self) -> str:
        """Write the head of its column, with the unit."""
        return f"{self.text} [{self.unit}]" if self.unit else self.text

    def of(self, motion: BitMotion) -> float | int | None:
        """Return the number."""
        return self.function(motion) if all(name in motion.outputs for name in self.outputs) else None

    def cell(self, value: float | int | None) -> str:
        """Write the number into its column; a dash for none."""
        return "-" if value is None else f"{value:.{self.decimals}f}"


def _peak(motion: BitMotion) -> float:
    """Return the greatest bit speed [rad/s]."""
    return max(motion.first_speed, float(motion.outputs["bit_speed_max"][motion.steps].max()))


def _minimum(motion: BitMotion) -> float:
    """Return the least bit speed [rad/s]."""
    return min(motion.first_speed, float(motion.outputs["bit_speed_min"][motion.steps].min()))


def _stuck_fraction(motion: BitMotion) -> float:
    """Return the part of the window in which the bit is held, 0 to 1."""
    window = motion.window
    stuck = _stuck_until(motion.time, motion.outputs, window.last, window.end)
    stuck -= _stuck_until(motion.time, motion.outputs, window.first, window.start)
    return min(1.0, max(0.0, stuck / (window.end - window.start)))


def _mean_speed(motion: BitMotion) -> float:
    """Divide angle by time [rad/s]; while the bit is held its angle is what it was at the stop."""
    window, angle = motion.window, motion.outputs["bit_angle"]
    duration = window.end - window.start if window.held else motion.time[window.last] - motion.time[window.first]
    return float((angle[window.last] - angle[window.first]) / duration)


def _ssi(motion: BitMotion) -> float:
    """Return (peak - minimum) / (2 mean), infinite if the mean is below 1e-9 rad/s."""
    mean = _mean_speed(motion)
    return (_peak(motion) - _minimum(motion)) / (2.0 * mean) if mean >= _NO_SPEED else math.inf


MEASURES: dict[str, Measure] = {
    each.name: each
    for each in (
        Measure("period", "s", "period", lambda motion: motion.window.period, 7),
        Measure("stops_per_period", "", "stops per period", lambda motion: motion.window.stops_per_period),
        Measure("peak", "rad/s", "peak", _peak, 4),
        Measure("minimum", "rad/s", "minimum", _minimum),
        Measure("stuck_fraction", "", "stuck fraction", _stuck_fraction, 6),
        Measure("mean_speed", "rad/s", "mean speed", _mean_speed, 6),
        Measure("ssi", "", "SSI", _ssi, 4),
    )
}
"""All measures, in the order in which they are told."""


@dataclass(frozen=True)
class Measures:
    """Numbers that an oscillation amounts to over a window at the end of a run.

    Each of `MEASURES` is an attribute: ``found.peak``.

    Attributes
    ----------
    component : str
        Whose bit it is.
    window : str
        What the window is, in words.
    start, end : float
        Of the window, s.
    values : mapping of str to number or None
        By name of measure: `period` [s], None without a cycle that repeats; `stops_per_period`, more than one if the
        cycle holds extra slips; `peak` and `minimum`, greatest and least bit speed [rad/s]; `stuck_fraction`, the part
        of the window in which the bit is held, 0 to 1; `mean_speed` [rad/s]; `ssi`, the stick-slip index
        (peak - minimum) / (2 mean), infinite if the mean is below 1e-9 rad/s.
    """

    component: str
    window: str
    start: float
    end: float
    values: Mapping[str, float | int | None]

    def __getattr__(self, name: str) -> Any:
        values: Mapping[str, float | int | None] = self.__dict__.get("values", {})
        if name not in values:
            raise AttributeError(f"there is no measure '{name}'")
        return values[name]

    def to_json(self) -> dict[str, Any]:
        """Return the entry of a manifest."""
        return {
            "component": self.component, "window": self.window, "start": self.start, "end": self.end, **self.values,
        }  # fmt: skip

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> Measures:
        """Read the entry of a manifest, in which infinite numbers are strings."""
        window = {name: content[name] for name in ("component", "window", "start", "end")}
        values = {name: value for name, value in content.items() if name not in window}
        return cls(**window, values={n: float(v) if isinstance(v, str) else v for n, v in values.items()})


def measure(result: Result, component: str = "plant") -> Measures | None:
    """Measure the bit's oscillation at the end of a run.

    The window is chosen by `cosim.drilling.oscillation.choose_window`.

    Parameters
    ----------
    result : Result
        A run.
    component : str
        Name of the plant.

    Returns
    -------
    Measures or None
        None if the component lacks the outputs this is taken from, or the run ended before its first step was done.
    """
    recorded = [name for name in needed() if f"{component}.{name}" in result]
    if not set(NEEDED) <= set(recorded) or result.time.size < 2:
        return None
    bit = {name: np.asarray(result[f"{component}.{name}"], dtype=np.float64) for name in recorded}
    events = (bit[name] for name in ("last_stop_time", "last_release_time", "slip_count", "bit_stuck"))
    window = choose_window(result.time, find_stops(result.time, *events))
    motion = BitMotion(result.time, bit, window)
    values = {name: each.of(motion) for name, each in MEASURES.items()}
    return Measures(component, window.text, window.start, window.end, values)


def needed() -> tuple[str, ...]:
    """Return the outputs of a plant that measures are taken from."""
    return tuple(dict.fromkeys([*NEEDED, *(name for each in MEASURES.values() for name in each.outputs)]))


def headings() -> tuple[str, ...]:
    """Return the heads of the columns of a table of measures."""
    return tuple(each.heading for each in MEASURES.values() if each.decimals is not None)


def cells(found: Measures | None) -> tuple[str, ...]:
    """Return a row of that table; dashes where nothing was measured."""
    values: Mapping[str, float | int | None] = found.values if found else {}
    return tuple(each.cell(values.get(name)) for name, each in MEASURES.items() if each.decimals is not None)


def _stuck_until(time: FloatArray, bit: Mapping[str, FloatArray], row: int, until: float) -> float:
    """Return the stuck time up to an instant since which the bit has stopped no more before the row's time."""
    release = bit["last_release_time"][row]
    held_until = release if release > until else time[row]
    return float(bit["stuck_time"][row] - (held_until - until))


# Intervals that differ by less than this part of the period repeat.
_REPEATS = 1e-4
_MOST_STOPS_IN_A_PERIOD = 32


@dataclass(frozen=True)
class Stops:
    """The stops of a trajectory.

    Attributes
    ----------
    times : ndarray, shape (n,)
        Exact times at which the bit stopped, s, increasing.
    rows : ndarray of int, shape (n,)
        Row of the first communication point after each.
    held : ndarray of bool, shape (n,)
        Whether the bit was still held at that communication point.
    lost : float or None
        Time until which stops may be missing, s: of several within one communication step, only the last is known. The
        stops are those after it.
    """

    times: FloatArray
    rows: NDArray[np.intp]
    held: NDArray[np.bool_]
    lost: float | None


def find_stops(
    time: FloatArray,
    last_stop_time: FloatArray,
    last_release_time: FloatArray,
    slip_count: FloatArray,
    bit_stuck: FloatArray,
) -> Stops:
    """Find the stops from the plant's own record of them.

    Parameters
    ----------
    time : ndarray, shape (rows,)
        Communication points, s.
    last_stop_time, last_release_time : ndarray, shape (rows,)
        As put out by the plant, s; the start time until the first.
    slip_count, bit_stuck : ndarray, shape (rows,)
        Releases since the start, and 1 while the bit is held; together they tell how many stops a step held.
    """
    stops_in_step = np.diff(slip_count) + np.diff(bit_stuck)
    lossy = np.flatnonzero(stops_in_step > 1) + 1
    first_row = int(lossy[-1]) if lossy.size else 0
    rows = np.flatnonzero(np.diff(last_stop_time) > 0) + 1
    rows = rows[rows >= first_row]
    times = last_stop_time[rows]
    return Stops(times, rows, last_release_time[rows] <= times, float(time[first_row]) if lossy.size else None)


def stops_per_period(times: FloatArray) -> int | None:
    """Find after how many stops the intervals between stops repeat; a cycle may hold a short extra slip.

    Returns
    -------
    int or None
        The least m such that the last m intervals equal the m before them, to 1e-4 of the period; None if there is
        none.
    """
    intervals = np.diff(times)
    for m in range(1, min(_MOST_STOPS_IN_A_PERIOD, intervals.size // 2) + 1):
        last, before = intervals[-m:], intervals[-2 * m : -m]
        if np.abs(last - before).max() <= _REPEATS * last.sum():
            return m
    return None


# So much of the end of a run is looked at, s.
WINDOW = 20.0
# Periods that differ by less than this part are measured together.
_SETTLED = 1e-6
# Without a stop for this many of the longest intervals between stops, the cycle is over.
_PATIENCE = 1.5


@dataclass(frozen=True)
class MeasuringWindow:
    """Times and rows between which to measure.

    Attributes
    ----------
    start, end : float
        s.
    first, last : int
        Rows of `start` and `end`, or of the first communication points after them.
    first_step : int
        Row at the end of the first step whose extremes count.
    text : str
        The window in words.
    period : float, optional
        s.
    stops_per_period : int, optional
        How many stops a period holds.
    held : bool
        Whether the bit's angles at `start` and `end` are those in the rows.
    """

    start: float
    end: float
    first: int
    last: int
    first_step: int
    text: str
    period: float | None = None
    stops_per_period: int | None = None
    held: bool = True


def choose_window(time: FloatArray, stops: Stops) -> MeasuringWindow:
    """Choose what to measure.

    The window is the last whole number of periods, from stop to stop: as many settled ones as fit into 20 s, but at
    least one. If stops do not repeat, it spans those in the last 20 s. Without two stops, or if the bit has since kept
    turning or stood still for longer than it did between stops, it is the last 20 s of the run, or all of a shorter
    one.

    Parameters
    ----------
    time : ndarray, shape (rows,)
        Communication points, s.
    stops : Stops
        What `cosim.drilling.oscillation.find_stops` found.
    """
    if stops.times.size < 2:
        recent = stops.lost is not None and stops.lost > time[-1] - WINDOW
        return _last_seconds(time, ", as a step is too long to show every stop in it" if recent else "")
    per_period = 1 if stops.times.size == 2 else stops_per_period(stops.times)
    if per_period is None:
        first = int(np.searchsorted(stops.times, float(time[-1]) - WINDOW))
        first = min(first, stops.times.size - 2)
        window = _between_stops(stops, first, stops.times.size - 1, "stops that do not repeat")
        intervals = np.diff(stops.times[first:])
    else:
        window = _whole_periods(stops, per_period)
        intervals = np.diff(stops.times)[-per_period:]
    if time[-1] - stops.times[-1] > _PATIENCE * intervals.max():
        return _last_seconds(time, "")
    return window


def _whole_periods(stops: Stops, m: int) -> MeasuringWindow:
    """Span settled periods of m stops, from a stop to a stop at whose communication points the bit is still held.

    Only then is the bit's angle at the stops known. Long steps may leave no such pair; then the last stop will do.
    """
    times, held = stops.times, stops.held
    recent = [stop for stop in range(m, times.size) if times[-1] - times[stop - m] <= WINDOW] or [times.size - 1]
    last = next((stop for stop in reversed(recent) if held[stop] and held[stop - m]), times.size - 1)
    period = times[last] - times[last - m]
    first = earlier = last - m
    while earlier >= m and times[last] - times[earlier - m] <= WINDOW:
        if abs(times[earlier] - times[earlier - m] - period) > _SETTLED * period:
            break
        earlier -= m
        first = earlier if held[earlier] or not held[last] else first
    periods = (last - first) // m
    stops_text = "1 stop" if m == 1 else f"{m} stops"
    window = _between_stops(stops, first, last, f"{periods} {'period' if periods == 1 else 'periods'} of {stops_text}")
    return replace(window, period=(window.end - window.start) / periods, stops_per_period=m)


def _between_stops(stops: Stops, first: int, last: int, what: str) -> MeasuringWindow:
    """Span the time from one stop to another."""
    start, end = float(stops.times[first]), float(stops.times[last])
    row = int(stops.rows[first])
    held = bool(stops.held[first] and stops.held[last])
    text = f"{what}, stop to stop, {start:.6g} s to {end:.6g} s"
    text += "" if held else "; mean speed between the communication points after them"
    return MeasuringWindow(start, end, row, int(stops.rows[last]), row, text, held=held)


def _last_seconds(time: FloatArray, why: str) -> MeasuringWindow:
    """Span the last 20 s between communication points, or the whole of a shorter run."""
    first = max(0, int(np.searchsorted(time, float(time[-1]) - WINDOW * (1 + 1e-12))))
    first = min(first, time.size - 2)
    start, end = float(time[first]), float(time[-1])
    what = "the whole run" if first == 0 else f"the last {end - start:.6g} s"
    return MeasuringWindow(start, end, first, time.size - 1, first + 1, f"{what}, {start:.6g} s to {end:.6g} s{why}")
