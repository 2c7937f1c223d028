"""Begin a group of a Zarr store, whose arrays `xarray` reads by their names and dimensions.

Zarr alone does it, which is imported sooner than `xarray` is: meanwhile workers wait. What a name may not have in a
store is percent-encoded there, and an attribute has the name itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import require
from cosim.run.zarr_layout import array_name

_DIMENSIONS = "_ARRAY_DIMENSIONS"
"""Attribute in which xarray looks for the dimensions (its documentation: Zarr encoding specification)."""
_COORDINATES = "coordinates"
"""Attribute that names coordinates beside those of the dimensions, separated by spaces (CF conventions, section 5)."""
_NAME = "variable"
"""Attribute that has the name of what is stored by another one."""


@dataclass(frozen=True)
class Array:
    """An array at the beginning.

    Attributes
    ----------
    dimensions : sequence of str
        Their names.
    shape : tuple of int
        Its size along each.
    dtype : type
        Of its values; str for texts of any length.
    chunks : tuple of int or None
        How it is cut; None: not at all.
    fill : number or None
        What stands where nothing is written; None of texts and of what is whole from the beginning.
    values : ndarray or None
        What is in it, if that is known.
    attributes : mapping of str to str
        Unit, description; empty ones are left out.
    """

    dimensions: Sequence[str]
    shape: tuple[int, ...]
    dtype: type
    chunks: tuple[int, ...] | None = None
    fill: float | None = None
    values: NDArray[Any] | None = None
    attributes: Mapping[str, str] = field(default_factory=dict[str, str])


def coordinate(dimension: str, values: Sequence[Any] | NDArray[Any], unit: str = "", text: str = "") -> Array:
    """Return the values along a dimension, of one type."""
    held = np.asarray(values)
    dtype = str if held.dtype.kind == "U" else held.dtype.type
    fill = np.nan if held.dtype.kind == "f" else None
    return Array([dimension], held.shape, dtype, None, fill, held, described(unit, text))


def described(unit: str, text: str) -> dict[str, str]:
    """Return unit and meaning as attributes."""
    return {"units": unit, "long_name": text}


def begin_group(path: Path, name: str, arrays: Mapping[str, Array], attributes: Mapping[str, Any] = {}) -> None:
    """Begin a group of a store, of which there is none yet, with arrays by name; ``""`` is the store itself."""
    zarr = require("zarr", extra="stream", purpose="storing a sweep")
    group = zarr.create_group(path, path=name, zarr_format=2, attributes=dict(attributes))
    coordinates = {key: array.dimensions[0] for key, array in arrays.items() if array.values is not None}
    for key, array in arrays.items():
        stored = stored_name(key)
        beside = "" if array.values is not None else _beside(array.dimensions, coordinates)
        own = {_NAME: key if stored != key else "", _COORDINATES: beside}
        told = {name: text for name, text in {**array.attributes, **own}.items() if text}
        made = group.create_array(
            stored,
            shape=array.shape,
            dtype=array.dtype,
            chunks=array.chunks or array.shape,
            fill_value=array.fill,
            attributes={**told, _DIMENSIONS: [stored_name(each) for each in array.dimensions]},
            config={"write_empty_chunks": False},
        )
        if array.values is not None:
            made[:] = array.values


def _beside(dimensions: Sequence[str], coordinates: Mapping[str, str]) -> str:
    """Name the coordinates that go along dimensions of other names, given what each coordinate goes along."""
    found = [name for name, along in coordinates.items() if along in dimensions and along != name]
    return " ".join(sorted(map(stored_name, found)))


def stored_name(name: str) -> str:
    """Return the name that a variable or dimension has in a store."""
    return array_name(name).replace(" ", "%20")


def named(dataset: Any) -> Any:
    """Return an `xarray.Dataset` as it was opened, with the names that its variables and dimensions have themselves."""
    names = {each: found.attrs.pop(_NAME) for each, found in dataset.variables.items() if _NAME in found.attrs}
    return dataset.rename(names)


def consolidate(path: Path) -> None:
    """Tell in one file what a store and groups of it hold."""
    require("zarr", extra="stream", purpose="storing a sweep").consolidate_metadata(path, zarr_format=2)
