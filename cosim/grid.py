"""Communication points: when the master and the FMUs meet."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cosim.errors import InputError, format_time
from cosim.signals import FloatArray

# Times closer together than this part of a step are one time: the rounding of t0 + k H, not a step of its own.
_SAME = 1e-6


@dataclass(frozen=True)
class Grid:
    """Communication points and the steps between them.

    Attributes
    ----------
    times : ndarray, shape (n + 1,)
        Communication points, s: start_time + k step_size, never accumulated, and extra ones where asked for.
    sizes : ndarray, shape (n,)
        Communication step sizes, s: exactly step_size between regular points.
    signal_times : ndarray, shape (n + 1,)
        Times at which signals are evaluated, s: as `times`, with the breakpoint itself where one is meant.
    missed : tuple of float
        Breakpoints that lie between communication points, s.
    """

    times: FloatArray
    sizes: FloatArray
    signal_times: FloatArray
    missed: tuple[float, ...]


def communication_points(
    start_time: float, stop_time: float, step_size: float, breakpoints: Iterable[float], can_vary_step: bool
) -> Grid:
    """Lay out the communication points of a run.

    Parameters
    ----------
    start_time, stop_time, step_size : float
        In s.
    breakpoints : iterable of float
        Times at which an input jumps or kinks, s; those outside the run do not matter.
    can_vary_step : bool
        Whether every FMU takes steps of any size, so that breakpoints can become communication points.

    Raises
    ------
    InputError
        If a time is not finite, the step is not positive, nothing is to be simulated, or the stop time cannot be
        reached in equal steps by FMUs that need them.
    """
    _check_times(start_time, stop_time, step_size)
    count = round((stop_time - start_time) / step_size)
    tolerance = _SAME * step_size
    overshoot = start_time + count * step_size - stop_time
    if abs(overshoot) > tolerance:
        if not can_vary_step:
            raise InputError(
                f"stop time {stop_time:g} s is not a whole number of steps of {step_size:g} s after "
                f"{start_time:g} s, as FMUs with a fixed step need"
            )
        count -= overshoot > 0
    regular = start_time + np.arange(count + 1, dtype=np.float64) * step_size
    ragged = [stop_time] if abs(overshoot) > tolerance else []
    end = stop_time if ragged else float(regular[-1])
    inside = np.array(sorted({time for time in breakpoints if start_time < time < end - tolerance}), dtype=np.float64)
    nearest = np.rint((inside - start_time) / step_size).astype(np.intp)
    apart = np.abs(start_time + nearest * step_size - inside) > tolerance
    signal_times = regular.copy()
    signal_times[nearest[~apart]] = inside[~apart]
    if not can_vary_step:
        return Grid(regular, np.full(count, step_size), signal_times, tuple(map(float, inside[apart])))
    return _with_extra(regular, signal_times, np.concatenate([inside[apart], ragged]), step_size)


def _with_extra(regular: FloatArray, signal_times: FloatArray, extra: FloatArray, step_size: float) -> Grid:
    """Merge extra communication points into the regular ones."""
    times = np.concatenate([regular, extra])
    order = np.argsort(times, kind="stable")
    times, signal_times = times[order], np.concatenate([signal_times, extra])[order]
    is_regular = order < regular.size
    sizes = np.where(is_regular[1:] & is_regular[:-1], step_size, np.diff(times))
    return Grid(times, sizes, signal_times, ())


def _check_times(start_time: float, stop_time: float, step_size: float) -> None:
    """Refuse times that no run can have."""
    for name, value in (("start time", start_time), ("stop time", stop_time), ("step size", step_size)):
        if not math.isfinite(value):
            raise InputError(f"{name} is {value} s; expected a finite number")
    if step_size <= 0:
        raise InputError(f"step size is {step_size:g} s; expected a number > 0")
    if stop_time <= start_time:
        raise InputError(f"stop time is {stop_time:g} s; expected a time after the start, {format_time(start_time)} s")
