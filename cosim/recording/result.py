"""Keep trajectories: rows as a run gives them, the memory that keeps them, and the result that a run leaves."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from cosim.errors import RunError, UnknownNameError, suggestion
from cosim.recording import exchange
from cosim.system.signals import FloatArray

if TYPE_CHECKING:
    import pandas  # pyright: ignore[reportMissingTypeStubs]
    import xarray
    from matplotlib.figure import Figure

_TIMES = "time"


@dataclass(frozen=True, eq=False, repr=False)
class Result(Mapping[str, NDArray[Any]]):
    """Trajectories on the communication points; a mapping of names, first of them ``time``, to arrays.

    Two are equal if all names, units and values are, whatever their records tell.

    Row k is what holds at the end of the step that leads to ``time[k]``: outputs there, and inputs in force until then.
    Row 0 is the state after initialisation.

    Attributes
    ----------
    time : ndarray of float, shape (n,)
        Communication points, s.
    columns : mapping of str to ndarray, shape (n,)
        By ``component.variable``: float64, int32, bool, or object, which holds strings.
    units : mapping of str to str
        Unit of each column, empty where there is none.
    record : mapping
        How the run was made: scenario, packaging, algorithm, step size, files and their hashes, timings, remarks.
    """

    time: FloatArray
    columns: Mapping[str, NDArray[Any]]
    units: Mapping[str, str]
    record: Mapping[str, Any] = field(default_factory=dict[str, Any])

    @property
    def names(self) -> tuple[str, ...]:
        """Name the columns, component by component."""
        return tuple(self.columns)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return one trajectory, or ``time``, shape (n,).

        Raises
        ------
        UnknownNameError
            If nothing of that name was recorded.
        """
        if name == _TIMES:
            return self.time
        if not isinstance(cast(object, name), str):
            raise UnknownNameError(f"{name!r} is no name of what was recorded; expected one such as '{_TIMES}'")
        if name not in self.columns:
            raise UnknownNameError(f"'{name}' was not recorded{suggestion(name, self.columns)}")
        return self.columns[name]

    def __contains__(self, name: object) -> bool:
        return name == _TIMES or name in self.columns

    def __iter__(self) -> Iterator[str]:
        yield _TIMES
        yield from self.columns

    def __len__(self) -> int:
        return 1 + len(self.columns)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Result):
            return NotImplemented
        if self.names != other.names or dict(self.units) != dict(other.units):
            return False
        return all(
            self[name].dtype == other[name].dtype
            and np.array_equal(self[name], other[name], equal_nan=_has_nan(self[name]))
            for name in self
        )

    __hash__ = None  # pyright: ignore[reportAssignmentType]  # as of any mapping

    def __repr__(self) -> str:
        span = f", {self.time[0]:g} s to {self.time[-1]:g} s" if self.time.size else ""
        what = self.record.get("variant") or self.record.get("scenario")
        return f"<Result{f' of {what}' if what else ''}: {len(self.columns)} columns, {self.time.size} points{span}>"

    def __reduce__(self) -> tuple[object, ...]:
        """Return what a copy is made from."""
        return finished_result, (self.time, dict(self.columns), dict(self.units), dict(self.record))

    def _repr_html_(self) -> str:
        """Describe it in a notebook: columns with units, first and last values, least and greatest."""
        return exchange.to_html(self)

    def to_csv(
        self, path: str | Path, columns: Sequence[str] | None = None, *, decimate: int = 1, units: bool = False
    ) -> None:
        """Write trajectories: first column ``time``, then ``component.variable``.

        Numbers are written with as many digits as read back to the same bits, Booleans as 0 and 1, strings quoted where
        RFC 4180 asks for it.

        Parameters
        ----------
        path : str or Path
            The file.
        columns : sequence of str, optional
            Which, in this order; by default all.
        decimate : int
            Write only every so manyth row, the first among them.
        units : bool
            Write units into the header, as ``plant.bit_speed [rad/s]``.

        Raises
        ------
        InputError
            If a column was not recorded, or the file cannot be written.
        """
        exchange.write_csv(self, path, columns, decimate=decimate, units=units)

    def to_xarray(self) -> xarray.Dataset:
        """Return an `xarray.Dataset` over ``time`` [s], a variable for each column.

        Units are in ``attrs["units"]`` of each, the account of the run in the dataset's own, as JSON where it is not
        plain numbers or text.

        Raises
        ------
        MissingPackageError
            If xarray is not installed.
        """
        return exchange.to_dataset(self)

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a `pandas.DataFrame` with an index ``time`` [s], a column for each; units are in ``attrs["units"]``.

        Raises
        ------
        MissingPackageError
            If pandas is not installed.
        """
        return exchange.to_dataframe(self)

    def to_parquet(self, path: str | Path) -> None:
        """Write a Parquet file: ``time`` and the columns; units and the account of the run are in its metadata.

        Raises
        ------
        InputError
            If the file cannot be written; `MissingPackageError` if pyarrow is not installed.
        """
        exchange.write_parquet(self, path)

    def to_mat(self, path: str | Path) -> None:
        """Write a MATLAB file: ``time``, a struct for each component with a field for each variable, and ``units``.

        Characters that MATLAB's names cannot have become ``_``; the struct ``names`` has the names as they were, and
        ``record`` the account of the run as JSON.

        Raises
        ------
        InputError
            If the file cannot be written; `MissingPackageError` if SciPy is not installed.
        """
        exchange.write_mat(self, path)

    def plot(
        self, *signals: str, begin: float = -math.inf, end: float = math.inf, units: str = "si", title: str = ""
    ) -> Figure:
        """Draw trajectories over time; `cosim.plot` draws several results, beside or over each other.

        Parameters
        ----------
        *signals : str
            One panel each, as ``component.variable``; by default the first numbers recorded.
        begin, end : float
            The times between which they are shown [s].
        units : str
            ``"si"`` for kN and kN.m, or ``"field"`` for rpm, klbf and kft.lbf.
        title : str
            Above everything.

        Returns
        -------
        matplotlib.figure.Figure
            A notebook shows it; ``savefig`` writes it.

        Raises
        ------
        InputError
            If a signal was not recorded, or nothing lies between the times.
        """
        from cosim.recording.figure import View, plot

        return plot(self, View(signals, begin, end, units=units), title)


def _has_nan(values: NDArray[Any]) -> bool:
    """Tell whether values are of a type that has NaN."""
    return values.dtype.kind == "f"


def finished_result(
    times: FloatArray, columns: dict[str, NDArray[Any]], units: dict[str, str], record: Mapping[str, Any]
) -> Result:
    """Return a result of what is complete, which can be read but not changed."""
    for array in (times, *columns.values()):
        array.flags.writeable = False
    return Result(times, MappingProxyType(columns), MappingProxyType(units), MappingProxyType(dict(record)))


@dataclass(frozen=True)
class Column:
    """One value of each row: its name, unit and type.

    Attributes
    ----------
    name : str
        As ``component.variable``.
    unit : str
        Empty where there is none.
    dtype : dtype
        float64, int32, bool, or object for strings.
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

    def result(self, record: Mapping[str, Any], since: float = math.inf) -> Result:
        """Return what has been taken, which can be read but not changed, with what is to be told of the run.

        Parameters
        ----------
        record : mapping
            What is to be told.
        since : float
            Only from the last row on that is so much older than the last of all [s].
        """
        times = self._times[: self._filled]
        if times.size:
            older = int(np.searchsorted(times, float(times[-1]) - since, side="right"))
            times = times[max(0, older - 1) :]
        values = {name: column[self._filled - times.size : self._filled] for name, column in self._values.items()}
        return finished_result(times, values, {column.name: column.unit for column in self._columns}, record)

    def _grow(self, rows: int) -> None:
        """Make room for more rows."""
        self._times = np.resize(self._times, rows)
        self._values = {name: np.resize(values, rows) for name, values in self._values.items()}


