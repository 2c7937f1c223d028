"""Compare results with references: find how far apart they are, and whether that is allowed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cosim.check.reference import SAME_TIME, Series, Tolerance, same_time
from cosim.check.verdict import Comparison
from cosim.system.description import Variable
from cosim.system.signals import FloatArray

RANGE_SHARE = 1e-3
UNSTATED = "none stated, so 0.1 % of the reference's range, and up to one step early or late"
UNSTATED_DISCRETE = "none stated, so equal, and up to one step early or late"


@dataclass(frozen=True)
class Result:
    """One variable over the communication points of a run."""

    variable: Variable
    times: FloatArray
    values: FloatArray


def default_tolerance(variable: Variable, reference: FloatArray, step: float) -> Tolerance:
    """Return what is allowed where nobody has said what is.

    A reference that says nothing of its own accuracy was made to be looked at: a thousandth of a signal's range is less
    than a line's width in a plot. Tools record an event at the communication point before or after it, so that a
    result may be early or late by one step.

    Parameters
    ----------
    variable : Variable
        What is compared.
    reference : ndarray
        All its values.
    step : float
        Communication step size [s].
    """
    if variable.type != "Real":
        return Tolerance(UNSTATED_DISCRETE, time=step)
    reach = float(np.ptp(reference)) or float(np.abs(reference).max())
    return Tolerance(UNSTATED, absolute=RANGE_SHARE * reach, time=step)


def compare(experiment: str, result: Result, references: Series, tolerance: Tolerance) -> Comparison | None:
    """Compare a result with its reference at the times they share.

    Where they share less than half of the reference's times, a continuous result is interpolated.

    Parameters
    ----------
    experiment : str
        Its name.
    result : Result
        At communication points.
    references : Series
        With a column of the variable's name.
    tolerance : Tolerance
        What is allowed.

    Returns
    -------
    Comparison or None
        Where the result is worst; None if there is no time to compare at.
    """
    values = references.column(result.variable.name)
    times = np.unique(references.times)
    inside = times[(times >= result.times[0] - 1e-9) & (times <= result.times[-1] + 1e-9)]
    at, found = _at(result, inside)
    if not at.size:
        return None
    low, high = _band(references.times, values, at, tolerance.time, result.variable)
    off = np.maximum(np.maximum(low - found, found - high), 0.0)
    off = np.where(np.isfinite(found), off, np.inf)
    allowed = tolerance.absolute + tolerance.relative * np.maximum(np.abs(low), np.abs(high))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(off == 0.0, 0.0, off / allowed)
    worst = int(np.argmax(share))
    unit = result.variable.unit.name if result.variable.unit else ""
    nearest = low[worst] if abs(found[worst] - low[worst]) <= abs(found[worst] - high[worst]) else high[worst]
    return Comparison(
        experiment, result.variable.name, unit, float(at[worst]), float(found[worst]), float(nearest),
        float(off[worst]), float(allowed[worst]), int(at.size), tolerance.reason,
    )  # fmt: skip


def _at(result: Result, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return times at which a result can be compared, and its values there."""
    places = np.clip(np.searchsorted(result.times, times), 0, len(result.times) - 1)
    before = np.maximum(places - 1, 0)
    nearer = np.where(np.abs(result.times[before] - times) < np.abs(result.times[places] - times), before, places)
    pairs = zip(result.times[nearer].tolist(), times.tolist(), strict=True)
    shared = np.array([same_time(one, other) for one, other in pairs], dtype=bool)
    if shared.sum() * 2 >= len(times) or result.variable.variability != "continuous":
        return times[shared], result.values[nearer[shared]]
    return times, np.interp(times, result.times, result.values)


def _band(
    times: FloatArray, values: FloatArray, at: FloatArray, reach: float, variable: Variable
) -> tuple[FloatArray, FloatArray]:
    """Return the least and greatest reference within reach [s] of each time."""
    low, high = np.empty(at.size), np.empty(at.size)
    for place, time in enumerate(float(time) for time in at):
        rounding = SAME_TIME * max(1.0, abs(time))
        near = values[np.abs(times - time) <= reach + rounding]
        if reach > 0.0 and variable.variability == "continuous":
            near = np.append(near, np.interp([time - reach, time + reach], times, values))
        elif reach > 0.0:
            held = int(np.searchsorted(times, time - reach + rounding, side="right")) - 1
            near = np.append(near, values[max(held, 0)])
        low[place], high[place] = near.min(), near.max()
    return low, high
