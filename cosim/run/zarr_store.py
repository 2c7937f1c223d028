"""Stream trajectories to Zarr (version 2), laid out as xarray reads them, and read them back.

Each column is an array over a time axis, ``time`` where every row is stored, ``time_10`` where every tenth is. Zarr
replaces files whole, so that a store is never left with half of one. Columns may differ in length if the program ends
while it writes; `cosim.open_trajectory` cuts them to the shortest.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError, OutputError, require
from cosim.recording.record import TEXT
from cosim.recording.result import Column, Rows
from cosim.run.store import Position, axis

if TYPE_CHECKING:
    import xarray

TRAJECTORY = "trajectory.zarr"
CHUNK = 65536
"""Rows in a file."""
_FORMAT = 2
_ENCODED = '%/\\:*?"<>|'
_LONGEST = 200
_GATHERED = ".zmetadata"


@dataclass
class _Axis:
    """Columns of one stride, and the rows that no full file holds yet.

    Attributes
    ----------
    stride : int
        In rows.
    arrays : dict of str to zarr.Array
        By name of column, and the axis itself.
    pending : dict of str to ndarray, shape (CHUNK,)
        The rows from `base` on.
    base, filled : int
        Rows in full files, and after them.
    """

    stride: int
    arrays: dict[str, Any]
    pending: dict[str, NDArray[Any]]
    base: int
    filled: int

    def take(self, rows: Rows) -> None:
        """Take what is to be stored."""
        chosen = slice(-rows.first % self.stride, None, self.stride)
        values = {name: rows.columns[name][chosen] for name in self.arrays if name != axis(self.stride)}
        values[axis(self.stride)] = rows.times[chosen]
        count, taken = values[axis(self.stride)].size, 0
        while taken < count:
            part = min(count - taken, CHUNK - self.filled)
            for name, pending in self.pending.items():
                pending[self.filled : self.filled + part] = values[name][taken : taken + part]
            taken += part
            self.filled += part
            if self.filled == CHUNK:
                self.write()
                self.base, self.filled = self.base + CHUNK, 0

    def write(self) -> None:
        """Write the pending rows."""
        for name, array in self.arrays.items():
            array.resize((self.base + self.filled,))
            array[self.base :] = self.pending[name][: self.filled]


class ZarrStore:
    """An open store; made by `create_zarr` or `reopen_zarr`."""

    def __init__(self, path: Path, group: Any, axes: Sequence[_Axis]) -> None:
        self._path = path
        self._group = group
        self._axes = tuple(axes)

    def take(self, rows: Rows) -> None:
        """Take the rows that follow those taken before."""
        with _writing(self._path):
            for each in self._axes:
                each.take(rows)

    def commit(self) -> Position:
        """Write everything taken so far; return the number of rows on each axis."""
        with _writing(self._path):
            for each in self._axes:
                each.write()
        return {axis(each.stride): each.base + each.filled for each in self._axes}

    def close(self, attributes: Mapping[str, Any]) -> None:
        """Write everything, with attributes of the whole, and gather what describes the columns in one place."""
        self.commit()
        with _writing(self._path):
            self._group.update_attributes(_simple(attributes))
            _zarr().consolidate_metadata(self._group.store, zarr_format=_FORMAT)


def create_zarr(path: Path, columns: Mapping[int, Sequence[Column]], attributes: Mapping[str, Any]) -> ZarrStore:
    """Begin a store.

    Parameters
    ----------
    path : Path
        A folder that does not exist.
    columns : mapping of int to sequence of Column
        What to store, by stride.
    attributes : mapping
        Of the whole; anything that JSON knows.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    with _writing(path):
        group: Any = _zarr().open_group(path, mode="w-", zarr_format=_FORMAT, attributes=_simple(attributes))
        for stride, chosen in columns.items():
            time = Column(axis(stride), "s", np.dtype(np.float64), "communication points")
            for column in (*chosen, time):
                _create(group, column, axis(stride))
    return reopen_zarr(path, columns, {axis(stride): 0 for stride in columns})


def reopen_zarr(path: Path, columns: Mapping[int, Sequence[Column]], position: Position) -> ZarrStore:
    """Go on with a store from where `ZarrStore.commit` had brought it; what was stored after that is dropped.

    Raises
    ------
    OutputError
        If the store is not there any more, lacks rows, or cannot be written.
    """
    with _writing(path):
        (path / _GATHERED).unlink(missing_ok=True)  # it tells the lengths of before
        group: Any = _zarr().open_group(path, mode="r+", zarr_format=_FORMAT, use_consolidated=False)
        axes = [_reopen(path, group, stride, chosen, position) for stride, chosen in columns.items()]
    return ZarrStore(path, group, axes)


def require_zarr() -> None:
    """Raise MissingPackageError unless all packages are there that a store needs."""
    _zarr()
    _numcodecs()


