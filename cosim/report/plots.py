"""Draw signals of runs over time, by Bokeh in the reader's browser.

The page holds Bokeh's own script, a few plots without data that share one time axis, and all lines, thinned out. Which
signal a plot shows is chosen in the page.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cosim.drilling.reporting import default_signals
from cosim.errors import InputError, printable, require
from cosim.recording.result import Result
from cosim.report.lines import Line, line, shares
from cosim.system.field_units import shown_in

PANELS = 4
"""Plots below each other."""
_MOST_POINTS = 90_000
"""Of all lines; 5.4 bytes of the page each."""
_MOST_LINES = 16
"""Over each other, to be told apart."""
# Light and dark, colours that stay apart for colour-blind readers; dashes tell lines apart without any.
COLOURS = ("#0b5394", "#b45309", "#2f6f4f", "#7a3b69")
DARK_COLOURS = ("#7db4f0", "#f0a95b", "#7fcba4", "#d79ac6")
_DASHES: tuple[tuple[int, ...], ...] = ((), (6, 3), (2, 3), (8, 3, 2, 3))
_HEIGHT = 240


@dataclass(frozen=True)
class Plotted:
    """A signal that can be shown.

    Attributes
    ----------
    name, unit : str
        Its name, and the unit it is shown in.
    lines : mapping of str to Line
        By run.
    """

    name: str
    unit: str
    lines: Mapping[str, Line]


@dataclass(frozen=True)
class Plots:
    """Signals of runs, and which of them are shown at first.

    Attributes
    ----------
    runs : tuple of str
        Names of runs.
    signals : tuple of Plotted
        All that there are lines of.
    shown : tuple of str
        Those shown at first, one a plot.
    left_out : int
        Signals for which there is no room.
    begin, end : float
        Times, s.
    """

    runs: tuple[str, ...]
    signals: tuple[Plotted, ...]
    shown: tuple[str, ...]
    left_out: int
    begin: float
    end: float

    def to_json(self) -> dict[str, Any]:
        """Return what the script of the page reads."""
        signals = [
            {
                "name": printable(each.name),
                "unit": printable(each.unit),
                "lines": [each.lines[run].to_json() if run in each.lines else None for run in self.runs],
                "table": [_summary(each.lines.get(run)) for run in self.runs],
            }
            for each in self.signals
        ]
        return {
            "runs": [printable(run) for run in self.runs],
            "signals": signals,
            "shown": [self.place(name) for name in self.shown],
            "begin": self.begin,
            "end": self.end,
            "colours": {"light": COLOURS, "dark": DARK_COLOURS},
            "document": document(len(self.shown), len(self.runs), self.begin, self.end),
        }

    def numbers(self, signal: Plotted, run: str) -> list[str]:
        """Return first, last, least and greatest value of a run's signal; nothing where it has none."""
        return _summary(signal.lines.get(run))

    def place(self, name: str) -> int:
        """Return the place of a signal among all."""
        return [each.name for each in self.signals].index(name)


def _summary(found: Line | None) -> list[str]:
    """Write first, last, least and greatest value."""
    return [] if found is None else [number(each) for each in (found.first, found.last, found.least, found.greatest)]


def number(value: float) -> str:
    """Write a number for people."""
    return f"{value:.6g}"


def plots_of(results: Mapping[str, Result], units: str) -> Plots | None:
    """Return the plots of some runs; None where nothing can be drawn.

    Raises
    ------
    InputError
        If there are more runs than lines that can be told apart.
    """
    if len(results) > _MOST_LINES:
        raise InputError(f"{len(results)} runs cannot be told apart in one plot; expected {_MOST_LINES} at most")
    timed = {run: result for run, result in results.items() if result.time.size}
    if not timed:
        return None
    types = {name: values.dtype for result in timed.values() for name, values in result.columns.items()}
    names = [name for name, dtype in types.items() if not dtype.hasobject]
    shown = _first_shown(types)
    points = shares(names, shown, len(timed), _MOST_POINTS)
    found: list[Plotted] = []
    for name, most in points.items():
        unit, factor = _shown_unit(name, timed, units)
        lines = {run: _line(result, name, most, factor) for run, result in timed.items() if name in result}
        found.append(Plotted(name, unit, {run: each for run, each in lines.items() if each is not None}))
    if not found:
        return None
    begin, end = (float(edge([edge(r.time) for r in timed.values()])) for edge in (np.min, np.max))
    present = tuple(name for name in shown if name in points)
    return Plots(tuple(timed), tuple(found), present, len(names) - len(found), begin, end if end > begin else begin + 1)


def _line(result: Result, name: str, most: int, factor: float) -> Line | None:
    """Return the line of a run's signal; None of strings."""
    return line(result.time, result[name], most, factor)


