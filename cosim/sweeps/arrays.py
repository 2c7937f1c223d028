"""Begin a group of a Zarr store, whose arrays `xarray` reads by their names and dimensions.

Zarr alone does it, which is imported sooner than `xarray` is: meanwhile workers wait.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import require

_DIMENSIONS = "_ARRAY_DIMENSIONS"
"""Attribute in which xarray looks for the dimensions (its documentation: Zarr encoding specification)."""
_COORDINATES = "coordinates"
"""Attribute that names coordinates beside those of the dimensions, without spaces (CF conventions 1.12, section 5)."""


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
    """Begin a group of a store, of which there is none yet; ``""`` is the store itself."""
    zarr = require("zarr", extra="stream", purpose="storing a sweep")
    group = zarr.create_group(path, path=name, zarr_format=2, attributes=dict(attributes))
    coordinates = {key: array.dimensions[0] for key, array in arrays.items() if array.values is not None}
    for key, array in arrays.items():
        beside = "" if array.values is not None else _beside(array.dimensions, coordinates)
        told = {name: text for name, text in {**array.attributes, _COORDINATES: beside}.items() if text}
        made = group.create_array(
            key,
            shape=array.shape,
            dtype=array.dtype,
            chunks=array.chunks or array.shape,
            fill_value=array.fill,
            attributes={**told, _DIMENSIONS: list(array.dimensions)},
            config={"write_empty_chunks": False},
        )
        if array.values is not None:
            made[:] = array.values


def _beside(dimensions: Sequence[str], coordinates: Mapping[str, str]) -> str:
    """Name the coordinates that go along dimensions of other names, given what each coordinate goes along."""
    found = [name for name, along in coordinates.items() if along in dimensions and along != name and " " not in name]
    return " ".join(sorted(found))


def consolidate(path: Path) -> None:
    """Tell in one file what a store and groups of it hold."""
    require("zarr", extra="stream", purpose="storing a sweep").consolidate_metadata(path, zarr_format=2)
