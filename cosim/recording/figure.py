"""Draw trajectories over time: one row of panels for each signal, and beside each other, or over each other, the runs.

What a signal is called, and which are shown if nobody asks for any, is up to the caller; so is the style of units.
"""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import numpy as np
from typing_extensions import TypeIs

from cosim.errors import InputError, UnknownNameError, printable, suggestion
from cosim.files import replace_file
from cosim.recording.exchange import Trajectories
from cosim.system.field_units import shown_in
from cosim.system.signals import FloatArray

# Colours that stay apart for colour-blind readers and in grey, and line styles that tell runs apart without colour.
COLOURS = ("#0b5394", "#b45309", "#2f6f4f", "#7a3b69")
STYLES = ("-", "--", "-.", ":")
MOST_PANELS = 4
"""Rows of panels, if nobody asks for signals."""
# A long chattering line is more than Agg can draw at once, and its own chunks leave gaps.
_LONGEST_LINE = 5000
# A title or name of any length would be laid out for minutes, off the page.
_LONGEST_TITLE, LONGEST_NAME = 300, 80
_FORMATS = ("png", "svg", "pdf")


@dataclass(frozen=True)
class View:
    """Say what of some results is shown, and how.

    Parameters
    ----------
    signals : sequence of str
        One row of panels each, as ``component.variable``; by default the first numbers recorded.
    begin, end : float
        The times between which they are shown, s.
    overlay : bool
        Draw the results over each other instead of beside each other.
    units : str
        ``"si"``, ``"metric"`` or ``"field"``: see `cosim.system.field_units.shown_in`.
    names : mapping of str to str
        What variables are called, by the last part of their names.

    Raises
    ------
    InputError
        If nothing lies between the times.
    """

    signals: Sequence[str] = ()
    begin: float = -math.inf
    end: float = math.inf
    overlay: bool = False
    units: str = "si"
    names: Mapping[str, str] = field(default_factory=dict[str, str])

    def __post_init__(self) -> None:
        if not self.begin < self.end:
            raise InputError(
                f"the figure begins at {self.begin:g} s and ends at {self.end:g} s; expected an earlier begin"
            )
        shown_in("", self.units)

    def shown(self, result: Trajectories) -> list[str]:
        """Return the signals to show of a result, all of them recorded."""
        for name in self.signals:
            if name not in result.columns:
                raise UnknownNameError(f"'{name}' was not recorded{suggestion(name, result.columns)}")
        return (
            list(self.signals)
            or [name for name, values in result.columns.items() if values.dtype == np.float64][:MOST_PANELS]
        )

    def part(self, times: FloatArray) -> slice:
        """Return the rows between the times, with the rows next to them, so that lines reach the edges."""
        first, last = np.searchsorted(times, [self.begin, self.end], side="left")
        return slice(max(0, int(first) - 1), int(last) + 1)


def plot(results: Trajectories | Mapping[str, Trajectories], view: View | None = None, title: str = "") -> Any:
    """Draw one result or several over time.

    Parameters
    ----------
    results : Result, or mapping of str to Result
        One column of panels each, with the name above it; or one line each, if the view overlays them.
    view : View, optional
        What is shown, and how.
    title : str, optional
        Above everything.

    Returns
    -------
    matplotlib.figure.Figure
        A notebook shows it.

    Raises
    ------
    InputError
        If a signal was not recorded, or there is nothing to show.
    """
    chosen = view or View()
    named = dict(results) if _are_several(results) else {"": results}
    if not named:
        raise InputError("there is nothing to draw; expected a result at least")
    shown = chosen.shown(next(iter(named.values())))
    for result in named.values():
        chosen.shown(result)
    with plain_texts():
        return _compose(printable(title)[:_LONGEST_TITLE], named, shown, chosen)


def _are_several(results: Trajectories | Mapping[str, Trajectories]) -> TypeIs[Mapping[str, Trajectories]]:
    """Tell a mapping of results from one result, which is a mapping as well, of columns."""
    return not hasattr(results, "columns")


def draw(path: Path, title: str, results: Mapping[str, Trajectories], view: View) -> None:
    """Draw results into a file, PNG, SVG or PDF by its name, which replaces one that is there when it is complete.

    Raises
    ------
    InputError
        If a signal was not recorded, or the name of the file ends in something else.
    OSError
        If the file cannot be written.
    """
    save_figure(path, lambda: plot(results, view, title))


