"""Read what a sweep has kept, by xarray, which is imported when it is needed."""

from __future__ import annotations

import warnings
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cosim.errors import InputError, require, suggestion
from cosim.files import why

SERIES = "series"
"""Group of a store, and attribute of it, where signals are kept over time."""
TIME = "time"


def open_sweep(path: str | Path) -> Any:
    """Open what a sweep has kept, while it goes on or when it is over.

    Parameters
    ----------
    path : str or Path
        The store.

    Returns
    -------
    xarray.Dataset
        A variable for each number that is kept, over what varies, with units; read when it is asked for. ``failed`` is
        1 where a point has failed, for the reason in ``message``, and NaN where it is not done. Attributes tell how the
        sweep was made: text, and JSON in ``record`` and ``versions``; in ``series``, which signals are kept over time,
        where there are such, for `open_series`.

    Raises
    ------
    InputError
        If there is none, or it cannot be read.
    """
    xarray = reader()
    if not (Path(path) / ".zattrs").is_file():
        raise InputError(f"{path}: there is no store of a sweep")
    try:
        with quiet():
            return xarray.open_zarr(Path(path), chunks=None, consolidated=True)
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} cannot be read: {why(error)}") from error


def open_series(path: str | Path, at: Mapping[str, Any] | None = None) -> Any:
    """Open the signals that a sweep has kept over time.

    Parameters
    ----------
    path : str or Path
        The store.
    at : mapping of str to value, optional
        A point: by dimension, the number to be near to, in SI units, or the very name of a component's FMU, or the
        number of a sample. What is not given stays a dimension.

    Returns
    -------
    xarray.Dataset
        A variable for each signal, over what varies, at the values that are kept, and over ``time``, in s: float64, as
        outputs were; NaN where there is none or none yet. Where a point has numbers and no series, ``message`` says
        why.

    Raises
    ------
    InputError
        If there is no such store or point, no signals were kept, or they cannot be read.
    """
    xarray = reader()
    if SERIES not in open_sweep(path).attrs:
        raise InputError(f"{path}: the sweep has kept nothing over time; expected one with --keep component.variable")
    try:
        with quiet():
            found = xarray.open_zarr(Path(path), group=SERIES, chunks=None, consolidated=True)
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} cannot be read: {why(error)}") from error
    for name, value in (at or {}).items():
        found = _at(found, name, value)
    return found


def _at(found: Any, name: str, value: Any) -> Any:
    """Return the series at the value of a dimension that is nearest, or is it."""
    over = [str(each) for each in found.dims if each != TIME]
    if name not in over:
        raise InputError(f"the series are not over '{name}'{suggestion(name, over)}")
    try:
        if name not in found.coords:
            return found.isel({name: value})
        near = {"method": "nearest"} if found[name].dtype.kind in "fiu" else {}
        return found.sel({name: value}, **near)
    except (KeyError, IndexError, TypeError, ValueError):
        raise InputError(f"the series have no {value!r} of {name}") from None


def reader() -> Any:
    """Return xarray, which takes a while to import, with what writes Zarr."""
    require("zarr", extra="stream", purpose="storing a sweep")
    return require("xarray", extra="stream", purpose="storing a sweep")


@contextmanager
def quiet() -> Generator[None]:
    """Let Zarr not warn of what is meant."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", category=FutureWarning)
        yield
