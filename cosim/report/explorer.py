"""Draw sweeps, by Bokeh in the reader's browser: maps, lines and samples, whatever number of dimensions they have.

Sweeps over the same points are one group with one cursor: branches of a plant are seen beside each other or over each
other. Over two axes and more there are maps of the plane through the cursor, over one there are lines of each measure;
of samples there are distributions.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from itertools import islice
from typing import Any

import numpy as np

from cosim.drilling import severity_map
from cosim.errors import MissingPackageError, require
from cosim.progress import Progress
from cosim.report.lines import line, packed, packed_fully
from cosim.report.plots import COLOURS, DARK_COLOURS, dash_of, renumbered, strokes
from cosim.system.field_units import shown_in
from cosim.system.signals import FloatArray

log = logging.getLogger("cosim")

UNSTABLE = "unstable"
_MARKS = {"apart": "#0f9d9d", "failed": "#d11a1a"}
_LINES = {"threshold": ("#0b5394", ()), "fold": ("#2f6f4f", (6, 4))}
_MOST_PLANES = 300
"""For which lines of theory are kept, of a sweep over three axes and more."""
_BRANCHES = {"rest": "", "up": " (continued up)", "down": " (continued down)"}
_HEIGHT = 380
_PANELS = 4
"""Plots over time."""
_MOST_ROWS = 75_000
"""Of all lines over time; 5.4 bytes of the page each."""


def explored(
    sweeps: Sequence[dict[str, Any]], units: str, folds: int, progress: Progress | None = None
) -> dict[str, Any]:
    """Return groups of sweeps, for the page and for its script.

    Parameters
    ----------
    sweeps : sequence of dict
        From `cosim.sweeps.told.gather`; their `found`, `shown` and `series` are taken out.
    units : str
        As of `cosim.system.field_units.shown_in`.
    folds : int
        At how many weights to look for the end of the cycles, of sweeps over two axes; each takes seconds.
    progress : callable, optional
        Called while cycles are followed.
    """
    groups: dict[str, list[dict[str, Any]]] = {}
    for place, each in enumerate(sweeps):
        groups.setdefault(_points(each["shown"]), []).append({**each, "place": place})
        del each["shown"], each["found"], each["series"]
    room = _MOST_ROWS // max(1, sum(_lines(each["series"]) for members in groups.values() for each in members))
    theory = _Theory(units, folds, progress)
    drawn = [_group(members, theory, room) for members in groups.values()]
    palettes = _palettes()
    return {
        "groups": [_told(group, members) for group, members in zip(drawn, groups.values(), strict=True)],
        "drawn": {
            "groups": drawn,
            "palettes": palettes,
            "colours": {"light": COLOURS, "dark": DARK_COLOURS},
            "document": document(drawn, palettes["severity"]),
        },
    }


def _points(shown: Mapping[str, Any]) -> str:
    """Return a text that is equal of sweeps over the same points that have kept the same measures."""
    samples = [(each["name"], each["unit"], each["values"].tolist()) for each in shown["samples"]]
    return json.dumps([shown["axes"], samples, [(each["name"], each["unit"]) for each in shown["measures"]]])


def _group(members: Sequence[Mapping[str, Any]], theory: _Theory, room: int) -> dict[str, Any]:
    """Return what the script draws of sweeps over the same points; of a line over time, so many rows at most."""
    contents = [each["shown"] for each in members]
    first = contents[0]
    measures = [_measure(told) for told in zip(*(each["measures"] for each in contents), strict=True)]
    states = [severity_map.instability(each["found"]) for each in members]
    if all(each is not None for each in states):
        label = f"the bit speed swings by more than {severity_map.SWING:g} rad/s, or the bit stands still"
        measures.append(_measure([{"name": UNSTABLE, "unit": "", "label": label, "values": state} for state in states]))
    return {
        "names": [f"{each['folder']}{_BRANCHES[each['branch']]}" for each in members],
        "axes": first["axes"],
        "samples": [{**each, "values": packed(each["values"])} for each in first["samples"]],
        "count": first["count"],
        "measures": measures,
        "failed": [each["failed"] for each in contents],
        "series": [_series(each["series"], room) for each in members],
        "lines": [theory.lines(each["found"], [axis["name"] for axis in first["axes"]]) for each in members],
    }


def _lines(series: Mapping[str, Any] | None) -> int:
    """Return how many lines over time there are; quantiles share their times, and count half."""
    if series is None:
        return 0
    each = max(1.0, (len(series["quantiles"]) + 1) / 2)
    return int(each * len(series["signals"]) * len(series["values"][0]))


def _series(series: Mapping[str, Any] | None, most: int) -> dict[str, Any] | None:
    """Return what was kept over time, each line with so many rows at most."""
    if series is None:
        return None
    time = series["time"]
    draw = _bands if series["quantiles"] else _line
    values = [[draw(time, rows, most) for rows in points] for points in series["values"]]
    told = {name: series[name] for name in ("signals", "axes", "quantiles", "messages")}
    return {**told, "end": [float(time[0]), float(time[-1])], "lines": values}


def _line(time: FloatArray, rows: FloatArray, most: int) -> dict[str, Any] | None:
    """Return a line over time, with its extremes; None where there is none."""
    if not np.isfinite(rows).any():
        return None
    found = line(time, rows, most)
    return None if found is None else found.to_json()


def _bands(time: FloatArray, rows: FloatArray, most: int) -> dict[str, Any] | None:
    """Return quantiles over time, at times that are evenly far apart, which all of them share."""
    if not np.isfinite(rows).any():
        return None
    every = max(1, -(-time.size // most))
    return {"x": packed(time[::every]), "quantiles": [packed(each[::every]) for each in rows]}


def _told(group: Mapping[str, Any], members: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return what the template of the page needs of a group."""
    bit = any(each["name"] == UNSTABLE for each in group["measures"])
    return {
        "title": members[0]["title"],
        "names": group["names"],
        "axes": [{**each, "count": len(each["texts"])} for each in group["axes"]],
        "samples": [each["name"] for each in group["samples"]],
        "count": group["count"],
        "panels": _panels(group),
        "kinds": sorted({each["kind"] for lines in group["lines"] for each in lines}, reverse=True),
        "strokes": strokes(len(members)),
        "series": min(_PANELS, len(_signals(group))),
        "signals": len(_signals(group)),
        "places": [each["place"] for each in members],
        "bit": bit,
        "compared": bit and len(members) > 1,
        "bistable": len({severity_map.system_of(each["record"]) for each in members}) == 1,
        "thinned": list(dict.fromkeys(text for each in members for text in each["thinned"])),
    }