def save_figure(path: Path, compose: Callable[[], Any]) -> None:
    """Write a figure into a file, which replaces one that is there when it is complete.

    Parameters
    ----------
    path : Path
        The file, whose name ends in .png, .svg or .pdf.
    compose : callable
        Makes the figure, whose texts are drawn as they stand.

    Raises
    ------
    InputError
        If the name ends in something else.
    OSError
        If the file cannot be written.
    """
    kind = path.suffix.removeprefix(".").lower()
    if kind not in _FORMATS:
        raise InputError(f"{path}: expected a name that ends in .png, .svg or .pdf")
    drawn = io.BytesIO()
    undated = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with plain_texts():
        compose().savefig(drawn, format=kind, metadata=undated[kind])
    replace_file(path, drawn.getvalue())


@contextmanager
def plain_texts() -> Generator[None]:
    """Take texts as they stand while the block draws; they are from files, and so no mathematics."""
    import matplotlib

    context = cast(Any, matplotlib).rc_context
    settings = {"text.parse_math": False, "text.usetex": False, "svg.hashsalt": "cosim"}
    with context(settings), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")  # a font lacks some letters of all there are
        yield


def blank_figure(width: float, height: float) -> Any:
    """Return a figure without panels, sizes in inches; matplotlib, which takes long to import, is only now."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    class Drawing(Figure):
        """A figure that a notebook shows, whether or not it has been told of matplotlib."""

        def _repr_png_(self) -> bytes:
            drawn = io.BytesIO()
            with plain_texts():
                cast(Any, self).savefig(drawn, format="png")
            return drawn.getvalue()

    figure: Any = Drawing(figsize=(width, height), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _compose(title: str, results: Mapping[str, Trajectories], shown: Sequence[str], view: View) -> Any:
    """Lay out the panels."""
    rows, columns = max(1, len(shown)), 1 if view.overlay else len(results)
    figure = blank_figure(max(7.2, 3.6 * columns), 0.9 + 2.3 * rows)
    if title:
        figure.suptitle(title, fontsize=12)
    panels = figure.subplots(rows, columns, sharex=True, sharey="row", squeeze=False)
    for row, name in enumerate(shown):
        for number, (label, result) in enumerate(results.items()):
            panel = panels[row, 0 if view.overlay else number]
            line = COLOURS[(number if view.overlay else row) % len(COLOURS)], STYLES[number % len(STYLES)]
            _draw_line(panel, result, name, view, line if view.overlay else (line[0], "-"), printable(label))
        finish_row(panels[row], row, name, next(iter(results.values())).units.get(name, ""), view)
    for panel, label in zip(panels[0], results, strict=False):
        if columns > 1:
            panel.set_title(printable(label)[:LONGEST_NAME], fontsize=10)
    for panel in panels[-1]:
        panel.set_xlabel("Time [s]")
    if view.overlay and len(results) > 1:
        lines, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(lines, labels, loc="outside lower center", fontsize=8, frameon=False, ncols=min(4, len(results)))
    return figure


def finish_row(panels: Sequence[Any], row: int, name: str, unit: str, view: View) -> None:
    """Label a row by its signal and unit, and give all its panels the same look."""
    panels[0].set_ylabel(axis_label(name, unit, view))
    panels[0].set_title(f"{chr(ord('a') + row % 26)})", loc="left", fontsize=10, fontweight="bold")
    for panel in panels:
        panel.grid(visible=True, color="#d9d9d9", linewidth=0.5)
        panel.spines[["top", "right"]].set_visible(False)
        panel.margins(x=0.0)
        bounds = [edge if math.isfinite(edge) else None for edge in (view.begin, view.end)]
        if any(edge is not None for edge in bounds):
            panel.set_xlim(*bounds)


def _draw_line(panel: Any, result: Trajectories, name: str, view: View, line: tuple[str, str], label: str) -> None:
    """Draw one trajectory; strings as they follow each other, each at a height of its own."""
    part = view.part(result.time)
    times, values = result.time[part], result.columns[name][part]
    if values.dtype != object:
        values = values * shown_in(result.units.get(name, ""), view.units)[1]
    colour, style = line
    for first in range(0, max(1, values.size - 1), _LONGEST_LINE):
        piece = slice(first, first + _LONGEST_LINE + 1)  # a point in common, so that the line has no gap
        panel.plot(
            times[piece], values[piece], color=colour, linestyle=style, linewidth=0.9,
            label=None if first else label[:LONGEST_NAME],
        )  # fmt: skip


def axis_label(name: str, unit: str, view: View) -> str:
    """Write the label of an axis: what the variable is called, or its name, and the unit that is shown."""
    text = view.names.get(name.partition(".")[2], printable(name)[:LONGEST_NAME])
    shown = printable(shown_in(unit, view.units)[0])[:LONGEST_NAME]
    return f"{text} [{shown}]" if shown and shown != "1" else text
