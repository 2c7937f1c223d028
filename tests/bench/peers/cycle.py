"""Period of the stick-slip cycle, measured alike for every peer from the slips it reports."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

# Of the solution by method of steps in tests/oracle; located Heun runs of up to 102 400 steps a travel time tend to it
# within 1e-9 s.
REFERENCE_PERIOD = 3.2256227289  # s
CYCLES = 10  # whole cycles averaged; favours peers whose stops are rounded to their time grid


class Slips(NamedTuple):
    """Completed slips of one run in order.

    Attributes
    ----------
    releases, stops : ndarray, shape (n,), s
        Slip k begins at ``releases[k]`` and ends at ``stops[k]``.
    """

    releases: NDArray[np.float64]
    stops: NDArray[np.float64]


def cycle_stops(slips: Slips) -> NDArray[np.float64]:
    """Return the stop times that close a cycle [s].

    An echo can free the bit for some tens of milliseconds between two long slips (at 5.578 s here), so a stop counts
    only when its slip lasted more than half as long as the longest of the run.
    """
    durations = slips.stops - slips.releases
    return slips.stops[durations > 0.5 * durations.max(initial=0.0)]


def limit_cycle_period(slips: Slips, cycles: int = CYCLES) -> float:
    """Return the period over the last whole cycles, stop to stop [s].

    Raises
    ------
    ValueError
        If the run holds fewer than ``cycles`` whole cycles.
    """
    stops = cycle_stops(slips)
    if stops.size <= cycles:
        raise ValueError(f"{stops.size} stops close at most {stops.size - 1} cycles; expected at least {cycles}")
    return float(stops[-1] - stops[-1 - cycles]) / cycles


def period_error(slips: Slips) -> float:
    """Return the absolute error of the period against ``REFERENCE_PERIOD`` [s]."""
    return abs(limit_cycle_period(slips) - REFERENCE_PERIOD)
