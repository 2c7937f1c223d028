"""Draw severity maps side by side, with the lines of theory and what a reader has to know of single cells."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cosim.drilling.severity_map import Map, bistable, limits, theory_lines
from cosim.recording.figure import blank_figure, save_figure
from cosim.system.field_units import shown_in
from cosim.system.signals import FloatArray

if TYPE_CHECKING:
    from cosim.drilling.mathematics import BoolArray

_NAMES = {"Omega": "Drive speed", "WOB": "Weight on bit"}


def draw_maps(
    path: Path,
    maps: Sequence[Map],
    units: str = "metric",
    folds: tuple[FloatArray, FloatArray] | None = None,
    *,
    difference: bool = False,
) -> None:
    """Draw maps of one number side by side into a PNG file.

    Parameters
    ----------
    path : Path
        The file.
    maps : sequence of Map
        Over the same plane; of several branches of one sweep, cells in which they disagree are marked.
    units : str
        As of `cosim.system.field_units.shown_in`.
    folds : (ndarray, ndarray), optional
        From `cosim.drilling.severity_map.find_folds`, of the first map; it is drawn in those of the same string.
    difference : bool
        The maps are differences, and have a colour for none.

    Raises
    ------
    InputError
        If there are no such units, or the maps are over different planes.
    OSError
        If the file cannot be written.
    """
    shown_in("", units)
    for each in maps[1:]:
        each.less(maps[0])
    save_figure(path, lambda: _compose(maps, units, folds, difference))


def _compose(maps: Sequence[Map], units: str, folds: tuple[FloatArray, FloatArray] | None, difference: bool) -> Any:
    """Lay out the panels."""
    figure = blank_figure(1.6 + 4.0 * len(maps), 4.3)
    panels = figure.subplots(1, len(maps), sharey=True, squeeze=False)[0]
    first = maps[0]
    unit, factor = shown_in(first.unit, units)
    ends = limits([each.values * factor for each in maps], first.quantity, difference)
    apart = bistable(maps) if len(maps) > 1 and not difference else None
    shading = None
    for number, (panel, each) in enumerate(zip(panels, maps, strict=True)):
        shading = _draw(panel, each, factor, units, ends, difference)
        _draw_lines(panel, each, units, folds if each.string == first.string else None)
        if apart is not None:
            _mark(panel, each, apart, units)
        panel.set_title(f"{chr(ord('a') + number)}) {each.title}" if len(maps) > 1 else each.title, fontsize=10)
        if number == 0:
            panel.set_ylabel(_label(each.y_name, each.y_unit, units))
    text = first.text[0].upper() + first.text[1:]
    extend = "max" if first.quantity == "ssi" and not difference else "neither"
    figure.colorbar(shading, ax=list(panels), label=f"{text} [{unit}]" if unit else text, extend=extend)
    handles, labels = panels[0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", ncols=len(handles), frameon=False, fontsize=9)
    return figure


def _label(name: str, unit: str, units: str) -> str:
    """Write the label of an axis."""
    variable = name.partition(".")[2]
    shown = shown_in(unit, units)[0]
    return f"{_NAMES.get(variable, name)} [{shown}]" if shown else _NAMES.get(variable, name)


def _draw(panel: Any, each: Map, factor: float, units: str, ends: tuple[float, float], difference: bool) -> Any:
    """Draw the number as colours, where the bit stands still grey, and failed runs as crosses."""
    x, y = each.x * shown_in(each.x_unit, units)[1], each.y * shown_in(each.y_unit, units)[1]
    values = each.values * factor
    colours = "RdBu_r" if difference else "viridis" if each.quantity == "period" else "magma_r"
    panel.set_facecolor("white")
    edges = cell_edges(x), cell_edges(y)
    still = np.isinf(values)
    if still.any():
        grey = np.where(still, 1.0, np.nan)
        panel.pcolormesh(*edges, grey, cmap="Greys", vmin=0.0, vmax=2.0)
    finite = np.where(still, np.nan, values)
    shading = panel.pcolormesh(*edges, finite, cmap=colours, vmin=ends[0], vmax=ends[1])
    if each.failed.any():
        rows, columns = np.nonzero(each.failed)
        panel.plot(x[columns], y[rows], "x", color="#c00000", markersize=4, label="failed")
    if still.any():
        label = "bit stands still" if not difference else "bit stands still in one"
        panel.plot([], [], "s", color="#969696", label=label)
    panel.set(xlabel=_label(each.x_name, each.x_unit, units), xlim=edges[0][[0, -1]], ylim=edges[1][[0, -1]])
    return shading


def cell_edges(values: FloatArray) -> FloatArray:
    """Return where the cells of an axis begin and end: halfway between values, and as far beyond those at its ends.

    The cell of a single value is 1 wide: without edges Matplotlib would draw it without any width.
    """
    if values.size < 2:
        return values[0] + np.array([-0.5, 0.5])
    between = 0.5 * (values[:-1] + values[1:])
    return np.concatenate([[2.0 * values[0] - between[0]], between, [2.0 * values[-1] - between[-1]]])


_LINES = {"threshold": ("-", "#0b5394"), "fold": ("--", "#2f6f4f")}


def _draw_lines(panel: Any, each: Map, units: str, folds: tuple[FloatArray, FloatArray] | None) -> None:
    """Draw what theory says."""
    x_factor, y_factor = shown_in(each.x_unit, units)[1], shown_in(each.y_unit, units)[1]
    for line in theory_lines(each, folds):
        dash, ink = _LINES[line.kind]
        for width, colour, label in ((3.2, "white", None), (1.6, ink, line.text)):
            panel.plot(
                line.speeds * x_factor, line.weights * y_factor, dash, color=colour, linewidth=width, label=label
            )


def _mark(panel: Any, each: Map, apart: BoolArray, units: str) -> None:
    """Mark cells in which branches disagree."""
    rows, columns = np.nonzero(apart)
    x, y = each.x * shown_in(each.x_unit, units)[1], each.y * shown_in(each.y_unit, units)[1]
    panel.plot(x[columns], y[rows], ".", color="#0f9d9d", markersize=1.8, label="branches disagree: bistable")
