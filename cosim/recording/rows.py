"""Rows of a run by name: what a window of communication points recorded, as those who keep it take it.

All rows of a run in memory, as a `Result` has them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import RunError
from cosim.recording.result import Result
from cosim.system.signals import FloatArray


@dataclass(frozen=True)
class Column:
    """What one value of each row is.

    Attributes
    ----------
    name : str
        As ``component.variable``.
    unit : str
        Empty where there is none.
    dtype : dtype
        float64, int32 or bool.
    description : str
        For people; may be empty.
    """

    name: str
    unit: str
    dtype: np.dtype[Any]
    description: str = ""


@dataclass(frozen=True)
class Rows:
    """Successive rows; they are valid until the run goes on.

    Attributes
    ----------
    first : int
        Number of the first row within the run; the values after initialisation are row 0.
    times : ndarray, shape (rows,)
        Communication points, s.
    columns : mapping of str to ndarray, shape (rows,)
        By name of column.
    """

    first: int
    times: FloatArray
    columns: Mapping[str, NDArray[Any]]


class RowMemory:
    """Takes rows and keeps them.

    Parameters
    ----------
    columns : sequence of Column
        What they consist of.
    expected : int
        How many are expected; more than that are taken as well.

    Raises
    ------
    RunError
        If there is not enough memory for so many.
    """

    def __init__(self, columns: Sequence[Column], expected: int) -> None:
        self._columns = tuple(columns)
        try:
            self._times = np.empty(expected)
            self._values = {column.name: np.empty(expected, column.dtype) for column in columns}
        except (MemoryError, ValueError) as error:
            raise RunError(
                f"not enough memory to record {expected} communication points: {error}; a streamed run keeps few"
            ) from error
        self._filled = 0

    def take(self, rows: Rows) -> None:
        """Keep some more rows."""
        end = self._filled + rows.times.size
        if end > self._times.size:
            self._grow(max(end, 2 * self._times.size))
        self._times[self._filled : end] = rows.times
        for name, values in self._values.items():
            values[self._filled : end] = rows.columns[name]
        self._filled = end

    def result(self, record: Mapping[str, Any]) -> Result:
        """Return what has been taken, which can be read but not changed, with what is to be told of the run."""
        times = self._times[: self._filled]
        values = {name: column[: self._filled] for name, column in self._values.items()}
        for array in (times, *values.values()):
            array.flags.writeable = False
        units = {column.name: column.unit for column in self._columns}
        return Result(times, MappingProxyType(values), MappingProxyType(units), MappingProxyType(dict(record)))

    def _grow(self, rows: int) -> None:
        """Make room for more rows."""
        self._times = np.resize(self._times, rows)
        self._values = {name: np.resize(values, rows) for name, values in self._values.items()}