def array_name(column: str) -> str:
    """Return the name of a column's array, which is that of a folder.

    It is the column's name, in which what leads into groups or is no part of a file's name is percent-encoded, and the
    percent sign itself. One that no file system takes is cut, and told apart by a digest. The array's attribute
    ``variable`` has the column's own name.
    """
    name = "".join(f"%{ord(each):02X}" if each in _ENCODED or ord(each) < 32 else each for each in column)
    name = name.replace(".", "%2E", 1) if name.startswith(".") else name
    if len(name.encode()) <= _LONGEST:
        return name
    kept = name.encode()[: _LONGEST - 17].decode("utf-8", "ignore")
    return f"{kept}~{hashlib.sha256(column.encode()).hexdigest()[:16]}"


def _zarr() -> Any:
    """Return the library, which takes a while to import, and whose types checkers do not all know."""
    return require("zarr", extra="stream", purpose="writing Zarr")


def _numcodecs() -> Any:
    """Return the library of codecs."""
    return require("numcodecs", extra="stream", purpose="writing Zarr")


def _codec() -> Any:
    """Return how numbers are compressed: fast, and well where they change little from row to row."""
    numcodecs = _numcodecs()
    return numcodecs.Blosc("lz4", shuffle=numcodecs.Blosc.SHUFFLE)


def _create(group: Any, column: Column, along: str) -> None:
    """Make an empty array for a column along an axis."""
    described = {"long_name": column.description} if column.description else {}
    attributes: dict[str, Any] = {
        "_ARRAY_DIMENSIONS": [along],
        "units": column.unit or "1",
        "variable": column.name,
        **described,
    }
    is_text = column.dtype == TEXT
    group.create_array(
        array_name(column.name),
        shape=(0,),
        chunks=(CHUNK,),
        dtype=str if is_text else column.dtype,
        compressors=_codec(),
        fill_value=None,  # xarray would take another one for missing values
        attributes=attributes,
    )


def _reopen(path: Path, group: Any, stride: int, columns: Sequence[Column], position: Position) -> _Axis:
    """Cut the columns of an axis to its rows, and read back those that fill no file."""
    along = axis(stride)
    rows = position[along]
    base = rows - rows % CHUNK
    arrays: dict[str, Any] = {}
    pending: dict[str, NDArray[Any]] = {}
    for name in (*(column.name for column in columns), along):
        array: Any = group.get(array_name(name))
        if array is None or array.shape[0] < rows:
            raise OutputError(f"{path}: {name} has been stored for less than {rows} rows; expected what was written")
        array.resize((rows,))
        arrays[name] = array
        pending[name] = np.zeros(CHUNK, dtype=array.dtype if array.dtype.kind in "fib" else TEXT)
        pending[name][: rows - base] = array[base:]
    return _Axis(stride, arrays, pending, base, rows - base)


def _simple(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return attributes as netCDF knows them too: text and numbers; anything else as JSON."""
    simple = (str, int, float)
    return {
        key: value if isinstance(value, simple) and not isinstance(value, bool) else json.dumps(value)
        for key, value in attributes.items()
    }


@contextmanager
def _writing(path: Path) -> Generator[None]:
    """Say what could not be written."""
    try:
        yield
    except (OSError, _zarr().errors.BaseZarrError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise OutputError(f"{path} cannot be written: {reason or error}") from error


def open_trajectory(folder: str | Path) -> xarray.Dataset:
    """Open what a streamed run has written, while it goes on, or when it is over.

    Parameters
    ----------
    folder : str or Path
        Of the run, or of one of its variants.

    Returns
    -------
    xarray.Dataset
        A variable for each column, by ``component.variable``, with its unit, over ``time``, or ``time_10`` where every
        tenth row is stored [s]. Values are read when they are asked for. Attributes tell how the run was made, JSON
        where they are not plain numbers or text.

    Raises
    ------
    InputError
        If there is no such trajectory, it cannot be read, or a package is missing that reads it.
    """
    path = Path(folder)
    path = path if path.suffix == ".zarr" else path / TRAJECTORY
    if not path.is_dir():
        raise InputError(f"{path}: there is no such trajectory")
    # Both take a while to import.
    reader, zarr = (require(name, extra="stream", purpose="reading Zarr") for name in ("xarray", "zarr"))
    try:
        group = zarr.open_group(path, mode="r", use_consolidated=False)
        lengths: dict[str, set[int]] = {}
        for array in group.array_values():
            lengths.setdefault(_axis_of(array), set()).add(array.shape[0])
        if all(len(found) == 1 for found in lengths.values()):
            return _by_column(reader.open_zarr(path, consolidated=False))
        names = list(group.array_keys())
        parts = [reader.open_zarr(path, consolidated=False, drop_variables=set(names) - {name}) for name in names]
        shortest = {axis: slice(0, min(found)) for axis, found in lengths.items()}
        return _by_column(reader.merge([part.isel({axis: shortest[axis] for axis in part.dims}) for part in parts]))
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} cannot be read: {error}") from error


def _by_column(dataset: Any) -> Any:
    """Give variables the names of their columns, where folders could not have them."""
    names = {name: dataset[name].attrs.get("variable", name) for name in dataset.data_vars}
    return dataset.rename({name: column for name, column in names.items() if name != column})


def _axis_of(array: Any) -> str:
    """Return the name of an array's axis."""
    return str(array.attrs["_ARRAY_DIMENSIONS"][0])
