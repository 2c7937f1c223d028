"""Stops of the bit, and the period with which they repeat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.signals import FloatArray

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
    complete : bool
        Whether every stop of the run was seen; of several within one communication step, only the last is.
    """

    times: FloatArray
    rows: NDArray[np.intp]
    held: NDArray[np.bool_]
    complete: bool


def find_stops(
    last_stop_time: FloatArray, last_release_time: FloatArray, slip_count: NDArray[np.int32] | None
) -> Stops:
    """Find the stops from the plant's own record of them.

    Parameters
    ----------
    last_stop_time, last_release_time : ndarray, shape (rows,)
        As put out by the plant, s; the start time until the first.
    slip_count : ndarray of int, shape (rows,), optional
        Releases since the start; tells whether one went unseen within a communication step.
    """
    rows = np.flatnonzero(np.diff(last_stop_time) > 0) + 1
    releases = int(np.count_nonzero(np.diff(last_release_time) > 0))
    counted = releases if slip_count is None else int(slip_count[-1] - slip_count[0])
    times = last_stop_time[rows]
    return Stops(times, rows, last_release_time[rows] <= times, counted <= releases)


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
