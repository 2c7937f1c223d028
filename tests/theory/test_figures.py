"""The figures show what the numbers say: colours where rotation is stable and where not, curves where cycles are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from cosim import load_scenario, simulate
from cosim.drilling.energy_growth import energy_growth
from cosim.drilling.maps import draw_bistability, draw_charts, draw_growth, draw_loop_set
from models.controllers.laws import DissipativeLaw
from models.theory.loop_set import PrintedLoop
from models.theory.stability.chart import stability_chart
from tests.theory.strings import NOMINAL, PAPER
from tests.theory.test_bistability import over_omega

pytestmark = pytest.mark.slow


def share(path: Path, low: tuple[float, float, float], high: tuple[float, float, float]) -> float:
    """Return the share of pixels whose red, green and blue lie between two colours."""
    colours = imread(path)[:, :, :3]
    return float(((colours >= low) & (colours <= high)).all(axis=2).mean())


def test_charts_are_orange_where_rotation_is_unstable_and_purple_where_it_is_stable(tmp_path: Path) -> None:
    shares = {}
    for name, omegas in (("stable", [12.0, 20.0]), ("unstable", [6.2, 7.0]), ("none", [2.0, 3.0])):
        chart = stability_chart(PAPER, 10.0, NOMINAL, ("Omega", omegas), ("WOB", [90e3, 97347.0]))
        draw_charts(tmp_path / f"{name}.png", [chart])
        path = tmp_path / f"{name}.png"
        shares[name] = share(path, (0.3, 0.15, 0.0), (1.0, 0.8, 0.5)), share(path, (0.1, 0.0, 0.25), (0.65, 0.6, 0.8))
    assert shares["unstable"][0] > shares["none"][0] + 0.2
    assert shares["stable"][1] > shares["none"][1] + 0.2
    assert shares["stable"][0] < shares["none"][0] + 0.01
    assert shares["unstable"][1] < shares["none"][1] + 0.01


def test_cycles_and_rotation_are_drawn_over_the_band_in_which_both_are_stable(tmp_path: Path) -> None:
    path = tmp_path / "bistability.png"
    draw_bistability(path, over_omega())
    assert share(path, (0.92, 0.92, 0.92), (0.95, 0.95, 0.95)) > 0.3
    for red, green, blue in ((0x0B, 0x53, 0x94), (0xB4, 0x53, 0x09)):
        colour = np.array([red, green, blue]) / 255
        assert share(path, tuple(colour - 0.02), tuple(colour + 0.02)) > 5e-4


def test_gap_of_the_printed_law_is_drawn_with_its_solutions_and_where_a_run_has_been(tmp_path: Path) -> None:
    result = simulate(load_scenario("dissipative-law"), variant="printed", stop_time=2.0)
    loop = PrintedLoop.of(PAPER, DissipativeLaw(), 10.0)
    images: list[np.ndarray] = []
    for name, run in (("with", result), ("without", None)):
        path = tmp_path / f"{name}.png"
        draw_loop_set(path, loop, (-5.0, 25.0), 40.0, run)
        assert share(path, (0.97, 0.86, 0.78), (1.0, 0.92, 0.84)) > 0.3
        assert share(path, (0.0, 0.28, 0.5), (0.1, 0.38, 0.65)) > 2e-3
        images.append(imread(path)[:, :, :3])
    changed = (images[0] != images[1]).any(axis=2)
    assert 100 < np.count_nonzero(changed) < result.time.size * 4
    # nothing of the run is in the left panel
    assert not changed[:, : changed.shape[1] // 2].any()


def test_growth_is_stacked_in_the_colours_of_its_causes(tmp_path: Path) -> None:
    scenario = load_scenario("dissipative-law")
    colours = {"printed": (0xB4, 0x53, 0x09), "tracking": (0x0B, 0x53, 0x94)}
    for form, other in (("printed", "tracking"), ("tracking", "printed")):
        path = tmp_path / f"{form}.png"
        draw_growth(path, {form: energy_growth(simulate(scenario, variant=form, stop_time=2.0))})
        own, foreign = (np.array(colours[name]) / 255 for name in (form, other))
        made, absent = (share(path, tuple(one - 0.01), tuple(one + 0.01)) for one in (own, foreign))
        assert made > 0.03
        assert absent < 0.01 * made
