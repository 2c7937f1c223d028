"""Lay out the communication points, at which the master and the FMUs meet."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError, format_time
from cosim.system.signals import FloatArray

# Times closer together than this part of a step are one time: the rounding of t0 + k H, not a step of its own.
_SAME = 1e-6

IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class Points:
    """Successive communication points and the steps between them.

    Attributes
    ----------
    times : ndarray, shape (n + 1,)
        Communication points, s.
    sizes : ndarray, shape (n,)
        Communication step sizes, s.
    signal_times : ndarray, shape (n + 1,)
        Times at which signals are evaluated, s: as `times`, with the breakpoint itself where one is meant.
    """

    times: FloatArray
    sizes: FloatArray
    signal_times: FloatArray


@dataclass(frozen=True)
class Grid:
    """The communication points of a run by number, laid out a stretch at a time, as there may be any number of them.

    Attributes
    ----------
    start_time, step_size : float
        s. Regular points are at start_time + k step_size, never accumulated.
    steps : int
        Communication steps in all.
    extra, extra_times : ndarray, shape (m,)
        Numbers of the points that are not regular, increasing, and their times, s.
    meant, meant_times : ndarray, shape (k,)
        Numbers of the regular points that stand for breakpoints a rounding away, and the breakpoints, s.
    missed : tuple of float
        Breakpoints that lie between communication points, s.
    """

    start_time: float
    step_size: float
    steps: int
    extra: IntArray
    extra_times: FloatArray
    meant: IntArray
    meant_times: FloatArray
    missed: tuple[float, ...]

    def points(self, first: int = 0, last: int | None = None) -> Points:
        """Return the points numbered `first` to `last`, by default all; steps between regular ones are step_size."""
        numbers = np.arange(first, (self.steps if last is None else last) + 1)
        if not self.extra.size and not self.meant.size:
            times = np.asarray(self.start_time + numbers * self.step_size, dtype=np.float64)
            return Points(times, self._ended(times, np.full(times.size - 1, self.step_size), numbers), times)
        before = np.searchsorted(self.extra, numbers)
        times = np.asarray(self.start_time + (numbers - before) * self.step_size, dtype=np.float64)
        extra = self._within(self.extra, first, numbers.size)
        times[self.extra[extra] - first] = self.extra_times[extra]
        regular = np.ones(numbers.size, dtype=np.bool_)
        regular[self.extra[extra] - first] = False
        meant = self._within(self.meant, first, numbers.size)
        signal_times = times.copy()
        signal_times[self.meant[meant] - first] = self.meant_times[meant]
        sizes = np.where(regular[1:] & regular[:-1], self.step_size, np.diff(times))
        return Points(times, self._ended(times, sizes, numbers), signal_times)

    def _ended(self, times: FloatArray, sizes: FloatArray, numbers: IntArray) -> FloatArray:
        """Return sizes of steps of which the last one of the run does not go beyond its end."""
        if sizes.size and numbers[-1] == self.steps:
            sizes[-1] = within(float(times[-2]), float(sizes[-1]), float(times[-1]))
        return sizes

    @property
    def end(self) -> float:
        """The last communication point, s."""
        return float(self.points(self.steps, self.steps).times[0])

    def after(self, time: float) -> float:
        """Return the first regular communication point at or after a time within the run, both s."""
        number = math.ceil((time - self.start_time) / self.step_size)
        return next(point for point in map(self._regular, range(max(0, number - 1), number + 2)) if point >= time)

    def _regular(self, number: int) -> float:
        return self.start_time + number * self.step_size

    @staticmethod
    def _within(numbers: IntArray, first: int, count: int) -> slice:
        """Return where those of increasing numbers are that lie in a range."""
        begin, end = np.searchsorted(numbers, (first, first + count))
        return slice(int(begin), int(end))


def within(time: float, size: float, stop_time: float) -> float:
    """Return the size of a step, less by rounding where its end, as an FMU adds it up, would be beyond the stop time.

    99.99 s + 0.01 s is more than 100 s, and an FMU may refuse to step beyond the stop time it was given (FMI 2.0,
    section 4.2.1).
    """
    while time + size > stop_time:
        size = min(stop_time - time, math.nextafter(size, 0.0))
    return size


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
    apart_from_end = abs(overshoot) > tolerance or count == 0
    if apart_from_end:
        if not can_vary_step:
            raise InputError(
                f"stop time {stop_time:g} s is not a whole number of steps of {step_size:g} s after "
                f"{start_time:g} s, as FMUs with a fixed step need"
            )
        count -= overshoot > 0
    ragged = [stop_time] if apart_from_end else []
    end = stop_time if ragged else start_time + count * step_size
    inside = np.array(sorted({time for time in breakpoints if start_time < time < end - tolerance}), dtype=np.float64)
    nearest = np.rint((inside - start_time) / step_size).astype(np.int64)
    apart = np.abs(start_time + nearest * step_size - inside) > tolerance
    extra_times = np.concatenate([inside[apart], ragged]) if can_vary_step else np.zeros(0)
    extra = _regular_before(extra_times, start_time, step_size) + 1 + np.arange(extra_times.size)
    meant_times = inside[~apart]
    meant = nearest[~apart] + np.searchsorted(extra_times, meant_times)
    missed = () if can_vary_step else tuple(map(float, inside[apart]))
    steps = count + extra_times.size
    return Grid(start_time, step_size, steps, extra, extra_times, meant, meant_times, missed)


def _regular_before(times: FloatArray, start_time: float, step_size: float) -> IntArray:
    """Return the numbers of the last regular points at or before times, as they are after rounding."""
    numbers = np.floor((times - start_time) / step_size).astype(np.int64)
    numbers += start_time + (numbers + 1) * step_size <= times
    return numbers - (start_time + numbers * step_size > times)


def _check_times(start_time: float, stop_time: float, step_size: float) -> None:
    """Refuse times that no run can have."""
    for name, value in (("start time", start_time), ("stop time", stop_time), ("step size", step_size)):
        if not math.isfinite(value):
            raise InputError(f"{name} is {value} s; expected a finite number")
    if step_size <= 0:
        raise InputError(f"step size is {step_size:g} s; expected a number > 0")
    if stop_time <= start_time:
        raise InputError(f"stop time is {stop_time:g} s; expected a time after the start, {format_time(start_time)} s")
    if stop_time - step_size == stop_time or start_time + step_size == start_time:
        raise InputError(f"step size is {step_size:g} s; expected one that tells times near {stop_time:g} s apart")
