"""Time series in CSV files: a header, times in the first column, two rows at one time where something jumps.

This is what FMI-LS-REF, the Reference-FMUs and the FMI cross-check use.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from cosim.system.signals import FloatArray

from cosim.errors import InputError


_BOOLEANS = {"true": "1", "false": "0"}
SAME_TIME = 1e-9
"""Times nearer than this, relative to max(1, |t|), differ by rounding [s]."""


def same_time(one: float, other: float) -> bool:
    """Return whether two times [s] are the same but for rounding."""
    return abs(one - other) <= SAME_TIME * max(1.0, abs(one), abs(other))


@dataclass(frozen=True)
class Series:
    """Columns over times that do not fall.

    Attributes
    ----------
    path : Path
        The file, for messages.
    times : ndarray, shape (rows,)
        In s.
    texts : mapping of str to tuple of str
        The other columns as written.
    """

    path: Path
    times: FloatArray
    texts: Mapping[str, tuple[str, ...]]
    _numbers: dict[str, FloatArray] = field(default_factory=dict[str, FloatArray], init=False, repr=False)

    def column(self, name: str) -> FloatArray:
        """Return a column as numbers, true and false as 1 and 0; InputError if one is none."""
        if name in self._numbers:
            return self._numbers[name]
        try:
            numbers = np.array([float(_BOOLEANS.get(text.lower(), text)) for text in self.texts[name]])
        except ValueError as error:
            raise InputError(f"{self.path.name}, column {name}: {error}; expected numbers") from None
        return self._numbers.setdefault(name, numbers)

    @cached_property
    def jumps(self) -> tuple[float, ...]:
        """Times with two rows [s]."""
        doubled = self.times[1:][np.diff(self.times) == 0.0]
        return tuple(dict.fromkeys(doubled.tolist()))

    def after(self, time: float) -> tuple[int, int]:
        """Return the row that holds from a time on, and the next one; the same row twice at the end."""
        late = time + SAME_TIME * max(1.0, abs(time))
        row = max(int(np.searchsorted(self.times, late, side="right")) - 1, 0)
        return row, min(row + 1, len(self.times) - 1)

    def slope(self, name: str, time: float) -> float:
        """Return the slope of a column from a time on [1/s]."""
        row, following = self.after(time)
        span = self.times[following] - self.times[row]
        begins = time + SAME_TIME * max(1.0, abs(time)) >= self.times[row]
        values = self.column(name)
        return float((values[following] - values[row]) / span) if span > 0.0 and begins else 0.0

    def value(self, name: str, time: float, *, interpolate: bool) -> float:
        """Return a column's value from a time on: on the line between rows, or that of the row."""
        row, _ = self.after(time)
        value = float(self.column(name)[row])
        if not interpolate or time <= self.times[row]:
            return value
        return value + self.slope(name, time) * (time - float(self.times[row]))


def read_series(path: Path) -> Series:
    """Read a CSV file; InputError in one sentence if it is none, or its times fall."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = [row for row in csv.reader(file) if row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path.name} cannot be read: {error}") from None
    if len(rows) < 2:
        raise InputError(f"{path.name} has {max(len(rows) - 1, 0)} rows below its header; expected at least one")
    header = [name.strip().strip('"') for name in rows[0]]
    short = next((number for number, row in enumerate(rows, start=1) if len(row) != len(header)), None)
    if short is not None:
        raise InputError(f"{path.name}, line {short}: expected {len(header)} fields, as in the header")
    columns = [tuple(text.strip() for text in column) for column in zip(*rows[1:], strict=True)]
    try:
        times = np.array([float(text) for text in columns[0]])
    except ValueError as error:
        raise InputError(f"{path.name}: {error} in the first column; expected times") from None
    if not np.isfinite(times).all() or (np.diff(times) < 0.0).any():
        raise InputError(f"{path.name}: times in the first column are not finite, or fall")
    return Series(path, times, dict(zip(header[1:], columns[1:], strict=True)))
