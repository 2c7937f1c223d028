"""Stops of the bit, and the period with which they repeat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.system.signals import FloatArray

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