def _signals(group: Mapping[str, Any]) -> list[str]:
    """Return the names of what was kept over time in any sweep."""
    names = [each["name"] for series in group["series"] if series is not None for each in series["signals"]]
    return list(dict.fromkeys(names))


def _panels(group: Mapping[str, Any]) -> int:
    """Return over how many measures there are lines: not over a state that is 0 or 1, but over its probability."""
    plain = not group["count"] and any(each["name"] == UNSTABLE for each in group["measures"])
    return len(group["measures"]) - plain


def _measure(told: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return a measure of each sweep, with the ends of its colours."""
    first = told[0]
    values = [np.asarray(each["values"], dtype=np.float64) for each in told]
    low, high = severity_map.limits(values, first["name"], difference=False)
    return {
        **{name: first[name] for name in ("name", "unit", "label")},
        "low": low,
        "high": high if high > low else low + 1.0,
        "palette": "plain" if first["name"] == "period" else "severity",
        "values": [packed_fully(each.ravel()) for each in values],
    }


class _Theory:
    """Lines of theory over sweeps; the end of the cycles is looked for once for all of one string over one range."""

    def __init__(self, units: str, folds: int, progress: Progress | None) -> None:
        self._units, self._count, self._progress = units, folds, progress
        self._known: dict[Any, Any] = {}

    def lines(self, found: Any, names: Sequence[str]) -> list[dict[str, Any]]:
        """Return lines, each with its plane and the place of that on the other axes, which have these names."""
        told: list[dict[str, Any]] = []
        try:
            for at, plane in islice(severity_map.planes(found), _MOST_PLANES):
                place = {names.index(name): value for name, value in at.items()}
                axes = [names.index(plane.x_name), names.index(plane.y_name)]
                x_factor, y_factor = (shown_in(unit, self._units)[1] for unit in (plane.x_unit, plane.y_unit))
                for each in severity_map.theory_lines(plane, None if at else self._folds(plane)):
                    x, y = packed(each.speeds * x_factor), packed(each.weights * y_factor)
                    told.append({"text": each.text, "kind": each.kind, "at": place, "plane": axes, "x": x, "y": y})
        except MissingPackageError as error:
            log.warning("the lines of theory are not drawn: %s", error)
        return told

    def _folds(self, plane: severity_map.Map) -> Any:
        """Return the end of the cycles, if it is asked for."""
        if not self._count:
            return None
        key = plane.string, plane.x[-1], plane.y[0], plane.y[-1]
        if key not in self._known:
            self._known[key] = severity_map.find_folds(plane, self._count, self._progress)
        return self._known[key]


def _palettes() -> dict[str, list[str]]:
    """Return the colours of maps: of severity, of other numbers, and of differences."""
    palettes = require("bokeh.palettes", extra="report", purpose="a report")
    difference = palettes.interp_palette(palettes.RdBu11, 255)
    return {
        "severity": list(reversed(palettes.Magma256)),
        "plain": list(palettes.Viridis256),
        "difference": list(difference),
    }


def document(groups: Sequence[Mapping[str, Any]], palette: Sequence[str]) -> Any:
    """Return the plots, without data, as Bokeh's script reads them."""
    encoder = require("bokeh.core.json_encoder", extra="report", purpose="a report")
    made = require("bokeh.document", extra="report", purpose="a report").Document(title="report")
    for place, group in enumerate(groups):
        figures = _Figures(place, len(group["names"]))
        if len(group["axes"]) > 1:
            figures.maps(palette)
        elif group["axes"]:
            figures.lines(_panels(group), banded=bool(group["count"]))
        if group["count"]:
            figures.samples()
        figures.series(min(_PANELS, len(_signals(group))), banded=bool(group["count"]))
        for drawn in figures.made:
            made.add_root(drawn)
    return json.loads(renumbered(encoder.serialize_json(made.to_json(deferred=False))))


class _Figures:
    """The plots of a group."""

    def __init__(self, place: int, sweeps: int) -> None:
        self._models = require("bokeh.models", extra="report", purpose="a report")
        self._plotting = require("bokeh.plotting", extra="report", purpose="a report")
        self._place, self._sweeps = place, sweeps
        self.made: list[Any] = []

    def maps(self, palette: Sequence[str]) -> None:
        """Make a map for each sweep, that zoom together."""
        ranges = {f"{a}_range": self._models.Range1d(0.0, 1.0, name=f"{a}-range-{self._place}") for a in "xy"}
        for sweep in range(self._sweeps):
            name = f"{self._place}-{sweep}"
            drawn = self._figure(f"map-{name}", _HEIGHT, "pan,box_zoom,reset,save,tap", **ranges)
            drawn.grid.visible = False
            mapper = self._models.LinearColorMapper(
                palette=list(palette), low=0.0, high=1.0, nan_color="#9a9a9a", name=f"colours-{name}"
            )
            corners = ("left", "right", "top", "bottom")
            cells = self._source(f"cells-{name}", *corners, "value")
            colour = {"field": "value", "transform": mapper}
            quads = drawn.quad(*corners, source=cells, fill_color=colour, line_color=colour, line_width=0.7)
            quads.nonselection_glyph = None
            for kind, (ink, dash) in _LINES.items():
                source = self._source(f"{kind}-{name}", "x", "y")
                drawn.line("x", "y", source=source, line_color="white", line_width=4.5)
                drawn.line("x", "y", source=source, line_color=ink, line_width=2.2, line_dash=list(dash))
            dots = self._source(f"apart-{name}", "x", "y")
            drawn.scatter(
                "x", "y", source=dots, size=4, fill_color=_MARKS["apart"], line_color=None, name=f"dots-{name}"
            )
            crosses = self._source(f"failed-{name}", "x", "y")
            drawn.scatter("x", "y", source=crosses, size=7, marker="x", line_color=_MARKS["failed"], line_width=1.5)
            rings = self._source(f"rings-{name}", "x", "y")
            for ink, width in (("white", 3.5), ("#1a1f26", 1.5)):
                drawn.scatter("x", "y", source=rings, size=8, fill_color=None, line_color=ink, line_width=width)
            cursor = self._source(f"cursor-{name}", *corners)
            for ink, width in (("white", 5), ("#ff4d00", 3)):
                drawn.quad(*corners, source=cursor, fill_color=None, line_color=ink, line_width=width)
            bar = self._models.ColorBar(
                color_mapper=mapper, background_fill_color=None, name=f"bar-{name}", width=12, padding=6
            )
            drawn.add_layout(bar, "right")

    def lines(self, measures: int, *, banded: bool) -> None:
        """Make a plot for each measure, with a line for each sweep, that zoom together."""
        shared = self._models.Range1d(0.0, 1.0, name=f"x-range-{self._place}")
        strips = self._source(f"strips-{self._place}", "left", "right")
        for measure in range(measures):
            drawn = self._figure(
                f"line-{self._place}-{measure}", 230, "xpan,xbox_zoom,reset,save,tap", x_range=shared,
                active_drag="xbox_zoom",
            )  # fmt: skip
            for sweep in range(self._sweeps):
                source = self._source(f"curve-{self._place}-{measure}-{sweep}", "x", "y", "low", "high")
                ink = COLOURS[sweep % len(COLOURS)]
                if banded:
                    drawn.varea(
                        "x", "low", "high", source=source, fill_color=ink, fill_alpha=0.25,
                        name=f"band-{self._place}-{measure}-{sweep}",
                    )  # fmt: skip
                stroke = drawn.line(
                    "x", "y", source=source, line_color=ink, line_width=1.6, line_dash=list(dash_of(sweep)),
                    name=f"stroke-{self._place}-{measure}-{sweep}",
                )  # fmt: skip
                dot = drawn.scatter(
                    "x", "y", source=source, size=4.5, fill_color=ink, line_color=None,
                    name=f"dot-{self._place}-{measure}-{sweep}",
                )  # fmt: skip
                rings = self._source(f"rings-{self._place}-{measure}-{sweep}", "x", "y")
                drawn.scatter(
                    "x", "y", source=rings, size=9, fill_color=None, line_color=ink, line_width=1.5,
                    name=f"ring-{self._place}-{measure}-{sweep}",
                )  # fmt: skip
                stroke.nonselection_glyph = dot.nonselection_glyph = None
            strip = drawn.vstrip(x0="left", x1="right", source=strips, fill_alpha=0.0, line_color=None)
            strip.nonselection_glyph = strip.selection_glyph = None
            span = self._models.Span(
                dimension="height", line_color="#ff4d00", line_width=1.5, name=f"here-{self._place}-{measure}"
            )
            drawn.add_layout(span)
            drawn.select(type=self._models.TapTool).renderers = [strip]

    def samples(self) -> None:
        """Make a plot of the distribution, and one of the samples over what was sampled."""
        drawn = self._figure(f"ecdf-{self._place}", 300, "pan,box_zoom,reset,save")
        drawn.yaxis.axis_label = "part of the samples"
        for sweep in range(self._sweeps):
            source = self._source(f"ecdf-{self._place}-{sweep}", "x", "y")
            drawn.step(
                "x", "y", source=source, mode="after", line_color=COLOURS[sweep % len(COLOURS)], line_width=1.8,
                line_dash=list(dash_of(sweep)), name=f"stair-{self._place}-{sweep}",
            )  # fmt: skip
        drawn = self._figure(f"scatter-{self._place}", 300, "pan,box_zoom,reset,save")
        markers = ("circle", "triangle", "square", "diamond")
        for sweep in range(self._sweeps):
            source = self._source(f"scatter-{self._place}-{sweep}", "x", "y")
            drawn.scatter(
                "x", "y", source=source, size=6, fill_color=COLOURS[sweep % len(COLOURS)], fill_alpha=0.7,
                line_color=None, marker=markers[sweep % len(markers)], name=f"spot-{self._place}-{sweep}",
            )  # fmt: skip

    def series(self, panels: int, *, banded: bool) -> None:
        """Make plots over time, with a line for each sweep, or the bands of its samples, that zoom together."""
        shared = self._models.Range1d(0.0, 1.0, name=f"time-range-{self._place}")
        for panel in range(panels):
            drawn = self._figure(
                f"series-{self._place}-{panel}", 240, "xpan,xbox_zoom,reset,save", x_range=shared,
                active_drag="xbox_zoom", x_axis_label="time [s]",
            )  # fmt: skip
            for sweep in range(self._sweeps):
                name = f"{self._place}-{panel}-{sweep}"
                ink = COLOURS[sweep % len(COLOURS)]
                source = self._source(f"signal-{name}", "x", "y", "q0", "q1", "q3", "q4")
                for low, high in (("q0", "q4"), ("q1", "q3")) if banded else ():
                    drawn.varea("x", low, high, source=source, fill_color=ink, fill_alpha=0.2, name=f"{low}-{name}")
                drawn.line(
                    "x", "y", source=source, line_color=ink, line_width=1.4, line_dash=list(dash_of(sweep)),
                    name=f"trace-{name}",
                )  # fmt: skip

    def _figure(self, name: str, height: int, tools: str, **how: Any) -> Any:
        """Make an empty plot."""
        drawn = self._plotting.figure(
            name=name, height=height, sizing_mode="stretch_width", tools=tools,
            background_fill_color=None, border_fill_color=None, outline_line_color=None, min_width=0,
            # by numbers of ours: Bokeh complains where there is nothing to take a range from
            **{"active_drag": None, "x_range": (0.0, 1.0), "y_range": (0.0, 1.0), **how},
        )  # fmt: skip
        drawn.toolbar.logo = None
        self.made.append(drawn)
        return drawn

    def _source(self, name: str, *columns: str) -> Any:
        """Make a source; replaced before anybody sees it, since without a point Bokeh complains of ranges."""
        return self._models.ColumnDataSource({column: [0.0] for column in columns}, name=name)
