"""Draw maps of numbers over two dimensions, by Bokeh in the reader's browser."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from cosim.errors import require
from cosim.report.lines import packed
from cosim.report.plots import renumbered


def drawn(maps: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return what the script of the page reads.

    Parameters
    ----------
    maps : sequence of mapping
        Each with `axes`, across and up, and `measures`; these have `name`, `unit`, `label` and `values`, of measures
        row by row upwards.
    """
    told = [
        {**each, "measures": [{**measure, "values": packed(measure["values"])} for measure in each["measures"]]}
        for each in maps
    ]
    return {"maps": told, "document": document(maps)}


def document(maps: Sequence[Mapping[str, Any]]) -> Any:
    """Return the maps, without data, as Bokeh's script reads them."""
    models = require("bokeh.models", extra="report", purpose="a report")
    plotting = require("bokeh.plotting", extra="report", purpose="a report")
    encoder = require("bokeh.core.json_encoder", extra="report", purpose="a report")
    palette = require("bokeh.palettes", extra="report", purpose="a report").Viridis256
    made = require("bokeh.document", extra="report", purpose="a report").Document(title="report")
    for place in range(len(maps)):
        drawn = plotting.figure(
            name=f"map-{place}", height=420, sizing_mode="stretch_width", tools="pan,box_zoom,reset,save,tap",
            active_drag=None, background_fill_color=None, border_fill_color=None, outline_line_color=None,
        )  # fmt: skip
        drawn.toolbar.logo = None
        drawn.grid.visible = False
        mapper = models.LinearColorMapper(
            palette=palette, low=0.0, high=1.0, nan_color="#9a9a9a", name=f"colours-{place}"
        )
        cell = {"left": [0.0], "right": [1.0], "bottom": [0.0], "top": [1.0]}
        cells = models.ColumnDataSource({**cell, "value": [0.0]}, name=f"cells-{place}")
        quads = drawn.quad(
            "left", "right", "top", "bottom", source=cells, fill_color={"field": "value", "transform": mapper},
            line_color=None,
        )  # fmt: skip
        quads.nonselection_glyph = None
        cursor = models.ColumnDataSource(cell, name=f"cursor-{place}")
        drawn.quad("left", "right", "top", "bottom", source=cursor, fill_color=None, line_color="#ff4d00", line_width=3)
        drawn.add_layout(models.ColorBar(color_mapper=mapper, background_fill_color=None, name=f"bar-{place}"), "right")
        made.add_root(drawn)
    return json.loads(renumbered(encoder.serialize_json(made.to_json(deferred=False))))
