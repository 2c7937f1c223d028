"""Sobol indices of sweeps against closed forms and quadrature, which know nothing of how they are estimated."""

from __future__ import annotations

import csv
import io
import json
import math
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from rich.console import Console
from scipy.integrate import quad
from typer.testing import CliRunner

from cosim import InputError, open_sweep, sobol_indices, sweep
from cosim.cli.app import app
from cosim.cli.sweeping import print_indices
from cosim.drilling.mathematics import DrillstringParameters
from cosim.drilling.sensitivity import estimate
from cosim.drilling.severity import SWING
from cosim.drilling.uncertainty import draw_indices
from cosim.errors import MissingPackageError
from cosim.sweeps.design import sampled
from cosim.sweeps.distributions import Distribution
from models.theory import critical_omega
from tests.cosim.sweeps.measuring import Last

COUNT = 1024
"""Of samples; errors of indices are of the order of 1 / sqrt(COUNT) = 0.03 at most."""
OMEGA, C_A, MU, C_B = (8.0, 14.0), (1000.0, 3000.0), (0.7, 0.9), (1.0, 60.0)
NAMES = ["plant.Omega", "plant.c_a", "plant.mu_sb", "plant.c_b"]
WEIGHTS = [6e4, 97347.0]


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a sweep over four samples and two weights, of 0.4 s each."""
    path = tmp_path_factory.mktemp("sensitivity") / "s.zarr"
    samples = {"plant.Omega": OMEGA, "plant.c_a": C_A, "plant.mu_sb": MU, "plant.c_b": C_B}
    sweep(
        "stick-slip", path, grid={"plant.WOB": WEIGHTS}, samples=samples, count=256, sampling="saltelli", seed=5,
        workers=1, stop_time=0.4, measures=Last(window=0.2, sampling=0.2),
    )  # fmt: skip
    return path


def cosim(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, list(arguments))
    return result.exit_code, " ".join(result.output.split())


def test_a_sum_has_the_indices_of_the_variances_of_its_parts() -> None:
    spreads = {
        "a": Distribution("normal", {"mean": 5.0, "deviation": 2.0}),
        "b": (-3.0, 3.0),
        "c": Distribution("triangular", {"low": 0.0, "mode": 1.0, "high": 5.0}),
        "d": Distribution("lognormal", {"median": 1.0, "factor": 1.5}),
    }
    drawn = sampled(spreads, COUNT, "saltelli", seed=1)
    a, b, c, d = (np.array(values) for values in drawn.values.values())
    spread = math.log(1.5) ** 2
    variances = np.array([
        4.0,
        9.0 * 6.0**2 / 12.0,
        (0.0 + 1.0 + 25.0 - 0.0 - 0.0 - 5.0) / 18.0,
        16.0 * (math.exp(spread) - 1.0) * math.exp(spread),
    ])  # fmt: skip
    found = estimate(a + 3.0 * b - c + 4.0 * d, 4, 0.95, 100, 0)
    exact = variances / variances.sum()
    assert found.first == pytest.approx(exact, abs=0.03)
    assert found.total == pytest.approx(exact, abs=0.03)
    assert (np.abs(found.total - exact) <= found.total_confidence).all()
    assert found.left_out == 0


def test_ishigami_has_its_known_indices() -> None:
    # T. Ishigami, T. Homma (1990), with a = 7, b = 0.1: closed forms, as of Sobol and Levitan (1999)
    drawn = sampled(dict.fromkeys("xyz", (-math.pi, math.pi)), COUNT, "saltelli", seed=2)
    x, y, z = (np.array(values) for values in drawn.values.values())
    found = estimate(np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x), 3, 0.95, 100, 0)
    first = 0.5 * (1.0 + 0.1 * math.pi**4 / 5.0) ** 2
    second, both = 49.0 / 8.0, 0.01 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    whole = first + second + both
    assert found.first == pytest.approx(np.array([first, second, 0.0]) / whole, abs=0.03)
    assert found.total == pytest.approx(np.array([first + both, second, both]) / whole, abs=0.03)


def test_the_work_of_the_drive_before_the_first_echo_has_the_indices_of_a_product(store: Path) -> None:
    # until the echo comes back the top turns at c_a Omega / (c_a + Z), against the impedance Z: a product of
    # functions of c_a and of Omega, which are independent
    impedance = DrillstringParameters().impedance
    f, g = (lambda c: (c / (c + impedance)) ** 2), (lambda omega: omega**2)
    (f_mean, f_square), (g_mean, g_square) = moments(f, C_A), moments(g, OMEGA)
    whole = f_square * g_square - (f_mean * g_mean) ** 2
    f_part, g_part = f_square - f_mean**2, g_square - g_mean**2
    found = sobol_indices(open_sweep(store), "work_in")
    assert found["total"].dims == ("plant.WOB", "variable")
    assert found["variable"].values.tolist() == NAMES
    for weight in WEIGHTS:  # on which it does not depend
        point = found.sel({"plant.WOB": weight})
        first = [f_mean**2 * g_part / whole, g_mean**2 * f_part / whole, 0.0, 0.0]
        total = [f_square * g_part / whole, g_square * f_part / whole, 0.0, 0.0]
        assert point["first"].values == pytest.approx(first, abs=1.0 / math.sqrt(256))
        assert point["total"].values == pytest.approx(total, abs=1.0 / math.sqrt(256))
        # what has nothing to do with it changes no bit of it
        assert point["total"].values[2:].tolist() == [0.0, 0.0]


def moments(of: Callable[[float], float], ends: tuple[float, float]) -> tuple[float, float]:
    """Return the means of a function of what is uniform, and of its square."""
    width = ends[1] - ends[0]
    return quad(of, *ends)[0] / width, quad(lambda value: of(value) ** 2, *ends)[0] / width


def test_the_linear_threshold_has_the_indices_that_quadrature_finds(store: Path) -> None:
    count = 8  # Gauss points of each, of a smooth function: 12 change no digit that is compared
    nodes, weights = np.polynomial.legendre.leggauss(count)
    sides = [low + 0.5 * (high - low) * (nodes + 1.0) for low, high in (C_A, MU, C_B)]
    values = np.array([
        [[critical_omega(DrillstringParameters(c_a=c_a, mu_sb=mu, c_b=c_b), WEIGHTS[1]) for c_b in sides[2]]
         for mu in sides[1]] for c_a in sides[0]
    ])  # fmt: skip
    half = 0.5 * weights
    cube = half[:, None, None] * half[None, :, None] * half[None, None, :]
    mean = float((cube * values).sum())
    whole = float((cube * (values - mean) ** 2).sum())
    found = sobol_indices(open_sweep(store), "threshold").sel({"plant.WOB": WEIGHTS[1]})
    assert found.attrs["long_name"] == "drive speed at which steady rotation loses its stability"
    for number, name in enumerate(NAMES[1:]):
        others = tuple(axis for axis in range(3) if axis != number)
        alone = np.moveaxis(values, number, 0).reshape(count, -1) @ np.outer(half, half).ravel()
        first = float((half * (alone - mean) ** 2).sum()) / whole
        rest = np.tensordot(half, values, ([0], [number]))
        total = 1.0 - float((np.outer(half, half) * (rest - mean) ** 2).sum()) / whole
        assert len(others) == 2
        assert float(found["first"].sel(variable=name)) == pytest.approx(first, abs=1.0 / math.sqrt(256))
        assert float(found["total"].sel(variable=name)) == pytest.approx(total, abs=1.0 / math.sqrt(256))
    assert float(found["total"].sel(variable="plant.Omega")) == 0.0


@pytest.mark.slow
def test_the_probability_of_stick_slip_has_the_indices_of_a_double_loop(tmp_path: Path) -> None:
    spreads = {"plant.mu_sb": (0.65, 0.95), "plant.c_b": (1.0, 120.0)}
    given: dict[str, Any] = {"stop_time": 30.0, "workers": 1, "overrides": {"plant.Omega": 10.0}}
    count = 20
    middles = (np.arange(count) + 0.5) / count
    grid = {name: (low + middles * (high - low)).tolist() for name, (low, high) in spreads.items()}
    whole = sweep("stick-slip", tmp_path / "grid.zarr", grid=grid, **given)
    unstable = (whole["bit_speed_max"] - whole["bit_speed_min"] > SWING).values.astype(float)
    variance = unstable.var()
    assert variance > 0.1
    sweep("stick-slip", tmp_path / "s.zarr", samples=spreads, count=256, sampling="saltelli", **given)
    found = sobol_indices(open_sweep(tmp_path / "s.zarr"))
    # a sample is as good as 1 / sqrt(256), and so are the edges of a grid of 20
    assert found["first"].values == pytest.approx(
        [unstable.mean(axis=1).var() / variance, unstable.mean(axis=0).var() / variance], abs=0.12
    )
    assert found["total"].values == pytest.approx(
        [1.0 - unstable.mean(axis=0).var() / variance, 1.0 - unstable.mean(axis=1).var() / variance], abs=0.12
    )


def test_samples_without_an_output_are_left_out_with_those_that_differ_from_them() -> None:
    drawn = sampled({"a": (0.0, 1.0), "b": (0.0, 1.0)}, 64, "saltelli", seed=4)
    a, b = (np.array(values) for values in drawn.values.values())
    values = a + b**2
    gapped = values.copy()
    gapped[[9, 130]] = math.nan, math.inf
    found = estimate(gapped, 2, 0.95, 100, 0)
    others = np.delete(values.reshape(64, 4), [9 // 4, 130 // 4], axis=0).ravel()
    assert found.left_out == 2
    assert found.total.tolist() == estimate(others, 2, 0.95, 100, 0).total.tolist()


def test_what_does_not_vary_has_no_indices() -> None:
    for values in (np.full(64, 3.0), np.full(64, math.nan), np.zeros(64)):
        assert np.isnan(estimate(values, 2, 0.95, 100, 0).total).all()


def test_the_same_seed_finds_the_same_indices(store: Path) -> None:
    first, again, other = (sobol_indices(open_sweep(store), "energy", seed=seed) for seed in (0, 0, 1))
    assert first["total_confidence"].values.tolist() == again["total_confidence"].values.tolist()
    assert first["total_confidence"].values.tolist() != other["total_confidence"].values.tolist()
    assert first["total"].values.tolist() == other["total"].values.tolist()


def test_a_bar_of_estimating_is_shown_where_it_is_asked_for(store: Path, capfd: pytest.CaptureFixture[str]) -> None:
    sobol_indices(open_sweep(store), "work_in", progress=True)
    assert "estimating indices: done after" in capfd.readouterr().err


def test_a_store_tells_how_its_samples_were_drawn(store: Path) -> None:
    drawn = json.loads(open_sweep(store).attrs["sampling"])
    assert drawn == {
        "method": "saltelli", "count": 256, "seed": 5,
        "from": dict(zip(NAMES, map(list, (OMEGA, C_A, MU, C_B)), strict=True)),
    }  # fmt: skip


@pytest.mark.slow
def test_indices_are_shown_drawn_and_written(tmp_path: Path) -> None:
    path, figure = tmp_path / "s.zarr", tmp_path / "s-indices.png"
    drawn = ["--sample", "plant.mu_sb=0.6:1", "--sample", "plant.c_b=1:120", "--sampling", "saltelli", "--count", "4"]
    usual = ["sweep", "stick-slip", *drawn, "--stop-time", "20", "--workers", "1", "--output", str(path)]
    assert cosim(*usual, "--grid", "plant.Omega=6,10", "--grid", "plant.WOB=6e4,97347")[0] == 0
    code, said = cosim("sensitivity", str(path))
    assert code == 0
    assert said.startswith("part of the points of the grid that are unstable variable first order total plant.mu_sb ")
    assert "loses its stability, at plant.WOB = 97.347 kN variable first order total plant.mu_sb " in said
    assert said.endswith(f"wrote {figure} and s-indices.csv")
    assert figure.read_bytes().startswith(b"\x89PNG")
    rows = list(csv.DictReader((tmp_path / "s-indices.csv").read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 2 * (4 + 1 + 2)
    threshold = sobol_indices(open_sweep(path), "threshold")
    (row,) = (
        row for row in rows
        if (row["output"], row["plant.WOB"], row["variable"]) == ("threshold", "97347.0", "plant.c_b")
    )  # fmt: skip
    exact = threshold.sel({"plant.WOB": 97347.0, "variable": "plant.c_b"})
    assert float(row["total_confidence"]) == float(exact["total_confidence"])


@pytest.mark.parametrize(
    ("axes", "titles"),
    [
        ({}, ["q"]),
        ({"plant": ["A", "B"]}, ["plant = A: q", "plant = B: q"]),
        ({"plant": ["A", "B"], "p.Omega": [2.0, 1.0, 3.0]}, ["plant = A: q", "plant = B: q"]),
        ({"plant": ["A", "B"], "p.Omega": [2.0, 1.0], "p.WOB": [1.0, 2.0]}, ["plant = A: q", "plant = B: q"]),
        ({"p.c_b": [3.0, 1.0, 2.0], "p.Omega": [2.0, 1.0], "p.WOB": [1.0, 2.0]}, ["p.c_b = 2: q"]),
        ({"p.Omega": [2.0, 1.0], "p.WOB": [5.0]}, ["p.WOB = 5: q"]),
    ],
)
def test_indices_over_axes_of_any_kind_are_drawn(axes: dict[str, list[Any]], titles: list[str], tmp_path: Path) -> None:
    shape = [len(values) for values in axes.values()]
    values = np.linspace(0.0, 1.0, math.prod(shape) * 2).reshape(*shape, 2)
    dims = [*axes, "variable"]
    kinds = ("first", "first_confidence", "total", "total_confidence")
    indices = xarray.Dataset(dict.fromkeys(kinds, (dims, values)), {**axes, "variable": ["p.a", "p.b"]})
    draw_indices(tmp_path / "i.svg", {"q": indices})
    drawn = (tmp_path / "i.svg").read_text(encoding="utf-8")
    assert [each for each in re.findall(r"<!-- (.*) -->", drawn) if each.endswith("q")] == titles


def test_outputs_that_a_sweep_does_not_tell_are_named(store: Path, tmp_path: Path) -> None:
    code, said = cosim("sensitivity", str(store), "--output", str(tmp_path / "i.png"))
    assert code == 0
    assert "no indices of share: the sweep has not measured how a bit moves; known: " in said
    sentence = "error: --confidence 100: expected per cent, between 0 and 100"
    assert cosim("sensitivity", str(store), "--confidence", "100") == (2, sentence)


def test_an_output_that_no_sample_has_is_not_said_to_be_constant() -> None:
    def told(values: list[float]) -> str:
        each = estimate(np.array(values), 1, 0.95, 10, 0)
        kinds = ("first", "first_confidence", "total", "total_confidence")
        found = {name: ("variable", getattr(each, name)) for name in kinds} | {"left_out": each.left_out}
        screen = Console(file=io.StringIO(), width=100)
        print_indices(screen, xarray.Dataset(found, {"variable": ["p.a"]}, {"long_name": "q", "samples": 2}), "si")
        return screen.file.getvalue().splitlines()[-1]

    assert told([1.0] * 6) == "it does not vary"
    assert told([math.nan] * 6) == "there are too few samples that have it"
    assert told([1.0, 2.0, 3.0, math.nan, 2.0, 1.0]) == "there are too few samples that have it"


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"of": "thresold"}, "there are no indices of 'thresold'; did you mean 'threshold'?"),
        ({"confidence": 95.0}, "the confidence is 95; expected a number between 0 and 1"),
        ({"resamples": 1}, "the samples are to be drawn again 1 times; expected 2 at least"),
    ],
)
def test_indices_that_make_no_sense_are_refused(store: Path, changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        sobol_indices(open_sweep(store), **changes)
    assert str(refused.value) == sentence


def test_a_part_of_the_samples_has_no_indices(store: Path) -> None:
    whole = open_sweep(store)
    count = whole.sizes["sample"]
    with pytest.raises(InputError, match=rf"^there are 3 of {count} samples; expected all, in their order$"):
        sobol_indices(whole.isel(sample=slice(0, 3)), "threshold")


def test_a_store_without_such_samples_is_refused(tmp_path: Path) -> None:
    given: dict[str, Any] = {"workers": 1, "stop_time": 0.4, "measures": Last(window=0.2, sampling=0.2)}
    sweep("stick-slip", tmp_path / "g.zarr", grid={"plant.Omega": [8.0, 9.0]}, **given)
    with pytest.raises(InputError, match=r"^the sweep has no samples; expected some, and --sampling saltelli$"):
        sobol_indices(open_sweep(tmp_path / "g.zarr"))
    sweep("stick-slip", tmp_path / "s.zarr", samples={"plant.Omega": OMEGA}, count=4, **given)
    with pytest.raises(
        InputError, match=r"^the samples were drawn by latin-hypercube; indices are estimated of --sampling saltelli$"
    ):
        sobol_indices(open_sweep(tmp_path / "s.zarr"))


def test_a_sweep_that_is_not_done_has_no_indices_yet(tmp_path: Path) -> None:
    def interrupt(said: str, part: float) -> None:
        raise KeyboardInterrupt

    given: dict[str, Any] = {"workers": 1, "stop_time": 0.4, "measures": Last(window=0.2, sampling=0.2)}
    samples = {"plant.Omega": OMEGA}
    with pytest.raises(KeyboardInterrupt):
        sweep(
            "stick-slip", tmp_path / "s.zarr", samples=samples, count=64, sampling="saltelli", progress=interrupt,
            **given,
        )  # fmt: skip
    with pytest.raises(InputError, match=r"^\d+ of 192 points are done; expected all, go on with the same command$"):
        sobol_indices(open_sweep(tmp_path / "s.zarr"), "energy")


def test_without_salib_the_extra_is_named(monkeypatch: pytest.MonkeyPatch, store: Path) -> None:
    for name in ("SALib.analyze.sobol", "SALib.sample.sobol"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingPackageError, match=r"drillstring-cosim\[sensitivity\]"):
        sobol_indices(open_sweep(store), "energy")
    with pytest.raises(MissingPackageError, match=r"drillstring-cosim\[sensitivity\]"):
        sampled({"a": (0.0, 1.0)}, 4, "saltelli", 0)
