"""Which part of a run to measure."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cosim.drilling.cycle import Stops, stops_per_period
from cosim.system.signals import FloatArray

# So much of the end of a run is looked at, s.
WINDOW = 20.0
# Periods that differ by less than this part are measured together.
_SETTLED = 1e-6
# Without a stop for this many of the longest intervals between stops, the cycle is over.
_PATIENCE = 1.5


@dataclass(frozen=True)
class Window:
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


def choose_window(time: FloatArray, stops: Stops) -> Window:
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
        What `cosim.drilling.cycle.find_stops` found.
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


def _whole_periods(stops: Stops, m: int) -> Window:
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


def _between_stops(stops: Stops, first: int, last: int, what: str) -> Window:
    """Span the time from one stop to another."""
    start, end = float(stops.times[first]), float(stops.times[last])
    row = int(stops.rows[first])
    held = bool(stops.held[first] and stops.held[last])
    text = f"{what}, stop to stop, {start:.6g} s to {end:.6g} s"
    text += "" if held else "; mean speed between the communication points after them"
    return Window(start, end, row, int(stops.rows[last]), row, text, held=held)


def _last_seconds(time: FloatArray, why: str) -> Window:
    """Span the last 20 s between communication points, or the whole of a shorter run."""
    first = max(0, int(np.searchsorted(time, float(time[-1]) - WINDOW * (1 + 1e-12))))
    first = min(first, time.size - 2)
    start, end = float(time[first]), float(time[-1])
    what = "the whole run" if first == 0 else f"the last {end - start:.6g} s"
    return Window(start, end, first, time.size - 1, first + 1, f"{what}, {start:.6g} s to {end:.6g} s{why}")