def _shown_unit(name: str, results: Mapping[str, Result], units: str) -> tuple[str, float]:
    """Return the unit to show a signal in, and the factor into it; SI where runs do not agree on its unit."""
    declared = {result.units.get(name, "") for result in results.values() if name in result}
    if len(declared) > 1:
        raise InputError(f"{name} is in {' and in '.join(sorted(declared))}; expected runs that agree")
    return shown_in(declared.pop(), units)


def _first_shown(types: Mapping[str, np.dtype[Any]]) -> list[str]:
    """Choose what is shown at first: of the bit, where there is one, then its likes at the top, then what comes."""
    first = default_signals(types)
    component = first[0].partition(".")[0] if first else ""
    usual = [f"{component}.{name}" for name in ("top_speed", "top_torque")]
    rest = [name for name, dtype in types.items() if dtype == np.float64]
    drawn = [name for name in (*first, *usual, *rest) if name in types and not types[name].hasobject]
    return list(dict.fromkeys(drawn or [name for name, dtype in types.items() if not dtype.hasobject]))[:PANELS]


def document(panels: int, runs: int, begin: float, end: float) -> Any:
    """Return the plots, without data, as Bokeh's script reads them; the same text each time.

    Raises
    ------
    MissingPackageError
        If Bokeh is not installed.
    """
    models = require("bokeh.models", extra="report", purpose="a report")
    plotting = require("bokeh.plotting", extra="report", purpose="a report")
    encoder = require("bokeh.core.json_encoder", extra="report", purpose="a report")
    made = require("bokeh.document", extra="report", purpose="a report").Document(title="report")
    shared = models.Range1d(begin, end, bounds=(begin, end), name="time")
    for panel in range(panels):
        made.add_root(_panel(models, plotting, shared, panel, runs))
    return json.loads(renumbered(encoder.serialize_json(made.to_json(deferred=False))))


def _panel(models: Any, plotting: Any, shared: Any, panel: int, runs: int) -> Any:
    """Return one plot, with a line for each run."""
    tools = "xpan,xbox_zoom,xwheel_zoom,reset,save"
    drawn = plotting.figure(
        name=f"panel-{panel}", x_range=shared, height=_HEIGHT, sizing_mode="stretch_width", tools=tools,
        active_drag="xbox_zoom", active_scroll=None, background_fill_color=None, border_fill_color=None,
        outline_line_color=None, x_axis_label="time [s]", y_range=models.DataRange1d(only_visible=True),
    )  # fmt: skip
    drawn.toolbar.logo = None
    for run in range(runs):
        # replaced before anybody sees it; without a point Bokeh finds no range, and says so in the console
        ends = {"x": [shared.start, shared.end], "y": [0.0, 1.0]}
        source = models.ColumnDataSource(ends, name=f"source-{panel}-{run}")
        drawn.line(
            "x", "y", source=source, name=f"line-{panel}-{run}", line_color=COLOURS[run % len(COLOURS)],
            line_width=1.5, line_dash=list(dash_of(run)),
        )  # fmt: skip
    return drawn


_ID = re.compile(r'"p\d+"')


def renumbered(text: str) -> str:
    """Give models numbers by where they come in the text, not by how many the process has made before."""
    names: dict[str, str] = {}
    return _ID.sub(lambda found: names.setdefault(found[0], f'"p{len(names) + 1}"'), text)


def dash_of(run: int) -> tuple[int, ...]:
    """Return the dashes of a run's lines; no two runs have the same together with the same colour."""
    return _DASHES[(run + run // len(COLOURS)) % len(_DASHES)]


def strokes(count: int) -> list[tuple[str, str, str]]:
    """Return the colours in light and dark, and the dashes, of each run's lines."""
    return [
        (COLOURS[run % len(COLOURS)], DARK_COLOURS[run % len(COLOURS)], " ".join(map(str, dash_of(run))))
        for run in range(count)
    ]


def script() -> str:
    """Return Bokeh's script, without the parts for widgets, tables and the like.

    Raises
    ------
    MissingPackageError
        If Bokeh is not installed.
    InputError
        If its script is not there, or cannot stand in a page.
    """
    package = require("bokeh", extra="report", purpose="a report")
    path = Path(package.__file__).parent / "server" / "static" / "js" / "bokeh.min.js"
    try:
        text = path.read_text(encoding="utf-8").replace("\r\n", "\n")
    except OSError as error:
        raise InputError(f"Bokeh's script {path} cannot be read: {error.strerror}") from error
    if re.search(r"</script|<!--|\r", text, re.IGNORECASE):
        raise InputError(f"Bokeh's script {path} cannot stand in a page; expected Bokeh 3.8 or later")
    return text
