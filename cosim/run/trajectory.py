"""Read streamed trajectories as an `xarray.Dataset`, each chunk held against its digest when it is asked for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError, require
from cosim.files import why
from cosim.run import zarr_layout as layout
from cosim.run.store import axis
from cosim.run.zarr_layout import ColumnIndex, DamagedStoreError, Index

if TYPE_CHECKING:
    import xarray


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
        tenth row is stored [s]. Values are read when they are asked for, and held against the digests they were written
        with; what is not as it was written raises `InputError`. Attributes tell how the run was made, JSON where they
        are not plain numbers or text.

    Raises
    ------
    InputError
        If there is no such trajectory, it cannot be read, is damaged, or a package is missing that reads it.
    """
    path = Path(folder)
    path = path if path.suffix == ".zarr" else path / layout.TRAJECTORY
    if not path.is_dir():
        raise InputError(f"{path}: there is no such trajectory")
    reader = require("xarray", extra="stream", purpose="reading Zarr")  # which takes a while to import
    layout.require_codecs("reading Zarr")
    try:
        index = Index.read(path)
        attributes = layout.check_descriptions(path, index)
        variables: dict[str, Any] = {}
        for each in index.axes:
            rows = min(len(column.full) * layout.CHUNK + layout.find_last(path, column)[0] for column in each.columns)
            for column in each.columns:
                lazy = reader.core.indexing.LazilyIndexedArray(_lazy(path, column, rows))
                variables[column.name] = reader.Variable((axis(each.stride),), lazy, layout.column_attributes(column))
    except DamagedStoreError as error:
        raise InputError(f"{path}: {error}") from error
    except OSError as error:
        raise InputError(f"{path} cannot be read: {why(error)}") from error
    axes = [axis(each.stride) for each in index.axes]
    coordinates = {name: variables.pop(name) for name in axes}
    return reader.Dataset(variables, coordinates, attributes)


def _lazy(path: Path, column: ColumnIndex, rows: int) -> Any:
    """Return the rows of a column as xarray takes what is read when it is asked for."""
    from xarray.backends import BackendArray
    from xarray.core import indexing

    class Lazy(BackendArray):
        """A column on disk."""

        def __init__(self) -> None:
            self.shape, self.dtype = (rows,), column.type

        def __getitem__(self, key: Any) -> Any:
            return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.BASIC, self._read)

        def _read(self, key: tuple[int | slice]) -> Any:
            try:
                return _rows(path, column, rows, key[0])
            except DamagedStoreError as error:
                raise InputError(f"{path}: {error}") from error

    return Lazy()


def _rows(path: Path, column: ColumnIndex, rows: int, which: int | slice) -> Any:
    """Read some rows of a column."""
    chosen = range(rows)[which]
    if isinstance(chosen, int):
        return layout.read_chunk(path, column, chosen // layout.CHUNK)[chosen % layout.CHUNK]
    if not chosen:
        return np.empty(0, column.type)
    first, last = min(chosen[0], chosen[-1]) // layout.CHUNK, max(chosen[0], chosen[-1]) // layout.CHUNK
    whole: NDArray[Any] = np.concatenate(
        [layout.read_chunk(path, column, number) for number in range(first, last + 1)]
    )[: rows - first * layout.CHUNK]
    begin = first * layout.CHUNK
    return whole[np.arange(chosen.start - begin, chosen.stop - begin, chosen.step)]
