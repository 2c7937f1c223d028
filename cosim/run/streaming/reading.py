"""Streamed trajectories, read back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from cosim.errors import InputError
from cosim.optional import require
from cosim.run.streaming.stream import TRAJECTORY

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
            lengths.setdefault(_axis(array), set()).add(array.shape[0])
        if all(len(found) == 1 for found in lengths.values()):
            return reader.open_zarr(path, consolidated=False)
        names = list(group.array_keys())
        parts = [reader.open_zarr(path, consolidated=False, drop_variables=set(names) - {name}) for name in names]
        shortest = {axis: slice(0, min(found)) for axis, found in lengths.items()}
        return reader.merge([part.isel({axis: shortest[axis] for axis in part.dims}) for part in parts])
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} cannot be read: {error}") from error


def _axis(array: Any) -> str:
    """Return the name of an array's axis."""
    return str(array.attrs["_ARRAY_DIMENSIONS"][0])
