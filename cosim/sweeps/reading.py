"""Read what a sweep has kept, by xarray, which is imported when it is needed."""

from __future__ import annotations

import warnings
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cosim.errors import InputError, require
from cosim.files import why


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
        sweep was made: text, and JSON in ``record`` and ``versions``.

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
