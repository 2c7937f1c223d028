"""Figures of results: what is drawn is what was recorded, in the units that are asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim import InputError, Result, View, plot, simulate
from cosim.recording.figure import draw, save_figure


@pytest.fixture(scope="module")
def result() -> Result:
    return simulate("stick-slip", stop_time=10.0)


def drawn(panel: Any) -> list[tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]]:
    return [(np.asarray(line.get_xdata()), np.asarray(line.get_ydata())) for line in panel.lines]


def test_a_plot_shows_the_signals_in_order(result: Result) -> None:
    figure = result.plot("plant.top_torque", "plant.bit_speed")
    assert [panel.get_ylabel() for panel in figure.axes] == ["plant.top_torque [kN.m]", "plant.bit_speed [rad/s]"]
    times, values = drawn(figure.axes[1])[0]
    assert times.tobytes() == result.time.tobytes()
    assert values.tobytes() == result["plant.bit_speed"].tobytes()


@pytest.mark.parametrize(
    ("signal", "label", "factor"),
    [  # NIST SP 811 (2008), Appendix B: a revolution a minute, a pound-force, a foot
        ("plant.bit_speed", "plant.bit_speed [rpm]", 30.0 / np.pi),
        ("plant.WOB", "plant.WOB [klbf]", 1.0 / 4448.2216152605),
        ("plant.top_torque", "plant.top_torque [kft.lbf]", 1.0 / (0.3048 * 4448.2216152605)),
    ],
)
def test_field_units_are_those_of_the_rig(result: Result, signal: str, label: str, factor: float) -> None:
    (panel,) = result.plot(signal, units="field").axes
    assert panel.get_ylabel() == label
    assert drawn(panel)[0][1] == pytest.approx(result[signal] * factor, rel=1e-15)


def test_a_range_of_time_reaches_the_edges_of_the_panel(result: Result) -> None:
    (panel,) = result.plot("plant.bit_speed", begin=2.003, end=4.004).axes
    times, _ = drawn(panel)[0]
    assert panel.get_xlim() == (2.003, 4.004)
    assert times[0] <= 2.003 < times[1]
    assert times[-2] < 4.004 <= times[-1]


def test_runs_lie_beside_or_over_each_other(result: Result) -> None:
    other = simulate("lower-wob", stop_time=5.0)
    beside = plot({"high": result, "low": other}, View(["plant.bit_speed"]))
    assert [panel.get_title() for panel in beside.axes] == ["high", "low"]
    over = plot({"high": result, "low": other}, View(["plant.bit_speed"], overlay=True), "both")
    (panel,) = over.axes
    assert [values.size for _, values in drawn(panel)] == [1001, 501]
    assert [text.get_text() for text in over.legends[0].get_texts()] == ["high", "low"]
    assert len({(line.get_color(), line.get_linestyle()) for line in panel.lines}) == 2


@pytest.mark.parametrize(
    ("signals", "options", "message"),
    [
        (["plant.bit_sped"], {}, "'plant.bit_sped' was not recorded; did you mean 'plant.bit_speed'?"),
        ([], {"begin": 4.0, "end": 4.0}, "the figure begins at 4 s and ends at 4 s; expected an earlier begin"),
        ([], {"units": "imperial"}, "there are no units 'imperial'; known: field, metric, si"),
    ],
)
def test_what_cannot_be_shown_is_refused(result: Result, signals: list[str], options: Any, message: str) -> None:
    with pytest.raises(InputError) as refused:
        result.plot(*signals, **options)
    assert str(refused.value) == message


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_a_figure_is_the_same_file_whenever_it_is_drawn(result: Result, kind: str, tmp_path: Path) -> None:
    contents: list[bytes] = []
    for _ in range(2):
        path = tmp_path / f"run.{kind}"
        draw(path, "a $x_{$ b", {"<one>": result}, View(["plant.bit_speed"]))
        contents.append(path.read_bytes())
    assert contents[0] == contents[1]
    assert contents[0].startswith({"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[kind])


def test_another_kind_of_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"run\.gif: expected a name that ends in \.png, \.svg or \.pdf"):
        save_figure(tmp_path / "run.gif", lambda: None)


def test_a_notebook_shows_the_figure(result: Result) -> None:
    assert result.plot("plant.bit_speed")._repr_png_().startswith(b"\x89PNG")
