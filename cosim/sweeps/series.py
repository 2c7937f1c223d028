"""Keep how signals go on over time at some points of a sweep, evenly spread over its grid, beside its numbers.

They lie in a group of the store, an array for each signal over the same dimensions, with the values that are kept, and
over time. The numbers of a point do not know of it: where one long step will do for them, a point that is kept is run
once more, in the steps that are kept.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError, SystemDefinitionError, format_time, suggestion
from cosim.sweeps.arrays import Array, coordinate, described, stored_name
from cosim.sweeps.design import SAMPLES, Axis, Design
from cosim.sweeps.reading import SERIES, TIME, place_of, quiet, reader
from cosim.system.description import Description
from cosim.system.signals import FloatArray

EVERY = 0.1
"""Between kept times, s, where nothing else is said: a quarter of the travel time of the paper's string."""
POINTS = 100
"""At how many points of a grid series are kept, where nothing else is said."""
MESSAGE = "message"
_MOST_ROWS = 1_000_000
_LARGEST_CHUNK = 16_000_000
_SAME = 1e-6
_MESSAGE = "why there is no series of a point that has numbers"


@dataclass(frozen=True)
class Wanted:
    """Ask for outputs to be kept over time.

    Attributes
    ----------
    signals : sequence of str
        Outputs, as ``component.variable``.
    every : float or None
        Between rows, s; None: about `EVERY`.
    points : int
        At how many points of the grid at most; of each of them all samples, and all components in turn.
    """

    signals: Sequence[str]
    every: float | None = None
    points: int = POINTS


@dataclass(frozen=True)
class Rows:
    """Lay out the rows of a series, as workers know them.

    Attributes
    ----------
    signals : tuple of str
        Outputs, as ``component.variable``.
    every : float
        Between rows, s.
    first, last : int
        Numbers of the first and the last row, counted from the beginning of a point.
    """

    signals: tuple[str, ...]
    every: float
    first: int
    last: int

    @property
    def count(self) -> int:
        """Return how many there are."""
        return self.last + 1 - self.first

    def times(self, begin: float, end: float) -> FloatArray:
        """Return their times [s], for a point that is run between two times; none is later by a rounding."""
        numbers = np.arange(self.first, self.last + 1, dtype=np.float64)
        return np.minimum(begin + numbers * self.every, end)

    def picked(self, since: FloatArray, columns: Mapping[str, FloatArray]) -> FloatArray | str:
        """Pick them out of the rows of a run, by times since the point began [s]; or say which one there is not."""
        numbers = np.rint(since / self.every)
        hits = np.abs(since - numbers * self.every) <= _SAME * self.every
        places = numbers[hits].astype(np.int64) - self.first
        rows = np.flatnonzero(hits)[(places >= 0) & (places < self.count)]
        places = places[(places >= 0) & (places < self.count)]
        missing = np.setdiff1d(np.arange(self.count), places)
        if missing.size:
            return f"the run has no row {format_time((int(missing[0]) + self.first) * self.every)} s after it began"
        found = np.empty((len(self.signals), self.count))
        for number, name in enumerate(self.signals):
            found[number, places] = columns[name][rows]
        return found


def rows_of(wanted: Wanted, duration: float, step_size: float | None, *, continued: bool) -> Rows:
    """Say which rows of series are kept.

    Parameters
    ----------
    wanted : Wanted
        What is asked for.
    duration : float
        Of a point, s.
    step_size : float or None
        In which points are run anyhow, s; None: steps may be any.
    continued : bool
        Whether a run goes on over several points; the first row of each is the last one of the point before, and is
        left out.

    Raises
    ------
    InputError
        If no rows can be had so.
    """
    every = wanted.every
    if every is None:
        most = duration if step_size is None else math.floor(duration / step_size * (1.0 + _SAME)) * step_size
        usual = EVERY if step_size is None else math.ceil(EVERY / step_size * (1.0 - _SAME)) * step_size
        every = min(usual, most, duration)  # of which the second is greater by a rounding at times
    if not 0.0 < every <= duration:
        raise InputError(f"series are to be kept every {every:g} s of points of {duration:g} s; expected less, and > 0")
    strides = 1.0 if step_size is None else every / step_size
    if round(strides) < 1 or abs(strides - round(strides)) > _SAME:
        raise InputError(
            f"series are to be kept every {every:g} s; expected a multiple of the step size, {step_size:g} s"
        )
    last = math.floor(duration / every * (1.0 + 1e-12))
    if last > _MOST_ROWS:
        raise InputError(f"series are to be kept every {every:g} s, at {last} times; expected {_MOST_ROWS} at most")
    return Rows(tuple(dict.fromkeys(wanted.signals)), every, 1 if continued else 0, last)


