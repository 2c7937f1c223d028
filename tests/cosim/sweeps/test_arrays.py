"""A store is begun with the bytes that xarray itself would begin it with."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray

from cosim.sweeps.arrays import Array, begin_group, consolidate, coordinate, described
from cosim.sweeps.reading import quiet


def files(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_store_is_begun_as_xarray_does_it(tmp_path: Path) -> None:
    drawn, speeds, names = np.array([0.25, 0.75, 0.5]), np.array([2, 4], dtype=np.int64), ["one", "another"]
    over, shape, chunks = ("plant", "plant.Omega", "sample"), (2, 2, 3), (2, 1, 3)
    unit = {"units": "N", "long_name": "weight"}
    begun = {
        "number": Array(over, shape, np.float64, chunks, np.nan, None, described("N", "weight")),
        "failed": Array(over, shape, np.int8, chunks, -1),
        "message": Array(over, shape, str, chunks),
        "plant": coordinate("plant", names),
        "plant.Omega": coordinate("plant.Omega", speeds, "", "speed"),
        "plant.b": coordinate("sample", drawn, "N", "weight"),
        "plant.a": coordinate("sample", [True, False, True]),
    }
    begin_group(tmp_path / "begun", "", begun, {"title": "a title"})
    begin_group(tmp_path / "begun", "part", {"time": coordinate("time", drawn, "s")})
    consolidate(tmp_path / "begun")

    texts = np.full(shape, "", dtype=object)
    variables = {
        "number": (over, np.full(shape, np.nan), unit),
        "failed": (over, np.full(shape, -1, dtype=np.int8)),
        "message": (over, texts),
    }
    coordinates = {
        "plant": ("plant", np.array(names, dtype=object)),
        "plant.Omega": ("plant.Omega", speeds, {"long_name": "speed"}),
        "plant.b": ("sample", drawn, unit),
        "plant.a": ("sample", np.array([True, False, True])),
    }
    usual = {"chunks": chunks, "write_empty_chunks": False}
    encoding = {
        "number": {**usual, "_FillValue": np.nan},
        "failed": {**usual, "_FillValue": np.int8(-1)},
        "message": usual,
    }
    with quiet():
        whole = xarray.Dataset(variables, coordinates, {"title": "a title"})
        whole.to_zarr(tmp_path / "whole", mode="w", zarr_format=2, consolidated=False, encoding=encoding)
        part = xarray.Dataset(coords={"time": ("time", drawn, {"units": "s"})})
        part.to_zarr(tmp_path / "whole", group="part", mode="w", zarr_format=2, consolidated=False)

    made, expected = files(tmp_path / "begun"), files(tmp_path / "whole")
    assert {
        name: content for name, content in made.items() if "a name" not in name and name != ".zmetadata"
    } == expected
    opened = xarray.open_zarr(tmp_path / "begun", chunks=None, consolidated=True)
    assert set(opened.coords) == {"plant", "plant.Omega", "plant.a", "plant.b"}
    assert opened["plant.a"].values.tolist() == [True, False, True]
    assert set(xarray.open_zarr(tmp_path / "begun", group="part", chunks=None, consolidated=True).coords) == {"time"}
