"""Quantiles over time are those of the samples' own series, and are drawn."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zarr
from typer.testing import CliRunner

from cosim import InputError, open_series, quantile_bands, sweep
from cosim.cli.app import app
from tests.cosim.sweeps.measuring import Last

SAMPLES = {"plant.c_b": (0.01, 0.1), "plant.WOB": (5e4, 1.2e5)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a sweep with five samples at each of two speeds, and of one without samples."""
    path = tmp_path_factory.mktemp("bands")
    given: dict[str, Any] = {"measures": Last(), "workers": 1, "stop_time": 8.0, "keep": ["plant.bit_speed"]}
    grid = {"plant.Omega": [6.0, 12.0]}
    sweep("stick-slip", path / "maybe.zarr", grid=grid, samples=SAMPLES, count=5, seed=2, **given)
    sweep("stick-slip", path / "sure.zarr", grid=grid, **given)
    return path


def cosim(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, list(arguments))
    return result.exit_code, " ".join(result.output.split())


def test_quantiles_are_the_samples_in_their_order(folder: Path) -> None:
    series = open_series(folder / "maybe.zarr")["plant.bit_speed"]
    assert series.dims == ("plant.Omega", "sample", "time")
    found = quantile_bands(folder / "maybe.zarr", [1.0, 0.0, 0.25, 0.5, 0.625])
    assert found["plant.bit_speed"].dims == ("quantile", "plant.Omega", "time")
    assert found["plant.bit_speed"].attrs["units"] == "rad/s"
    assert (found["samples"].values == 5).all()
    for place in range(2):
        for row in range(0, 81, 7):
            ordered = sorted(float(series[place, sample, row]) for sample in range(5))
            told = [float(each) for each in found["plant.bit_speed"][:, place, row]]
            # of five, each is a quarter of the way on; 0.625 lies half way between the third and the fourth
            expected = [ordered[0], ordered[1], ordered[2], 0.5 * (ordered[2] + ordered[3]), ordered[4]]
            assert told == pytest.approx(expected, abs=1e-13)
    assert float(np.abs(found["plant.bit_speed"][0] - found["plant.bit_speed"][-1]).max()) > 1.0


def test_samples_that_are_not_done_are_none(folder: Path, tmp_path: Path) -> None:
    store = tmp_path / "s.zarr"
    shutil.copytree(folder / "maybe.zarr", store)
    kept: Any = zarr.open_array(store / "series" / "plant.bit_speed", mode="r+")
    kept[0, 1] = np.nan
    series = open_series(folder / "maybe.zarr", {"plant.Omega": 6.0})["plant.bit_speed"].values
    others = np.sort(series[[0, 2, 3, 4], 40]).tolist()
    found = quantile_bands(store, [0.0, 0.5, 1.0])
    told = found["plant.bit_speed"][:, 0, 40].values.tolist()
    assert told == pytest.approx([others[0], 0.5 * (others[1] + others[2]), others[3]], abs=1e-13)
    assert (found["samples"].values[0] == 4).all()
    assert (found["samples"].values[1] == 5).all()
    kept[0] = np.nan
    nothing = quantile_bands(store, at={"plant.Omega": 6.0})
    assert nothing["plant.Omega"].attrs["units"] == "rad/s"
    assert np.isnan(nothing["plant.bit_speed"].values).all()
    assert not nothing["samples"].values.any()


@pytest.mark.parametrize(
    ("name", "given", "sentence"),
    [
        ("sure", {}, "the sweep has no samples to take quantiles of; expected one with --sample or --uncertain"),
        ("maybe", {"quantiles": (5.0, 95.0)}, "the quantiles are 5, 95; expected some from 0 to 1"),
        ("maybe", {"quantiles": ()}, "the quantiles are none; expected some from 0 to 1"),
        ("maybe", {"at": {"sample": 1}}, "quantiles are over all samples; expected no number of one"),
    ],
)
def test_quantiles_that_there_are_not_are_refused(
    folder: Path, name: str, given: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(InputError) as refused:
        quantile_bands(folder / f"{name}.zarr", **given)
    assert str(refused.value).endswith(sentence)


def test_bands_and_points_are_drawn(folder: Path, tmp_path: Path) -> None:
    maybe, sure, figure = str(folder / "maybe.zarr"), str(folder / "sure.zarr"), tmp_path / "bands.svg"
    at = ["--at", "plant.Omega=110 rpm", "--output", str(figure)]
    assert cosim("plot", maybe, sure, *at, "--units", "metric", "--to", "5") == (0, f"wrote {figure}")
    drawn = figure.read_text(encoding="utf-8")
    for text in (
        "Bit speed [rpm]",
        "Drive speed: 114.59 rpm",
        "5 to 95 % of the samples",
        "25 to 75 % of the samples",
        "median",
    ):
        assert f"<!-- {text} -->" in drawn
    assert cosim("plot", maybe, *at, "--quantile", "10", "--quantile", "90", "--overlay")[0] == 0
    drawn = figure.read_text(encoding="utf-8")
    assert "<!-- 10 to 90 % of the samples -->" in drawn
    assert "median" not in drawn
    assert cosim("plot", maybe, "--at", "sample=3", *at)[0] == 0
    assert "of the samples" not in figure.read_text(encoding="utf-8")


def test_series_that_are_damaged_are_told(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(shutil.copytree(folder, tmp_path / "copied"))
    for file in Path().glob("*/series/plant.bit_speed/[0-9]*"):
        file.write_bytes(b"a chunk that is none")
    for name in ("maybe.zarr", "sure.zarr"):
        code, said = cosim("plot", name, "--at", "plant.Omega=6")
        assert code == 2
        assert said.startswith(f"error: {name} cannot be read: ")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["maybe.zarr"], "maybe.zarr is over plant.Omega; expected a point, as --at plant.Omega=VALUE"),
        (["maybe.zarr", "--at", "plant.Omga=1"], "the series are not over 'plant.Omga'; did you mean 'plant.Omega'?"),
        (
            ["maybe.zarr", "--at", "plant.Omega=6", "--at", "plant.Omega=1"],
            "--at plant.Omega=1: plant.Omega is given twice; expected each name once",
        ),
        (["maybe.zarr", "--at", "plant.Omega"], "--at plant.Omega: expected the form component.variable=value"),
        (
            ["sure.zarr", "--at", "plant.Omega=6", "--quantile", "5"],
            "sure.zarr has no samples to take quantiles of; expected a sweep with --sample or --uncertain",
        ),
        (
            ["sure.zarr", "--at", "plant.Omega=6", "--signal", "plant.bit_torque"],
            "'plant.bit_torque' was not kept over time; did you mean 'plant.bit_speed'?",
        ),
        (["sure.zarr", "elsewhere"], "elsewhere is no store of a sweep, as sure.zarr is; expected one kind of folders"),
        (["maybe.zarr", "--quantile", "150"], "--quantile 150: expected per cent, from 0 to 100"),
        (["sure.zarr", "--variant", "a"], "--variant is for runs; a sweep is of one variant"),
        (["elsewhere", "--at", "plant.Omega=6"], "--at and --quantile are for sweeps; expected stores of such"),
    ],
)
def test_what_cannot_be_drawn_is_a_sentence(
    folder: Path, arguments: list[str], sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    assert cosim("plot", *arguments) == (2, f"error: {sentence}")