@dataclass(frozen=True)
class Kept:
    """Say which points of a sweep keep signals over time, and which rows.

    Attributes
    ----------
    rows : Rows
        Of what, and when.
    indices : tuple of tuple of int
        For each axis: which of its values; a point is kept where all of its own are among them.
    told : mapping of str to (str, str)
        By signal: its unit, and what it is.
    times : ndarray, shape (rows.count,)
        Of the rows of a point, s.
    """

    rows: Rows
    indices: tuple[tuple[int, ...], ...]
    told: Mapping[str, tuple[str, str]]
    times: FloatArray

    @cached_property
    def _places(self) -> tuple[dict[int, int], ...]:
        return tuple({index: place for place, index in enumerate(each)} for each in self.indices)

    def place(self, indices: Sequence[int]) -> tuple[int, ...] | None:
        """Return where a point is among those that are kept; None if it is not."""
        found = [places.get(index) for index, places in zip(indices, self._places, strict=True)]
        return None if None in found else tuple(each for each in found if each is not None)

    @property
    def shape(self) -> tuple[int, ...]:
        """Return how many values of each axis are kept."""
        return tuple(len(each) for each in self.indices)

    def record(self, design: Design) -> dict[str, Any]:
        """Return what decides the series, as JSON can hold it."""
        chosen = {
            axis.name: "all" if len(kept) == axis.size else list(kept)
            for axis, kept in zip(design.axes, self.indices, strict=True)
        }
        return {"signals": list(self.rows.signals), "every": self.rows.every, "points": chosen}


def kept_of(
    wanted: Wanted,
    design: Design,
    choices: Iterable[Mapping[str, Description]],
    times: tuple[float, float],
    step_size: float | None,
) -> Kept:
    """Check what is wanted over time, and say of which points it is kept.

    Parameters
    ----------
    wanted : Wanted
        What is asked for.
    design : Design
        The points.
    choices : iterable of mapping of str to Description
        By component, for each choice of FMUs.
    times : (float, float)
        When points begin, and how long they are run, s.
    step_size : float or None
        As of `rows_of`.

    Raises
    ------
    InputError
        If something is no output, or no rows can be had so.
    """
    told: dict[str, tuple[str, str]] = {}
    for descriptions in choices:
        for name in wanted.signals:
            told.setdefault(name, _output(name, descriptions))
    begin, duration = times
    rows = rows_of(wanted, duration, step_size, continued=design.along is not None)
    return Kept(rows, spread(design, wanted.points), told, rows.times(begin, begin + duration))


def _output(name: str, descriptions: Mapping[str, Description]) -> tuple[str, str]:
    """Return unit and description of an output that is a number; refuse what is none."""
    component, _, variable = name.partition(".")
    if component not in descriptions:
        raise SystemDefinitionError(
            f"{name} is to be kept: there is no such component{suggestion(component, descriptions)}"
        )
    known = descriptions[component]
    outputs = {each.name: each for each in known.with_causality("output") if each.type != "String"}
    if variable not in outputs:
        what = f"{name} is to be kept, and {known.model_name} has no output of that name that is a number"
        raise SystemDefinitionError(f"{what}{suggestion(variable, outputs)}")
    found = outputs[variable]
    return found.unit.name if found.unit else "", found.description


def spread(design: Design, most: int) -> tuple[tuple[int, ...], ...]:
    """Choose points evenly over the numbers of a grid, its corners among them; of all else, everything.

    Raises
    ------
    InputError
        If there are to be none.
    """
    if most < 1:
        raise InputError(f"series are to be kept at {most} points; expected one at least")
    sizes = [axis.size for axis in design.axes if _is_spread(axis)]
    along = min(most, max(sizes, default=1))
    while math.prod(min(size, along) for size in sizes) > most:
        along -= 1
    return tuple(
        tuple(np.unique(np.rint(np.linspace(0, axis.size - 1, min(axis.size, along))).astype(np.int64)).tolist())
        if _is_spread(axis)
        else tuple(range(axis.size))
        for axis in design.axes
    )