SECONDS = 60.0
"""The time that is kept at least, s; measures look at the last 20 s, or at a period if that is longer."""


class Tail:
    """Takes rows, and forgets those that are older than a minute.

    Parameters
    ----------
    columns : sequence of Column
        What to keep of them.
    """

    def __init__(self, columns: Sequence[Column]) -> None:
        self._columns = tuple(columns)
        self._parts: deque[Rows] = deque()

    def take(self, rows: Rows) -> None:
        """Keep some more rows."""
        kept = {column.name: rows.columns[column.name].copy() for column in self._columns}
        self._parts.append(Rows(rows.first, rows.times.copy(), kept))
        oldest = rows.times[-1] - SECONDS
        while len(self._parts) > 1 and self._parts[1].times[0] <= oldest:
            self._parts.popleft()

    def result(self, record: Mapping[str, Any]) -> Result:
        """Return the last minute, with what is to be told of the run.

        Its first row is the last that is a minute old at least, whatever rows came together.
        """
        memory = RowMemory(self._columns, sum(part.times.size for part in self._parts))
        for part in self._parts:
            memory.take(part)
        return memory.result(record, since=SECONDS)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return what is kept by name, for a checkpoint."""
        whole = self.result({})
        return {_kept_name(_TIMES): whole.time, **{_kept_name(name): values for name, values in whole.columns.items()}}

    def restore(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Keep what another kept."""
        times = np.asarray(arrays[_kept_name(_TIMES)], dtype=np.float64)
        values = {column.name: arrays[_kept_name(column.name)] for column in self._columns}
        _refuse_unequal(times, values)
        for column in self._columns:
            if values[column.name].dtype.kind != ("U" if column.dtype == object else column.dtype.kind):
                raise ValueError(f"{column.name} is of type {values[column.name].dtype}; expected {column.dtype}")
        self._parts = deque([Rows(0, times, values)])


def kept_result(arrays: Mapping[str, NDArray[Any]], units: Mapping[str, str], record: Mapping[str, Any]) -> Result:
    """Return what `Tail.arrays` gave as a result again; KeyError or ValueError if it is not whole."""
    times = np.array(arrays[_kept_name(_TIMES)], dtype=np.float64)
    kept = {name: arrays[_kept_name(name)] for name in units}
    values = {name: column.astype(object) if column.dtype.kind == "U" else column for name, column in kept.items()}
    _refuse_unequal(times, values)
    return finished_result(times, values, dict(units), record)


def _refuse_unequal(times: FloatArray, columns: Mapping[str, NDArray[Any]]) -> None:
    """Refuse columns that are not as long as the times, which are some."""
    if times.ndim != 1 or not times.size or any(column.shape != times.shape for column in columns.values()):
        raise ValueError("the last minute is not whole")


def _kept_name(column: str) -> str:
    """Return the name of a column in a checkpoint."""
    return f"tail {column}"
