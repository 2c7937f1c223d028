"""Read what a sweep has kept, by xarray, which is imported when it is needed."""

from __future__ import annotations

import warnings
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from cosim.errors import InputError, require, suggestion
from cosim.files import why
from cosim.sweeps.arrays import named

MARK = ".zattrs"
"""The file that makes a folder a store."""
RECORD = "record"
"""Attribute of a store: all that decides the numbers, as JSON."""
SERIES = "series"
"""Group of a store, and attribute of it, where signals are kept over time."""
SAMPLING = "sampling"
"""Attribute of a store: how its samples were drawn."""
HELD = "held"
"""Attribute of a store: values of inputs that are the same at all points."""
TIME, SAMPLE = "time", "sample"
QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
"""What of samples is shown over time, where nothing else is said."""


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
    if not (Path(path) / MARK).is_file():
        raise InputError(f"{path}: there is no store of a sweep")
    try:
        with quiet():
            found = named(xarray.open_zarr(place_of(path), chunks=None, consolidated=True))
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} cannot be read: {why(error)}") from error
    if "failed" not in found or RECORD not in found.attrs:
        raise InputError(f"{path}: there is no store of a sweep, but another one of Zarr")
    return found


def load_sweep(path: str | Path) -> Any:
    """Read all that a sweep has kept but series; raises as `open_sweep` does, and where numbers cannot be read."""
    found = open_sweep(path)
    try:
        with quiet():
            return found.load()
    except (OSError, ValueError, RuntimeError) as error:  # the last of what unpacks numbers
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
            found = named(xarray.open_zarr(place_of(path), group=SERIES, chunks=None, consolidated=True))
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} cannot be read: {why(error)}") from error
    for name, value in (at or {}).items():
        found = _at(found, name, value)
    return found


def quantile_bands(
    path: str | Path, quantiles: Sequence[float] = QUANTILES, at: Mapping[str, Any] | None = None
) -> Any:
    """Return quantiles, over the samples of a sweep, of the signals that it has kept over time.

    Parameters
    ----------
    path : str or Path
        The store.
    quantiles : sequence of float
        The parts of the samples that lie below, from 0 to 1.
    at : mapping of str to value, optional
        A point of the grid, as of `open_series`.

    Returns
    -------
    xarray.Dataset
        A variable for each signal, over ``quantile``, what varies on a grid, and ``time``; between two samples they are
        on a straight line. ``samples`` is how many there are at each time: none of those that failed or are not done.

    Raises
    ------
    InputError
        As of `open_series`; or if the sweep has no samples, or something is no quantile.
    """
    wanted = sorted(set(quantiles))
    if not wanted or not all(0.0 <= each <= 1.0 for each in wanted):
        said = ", ".join(f"{each:g}" for each in quantiles) or "none"
        raise InputError(f"the quantiles are {said}; expected some from 0 to 1")
    if SAMPLE in (at or {}):
        raise InputError("quantiles are over all samples; expected no number of one")
    found = open_series(path, at)
    if SAMPLE not in found.dims:
        raise InputError(
            f"{path}: the sweep has no samples to take quantiles of; expected one with --sample or --uncertain"
        )
    signals = found.drop_vars(["message"])
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="All-NaN slice encountered")  # where nothing is done yet
        bands = signals.quantile(wanted, dim=SAMPLE, skipna=True, keep_attrs=True)
    first = next(iter(signals.data_vars.values()))
    bands = bands.assign(samples=first.notnull().sum(dim=SAMPLE).drop_attrs())
    kept = {name: held for name, held in signals.coords.items() if SAMPLE not in held.dims}
    bands = bands.assign_coords(kept)  # of which xarray drops single values, and their units
    return bands.transpose("quantile", *(each for each in bands.dims if each not in ("quantile", TIME)), TIME)


def _at(found: Any, name: str, value: Any) -> Any:
    """Return the series at the value of a dimension that is nearest, or is it."""
    over = [str(each) for each in found.dims if each != TIME]
    if name not in over:
        raise InputError(f"the series are not over '{name}'{suggestion(name, over)}")
    try:
        if name not in found.coords:
            return found.isel({name: range(found.sizes[name])[value]})
        if found[name].dtype.kind not in "fiu":
            return found.sel({name: value})
        away = np.abs(found[name].values - float(value))  # they may come in any order
        return found.isel({name: int(np.nanargmin(away))})
    except (KeyError, IndexError, TypeError, ValueError):
        raise InputError(f"the series have no {value!r} of {name}") from None


def place_of(path: str | Path) -> Path:
    """Return a path that xarray takes as it is: in one that begins with ``~`` it expands that, as nothing else does."""
    return Path(path).absolute()


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