def _is_spread(axis: Axis) -> bool:
    """Tell whether some values of an axis will do: those of a grid of numbers."""
    return axis.name != SAMPLES and not isinstance(next(iter(axis.values.values()))[0], str)


class SeriesStore:
    """The series in a store, written by regions as the numbers are.

    Parameters
    ----------
    path : Path
        The store.
    kept : Kept
        What is kept.
    design : Design
        The points.
    rows : int
        How many rows a region has, along the first axis that lines are numbered by.
    """

    def __init__(self, path: Path, kept: Kept, design: Design, rows: int) -> None:
        self._path, self._kept, self._design, self._rows = path, kept, design, rows
        self._first = design.across[0] if design.across else None
        self._buffers: dict[int, dict[str, NDArray[Any]]] = {}

    def put(self, region: int, indices: Sequence[int], content: bytes, message: str) -> None:
        """Take the series of a point, or why there is none; ValueError if that is neither."""
        place = self._kept.place(indices)
        if place is None:
            raise ValueError
        buffer = self._buffers.setdefault(region, {}) or self._buffer(region)
        where = list(place)
        if self._first is not None:
            where[self._first] -= self._within(region).start
        buffer[MESSAGE][tuple(where)] = message
        values = np.frombuffer(content, "<f8").reshape(-1, self._kept.rows.count)
        for name, series in zip(self._kept.rows.signals, values, strict=not message):
            buffer[name][tuple(where)] = series

    def write(self, region: int) -> None:
        """Write what there is of a region."""
        buffer = self._buffers.get(region)
        if not buffer:
            return
        names = [stored_name(axis.name) for axis in self._design.axes]
        where = {name: slice(None) for name in (*names, TIME)}
        if self._first is not None:
            where[names[self._first]] = self._within(region)
        series = {stored_name(name): ([*names, TIME], values) for name, values in buffer.items() if name != MESSAGE}
        whole = reader().Dataset({**series, MESSAGE: (names, buffer[MESSAGE])})
        with quiet():
            whole.to_zarr(place_of(self._path), group=SERIES, region=where, mode="r+", consolidated=True)

    def drop(self, region: int) -> None:
        """Forget a region, which is written."""
        self._buffers.pop(region, None)

    def _within(self, region: int) -> slice:
        """Return the kept values of the first axis that lie in a region."""
        assert self._first is not None
        ends = np.searchsorted(self._kept.indices[self._first], [region * self._rows, (region + 1) * self._rows])
        return slice(int(ends[0]), int(ends[1]))

    def _buffer(self, region: int) -> dict[str, NDArray[Any]]:
        """Make the memory of a region."""
        shape = list(self._kept.shape)
        if self._first is not None:
            within = self._within(region)
            shape[self._first] = within.stop - within.start
        buffer = self._buffers[region]
        buffer.update({name: np.full((*shape, self._kept.rows.count), np.nan) for name in self._kept.rows.signals})
        buffer[MESSAGE] = np.full(shape, "", dtype=object)
        return buffer


def arrays(kept: Kept, design: Design, rows: int) -> dict[str, Array]:
    """Return the series of a store in which there is none yet; `rows` is as of `SeriesStore`."""
    names = [axis.name for axis in design.axes]
    chunks = _chunks(kept, design, rows)
    shape = (*kept.shape, kept.rows.count)
    return {
        **{
            name: Array([*names, TIME], shape, np.float64, chunks, np.nan, None, described(*kept.told[name]))
            for name in kept.rows.signals
        },
        MESSAGE: Array(names, kept.shape, str, chunks[:-1], attributes=described("", _MESSAGE)),
        TIME: coordinate(TIME, kept.times, "s", "time, of a point"),
    }


def _chunks(kept: Kept, design: Design, rows: int) -> tuple[int, ...]:
    """Say how series are cut: along the axis of regions in single rows, or in whole regions where all is kept."""
    chunks = [1] * len(design.axes)
    room = max(1, _LARGEST_CHUNK // (8 * kept.rows.count))
    first = design.across[0] if design.across else None
    for number, size in enumerate(kept.shape):
        if number == first:
            whole = rows if size == design.shape[number] else 1
            chunks[number] = whole if whole <= room else 1
        else:
            chunks[number] = min(size, room)
        room = max(1, room // chunks[number])
    return (*chunks, kept.rows.count)
