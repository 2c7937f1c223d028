"""Reports in a browser: nothing is asked for, nothing complained of, and plots respond."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from cosim import open_series, open_sweep, quantile_bands
from cosim.cli.reports import write_report
from tests.cosim.report.conftest import changed

if TYPE_CHECKING:
    from playwright.sync_api import Browser, ConsoleMessage, Page, Request

SPAN = "[0, 1, 2, 3].map((k) => Bokeh.documents[0].get_model_by_name(`panel-${k}`).x_range)"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report(run_of_two: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_report([run_of_two], tmp_path_factory.mktemp("browser") / "report.html")


class Watched:
    """A page that is watched for requests and complaints."""

    def __init__(self, browser: Browser, path: Path, **how: Any) -> None:
        self.page: Page = browser.new_context(**{"viewport": {"width": 1400, "height": 900}, **how}).new_page()
        self.page.set_default_timeout(10_000)
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.page.on("console", self._listen)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", self._note)
        self.page.goto(path.as_uri())
        self.page.wait_for_selector("html[data-ready=yes]")
        assert self.requests == [path.as_uri()]

    def _listen(self, said: ConsoleMessage) -> None:
        if said.type in ("error", "warning"):
            self.complaints.append(said.text)

    def _note(self, asked: Request) -> None:
        if not asked.url.startswith("data:"):
            self.requests.append(asked.url)

    def done(self) -> None:
        assert self.complaints == []
        self.page.context.close()


def until(page: Page, expression: str) -> None:
    """Wait for something in a page; what waits within the page itself is kept out by its content security policy."""
    for _ in range(100):
        if page.evaluate(expression):
            return
        page.wait_for_timeout(50)
    raise AssertionError(expression)


def test_plots_zoom_together_and_show_any_signal(browser: Browser, report: Path) -> None:
    watched = Watched(browser, report)
    page = watched.page
    page.locator("#begin").fill("20")
    page.locator("#end").fill("40")
    page.get_by_role("button", name="Show").press("Enter")
    spans = page.evaluate(f"{SPAN}.map((range) => [range.start, range.end])")
    assert spans == [[20, 40]] * 4
    page.get_by_role("button", name="Whole run").click()
    panel = page.locator("#panel-1")
    panel.scroll_into_view_if_needed()
    box = panel.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] * 0.4, box["y"] + 60)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] * 0.6, box["y"] + 90, steps=5)
    page.mouse.up()
    until(page, f"{SPAN}.every((range) => range.start > 25 && range.end < 75)")
    until(page, "document.getElementById('begin').valueAsNumber > 25")  # with the next frame
    page.get_by_label("Signal of plot 3").select_option(label="plant.WOB [kN]")
    assert page.locator("#caption-2").inner_text().startswith("plant.WOB [kN] over time")
    page.get_by_text("Numbers of plot 3").click()
    rows = page.locator("#rows-2 tr").all_inner_texts()
    assert [row.split("\t")[1:3] for row in rows] == [["30", "30"], ["97.347", "97.347"]]
    assert page.evaluate("Bokeh.documents[0].get_model_by_name('source-2-1').data.y[0]") == pytest.approx(97.347)
    page.get_by_role("checkbox", name="light").uncheck()
    assert not page.evaluate("Bokeh.documents[0].get_model_by_name('line-0-0').visible")
    assert "of heavy" in page.locator("#caption-0").inner_text()
    watched.done()


@pytest.mark.parametrize("width", [1400, 390])
def test_a_report_is_light_and_dark_wide_and_narrow(width: int, browser: Browser, report: Path) -> None:
    grounds: list[str] = []
    for scheme in ("light", "dark"):
        watched = Watched(browser, report, color_scheme=scheme, viewport={"width": width, "height": 900})
        page = watched.page
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        grounds.append(page.evaluate("getComputedStyle(document.body).backgroundColor"))
        ink = page.evaluate("Bokeh.documents[0].get_model_by_name('panel-0').below[0].major_label_text_color")
        assert (ink == "#e6eaee") == (scheme == "dark")
        watched.done()
    assert len(set(grounds)) == 2


def click(page: Page, panel: str, across: float, up: float) -> None:
    """Click into a plot, at parts of its width and height; the bar of colours and the tools are on its right."""
    drawn = page.locator(panel)
    drawn.scroll_into_view_if_needed()
    box = drawn.bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + box["width"] * across, box["y"] + box["height"] * (1.0 - up))


def number(page: Page, measure: str, sweep: int = 0) -> float:
    """Return a number at the cursor."""
    return float(page.locator("#values-0 tr", has_text=measure).locator("td").nth(sweep).inner_text())


def test_the_cursor_of_a_map_shows_the_numbers_of_its_point(
    browser: Browser, sweep_of_six: Path, tmp_path: Path
) -> None:
    watched = Watched(browser, write_report([sweep_of_six], tmp_path / "map.html", folds=0))
    page = watched.page
    stored = open_sweep(sweep_of_six)["bit_speed_max"].values
    assert number(page, "bit_speed_max") == pytest.approx(stored[0, 1], abs=1e-3)
    page.get_by_label("plant.Omega [rad/s]").select_option(label="15")
    page.get_by_label("plant.WOB [kN]").select_option(label="100")
    assert number(page, "bit_speed_max") == pytest.approx(stored[1, 2], abs=1e-3)
    assert "15 rad/s, plant.WOB 100 kN" in page.locator("#point-0").inner_text()
    page.locator("#measure-0").select_option(label="stuck_fraction: stuck fraction")
    click(page, "#map-0-0", 0.25, 0.25)
    until(page, "document.getElementById('at-0-0').value === '0' && document.getElementById('at-0-1').value === '0'")
    assert number(page, "bit_speed_max") == pytest.approx(stored[0, 0], abs=1e-3)
    assert page.evaluate("Bokeh.documents[0].get_model_by_name('threshold-0-0').data.x.length") > 100
    watched.done()


def test_branches_are_seen_beside_each_other_with_where_they_disagree_and_differ(
    browser: Browser, sweeps: Callable[..., Path], tmp_path: Path
) -> None:
    stores = [sweeps("plane", *more) for more in ((), ("--branch", "up"), ("--branch", "down"))]
    watched = Watched(browser, write_report(stores, tmp_path / "map.html", folds=0))
    page = watched.page
    rest, up, down = (open_sweep(store) for store in stores)
    swings = [each["bit_speed_max"].values - each["bit_speed_min"].values > 0.5 for each in (rest, up, down)]
    apart = np.logical_or.reduce(swings) & ~np.logical_and.reduce(swings)
    assert apart.any()
    dots = page.evaluate("Bokeh.documents[0].get_model_by_name('apart-0-0').data.x.length")
    assert dots == apart.sum()
    assert f"{dots} cells in which the sweeps disagree" in page.locator("#caption-0-2").inner_text()
    page.locator("#measure-0").select_option(label="torque_swing [kN.m]: swing of the torque at the top")
    page.get_by_label("less").select_option(label=f"{stores[2].name} (continued down)")
    shown = page.evaluate("Array.from(Bokeh.documents[0].get_model_by_name('cells-0-1').data.value)")
    expected = (up["torque_swing"].values - down["torque_swing"].values).T.ravel() / 1e3
    assert shown == pytest.approx(expected, abs=1e-3)
    low, high = page.evaluate("(({low, high}) => [low, high])(Bokeh.documents[0].get_model_by_name('colours-0-1'))")
    assert low == -high
    greatest = max(np.abs(each["torque_swing"] - down["torque_swing"]).max() for each in (rest, up))
    assert high == pytest.approx(float(greatest) / 1e3, rel=1e-3)
    watched.done()


def test_a_sweep_over_three_axes_shows_any_plane_through_the_cursor(
    browser: Browser, sweeps: Callable[..., Path], tmp_path: Path
) -> None:
    store = sweeps("cube")
    watched = Watched(browser, write_report([store], tmp_path / "cube.html"))
    page = watched.page
    stored = open_sweep(store).sortby("plant.c_b")
    values = "Array.from(Bokeh.documents[0].get_model_by_name('cells-0-0').data.value)"
    line = "Array.from(Bokeh.documents[0].get_model_by_name('threshold-0-0').data.x)"
    page.locator("#measure-0").select_option(label="bit_speed_max [rad/s]: greatest bit speed")
    lines: list[list[float]] = []
    for place, label in enumerate(("0.03", "60")):
        page.get_by_label("plant.c_b [N.m.s/rad]").select_option(label=label)
        assert page.evaluate(values) == pytest.approx(stored["bit_speed_max"].values[place].T.ravel(), abs=1e-3)
        assert f"at plant.c_b {label} N.m.s/rad" in page.locator("#caption-0-0").inner_text()
        lines.append(page.evaluate(line))
    assert lines[0] != lines[1]
    page.locator("#across-0").select_option(label="plant.c_b")
    page.get_by_label("plant.Omega [rad/s]").select_option(label="15")
    assert page.evaluate(values) == pytest.approx(stored["bit_speed_max"].values[:, 2].T.ravel(), abs=1e-3)
    assert page.evaluate(line) == []
    page.locator("#up-0").select_option(label="plant.c_b")  # which is across, and changes places
    assert page.locator("#across-0").input_value() == "2"
    assert page.evaluate(values) == pytest.approx(stored["bit_speed_max"].values[:, 2].ravel(), abs=1e-3)
    watched.done()


def test_a_sweep_over_one_axis_is_lines_that_zoom_together(
    browser: Browser, sweeps: Callable[..., Path], tmp_path: Path
) -> None:
    stores = [sweeps("line"), sweeps("line", "--branch", "up")]
    watched = Watched(browser, write_report(stores, tmp_path / "line.html"))
    page = watched.page
    stored = open_sweep(stores[1])
    assert number(page, "bit_speed_max", 1) == pytest.approx(stored["bit_speed_max"].values[0], abs=1e-3)
    click(page, "#line-0-1", 0.7, 0.5)
    until(page, "document.getElementById('at-0-0').value === '1'")
    assert number(page, "bit_speed_max", 1) == pytest.approx(stored["bit_speed_max"].values[1], abs=1e-3)
    spans = "[0, 5].map((k) => Bokeh.documents[0].get_model_by_name(`here-0-${k}`).location)"
    assert page.evaluate(spans) == [15, 15]
    shared = "new Set([0, 1, 5].map((k) => Bokeh.documents[0].get_model_by_name(`line-0-${k}`).x_range.id)).size"
    assert page.evaluate(shared) == 1
    page.get_by_role("checkbox", name="line.zarr").uncheck()
    assert not page.evaluate("Bokeh.documents[0].get_model_by_name('stroke-0-3-0').visible")
    assert stores[0].name not in page.locator("#caption-0-line-3").inner_text()
    watched.done()


def test_samples_are_a_distribution_and_a_probability_at_each_point(
    browser: Browser, sweeps: Callable[..., Path], tmp_path: Path
) -> None:
    store = sweeps("maybe")
    watched = Watched(browser, write_report([store], tmp_path / "maybe.html", folds=0))
    page = watched.page
    stored = open_sweep(store)
    unstable = stored["bit_speed_max"].values - stored["bit_speed_min"].values > 0.5
    unstable |= stored["stuck_fraction"].values > 0.999
    values = "Array.from(Bokeh.documents[0].get_model_by_name('cells-0-0').data.value)"
    assert page.evaluate(values) == pytest.approx(unstable.mean(axis=2).T.ravel(), abs=1e-4)
    page.locator("#measure-0").select_option(label="bit_speed_max [rad/s]: greatest bit speed")
    page.get_by_label("of the samples").select_option(label="90 % quantile")
    expected = np.quantile(stored["bit_speed_max"].values, 0.9, axis=2)
    assert page.evaluate(values) == pytest.approx(expected.T.ravel(), abs=1e-3)
    page.get_by_label("plant.WOB [kN]").select_option(label="100")
    page.get_by_label("plant.Omega [rad/s]").select_option(label="15")
    stair = page.evaluate("Array.from(Bokeh.documents[0].get_model_by_name('ecdf-0-0').data.x)")
    assert stair[1:] == pytest.approx(np.sort(stored["bit_speed_max"].values[1, 1]), abs=1e-3)
    spots = "(({x, y}) => [Array.from(x), Array.from(y)])(Bokeh.documents[0].get_model_by_name('scatter-0-0').data)"
    x, y = page.evaluate(spots)
    assert x == pytest.approx(stored["plant.mu_sb"].values, abs=1e-4)
    assert y == pytest.approx(stored["bit_speed_max"].values[1, 1], abs=1e-3)
    watched.done()


def test_points_that_failed_are_crosses_and_have_their_reason(
    browser: Browser, sweeps: Callable[..., Path], tmp_path: Path
) -> None:
    store = sweeps("failing")
    watched = Watched(browser, write_report([store], tmp_path / "failing.html"))
    crosses = "(({x, y}) => [Array.from(x), Array.from(y)])(Bokeh.documents[0].get_model_by_name('failed-0-0').data)"
    assert watched.page.evaluate(crosses) == [[1e-3, 1e-3], [20, 100]]
    reason = str(open_sweep(store)["message"].values[1, 0])
    assert f"Failed: {reason}" in watched.page.locator("#sweep-0").inner_text()
    watched.done()


TRACE = "(({x, y}) => [Array.from(x), Array.from(y)])(Bokeh.documents[0].get_model_by_name('signal-0-0-0').data)"


def test_the_cursor_of_a_map_shows_what_was_kept_over_time_there_or_nearest(
    browser: Browser, sweeps: Callable[..., Path], tmp_path: Path
) -> None:
    store = sweeps("kept")
    watched = Watched(browser, write_report([store, sweeps("kept", "--branch", "up")], tmp_path / "kept.html", folds=0))
    page = watched.page
    stored = open_series(store)["plant.bit_speed"]
    assert stored.sizes["plant.Omega"] == 2
    assert page.evaluate("Bokeh.documents[0].get_model_by_name('rings-0-0').data.x.length") == 4
    assert "Of the point at the cursor, plant.Omega 5 rad/s" in page.locator("#kept-0").inner_text()
    page.get_by_label("plant.WOB [kN]").select_option(label="100")
    for label, place, said in (
        ("5", 0, "Of the point at the cursor, plant.Omega 5 rad/s, plant.WOB 100 kN."),
        ("9", 0, "Nothing is kept of the point at the cursor; of the nearest that is, plant.Omega 5 rad/s"),
        ("13", 1, "Nothing is kept of the point at the cursor; of the nearest that is, plant.Omega 17 rad/s"),
        ("17", 1, "Of the point at the cursor, plant.Omega 17 rad/s, plant.WOB 100 kN."),
    ):
        page.get_by_label("plant.Omega [rad/s]").select_option(label=label)
        assert said in page.locator("#kept-0").inner_text()
        x, y = page.evaluate(TRACE)
        values = stored.values[place, 1]
        seen = np.interp(stored["time"].values, x, y)  # a constant has two points
        assert seen == pytest.approx(values, abs=1e-3 * max(1.0, float(np.ptp(values))))
    assert "plant.bit_torque [kN.m] over time" in page.locator("#caption-0-series-1").inner_text()
    page.get_by_role("checkbox", name=store.name).uncheck()
    assert not page.evaluate("Bokeh.documents[0].get_model_by_name('trace-0-1-0').visible")
    watched.done()


def test_samples_that_were_kept_over_time_are_bands_of_quantiles(
    browser: Browser, sweeps: Callable[..., Path], tmp_path: Path
) -> None:
    store = sweeps("keptline")
    watched = Watched(browser, write_report([store], tmp_path / "kept.html", folds=0))
    page = watched.page
    page.locator("#at-0-0").select_option(label="15")
    bands = quantile_bands(store)["plant.bit_speed"].transpose("plant.Omega", "quantile", "time").values[1]
    shown = page.evaluate("Object.entries(Bokeh.documents[0].get_model_by_name('signal-0-0-0').data)"
                          ".map(([name, values]) => [name, Array.from(values)])")  # fmt: skip
    for name, band in zip(("q0", "q1", "y", "q3", "q4"), bands, strict=True):
        assert dict(shown)[name] == pytest.approx(band, abs=1e-3 * max(1.0, float(np.ptp(band)))), name
    assert "Of the point at the cursor" in page.locator("#kept-0").inner_text()
    watched.done()


@pytest.mark.parametrize("name", ["samples", "linemaybe", "packagings", "long"])
def test_sweeps_of_every_kind_are_drawn_without_a_complaint(
    name: str, browser: Browser, sweeps: Callable[..., Path], tmp_path: Path
) -> None:
    page = write_report([sweeps(name)], tmp_path / "page.html", folds=0)
    watched = Watched(browser, page, viewport={"width": 390, "height": 900}, color_scheme="dark")
    assert watched.page.evaluate("document.documentElement.scrollWidth") <= 390
    assert watched.page.locator("#values-0 tr").count() >= 6
    watched.done()


def test_the_first_paint_comes_within_a_second(browser: Browser, report: Path) -> None:
    times: list[float] = []
    while len(times) < 5 and min(times, default=math.inf) >= 1000.0:  # the best, as other tests use the processors too
        watched = Watched(browser, report)
        times += watched.page.evaluate("performance.getEntriesByName('first-paint').map((entry) => entry.startTime)")
        watched.done()
    assert 0.0 < min(times) < 1000.0


def test_hostile_names_act_upon_nothing_in_a_browser(browser: Browser, run_of_two: Path, tmp_path: Path) -> None:
    evil = '</script><img src=x onerror="document.title=1">$$\\alpha$$ \\(x\\)'

    def poison(content: dict[str, Any]) -> None:
        content["title"] = evil
        for variant in content["variants"]:
            variant["units"]["plant.bit_speed"] = evil
            variant["variant"] += evil

    watched = Watched(browser, write_report([changed(run_of_two, tmp_path / "run", poison)], tmp_path / "report.html"))
    assert watched.page.title() == evil
    assert evil in watched.page.locator("#caption-0").inner_text()
    assert watched.page.locator("img").count() == 0
    watched.done()


def test_a_report_prints_in_light_whatever_the_screen(browser: Browser, report: Path) -> None:
    watched = Watched(browser, report, color_scheme="dark")
    printed = watched.page.pdf(format="A4")
    assert printed.startswith(b"%PDF")
    watched.page.emulate_media(media="print")
    assert watched.page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    watched.done()
