"""Draw what is not known for certain: bands of quantiles over time, and how much each variable has to do with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cosim.drilling.reporting import NAMES
from cosim.errors import InputError, printable, suggestion
from cosim.recording.figure import COLOURS, LONGEST_NAME, View, blank_figure, finish_row, save_figure
from cosim.sweeps.reading import TIME
from cosim.system.field_units import shown_in

_FAINTEST, _STRONGEST = 0.18, 0.45
_BESIDES = ("samples", "message")


def draw_bands(path: Path, found: Mapping[str, Any], signals: Sequence[str], **how: Any) -> None:
    """Draw signals of sweeps over time into a file: bands between quantiles of samples, or lines.

    Parameters
    ----------
    path : Path
        The file.
    found : mapping of str to xarray.Dataset
        By what tells them apart: from `cosim.quantile_bands` or `cosim.open_series`, at a point, so that nothing but
        time and quantiles is left.
    signals : sequence of str
        What to show, one row of panels each; by default all that the first one has.
    **how
        Times, units, and whether all are drawn over each other, as of `cosim.View`.

    Raises
    ------
    InputError
        If a signal was not kept, or a store is over more than time.
    OSError
        If the file cannot be written.
    """
    first = next(iter(found.values()))
    shown = list(signals) or [str(name) for name in first.data_vars if name not in _BESIDES]
    view = View(shown, names=NAMES, **how)
    for label, each in found.items():
        known = [str(name) for name in each.data_vars if name not in _BESIDES]
        over = [str(name) for name in each.dims if name not in (TIME, "quantile")]
        if over:
            raise InputError(f"{label} is over {', '.join(over)}; expected a point, as --at {over[0]}=VALUE")
        for name in shown:
            if name not in known:
                raise InputError(f"'{name}' was not kept over time{suggestion(name, known)}")
    save_figure(path, lambda: _compose(found, shown, view))


def _compose(found: Mapping[str, Any], shown: Sequence[str], view: View) -> Any:
    """Lay out the panels: a row for each signal, a column for each store unless they lie over each other."""
    columns = 1 if view.overlay else len(found)
    figure = blank_figure(max(7.2, 3.6 * columns), 0.9 + 2.3 * len(shown))
    panels = figure.subplots(len(shown), columns, sharex=True, sharey="row", squeeze=False)
    for row, name in enumerate(shown):
        for number, (label, each) in enumerate(found.items()):
            colour = COLOURS[(number if view.overlay else row) % len(COLOURS)]
            prefix = f"{printable(label)[:LONGEST_NAME]}: " if view.overlay and len(found) > 1 else ""
            _draw(panels[row, 0 if view.overlay else number], each[name], view, colour, prefix)
        finish_row(panels[row], row, name, _unit(found, name), view)
    for panel, label in zip(panels[0], found, strict=False):
        if columns > 1:
            panel.set_title(printable(label)[:LONGEST_NAME], fontsize=10)
    for panel in panels[-1]:
        panel.set_xlabel("Time [s]")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", fontsize=8, frameon=False, ncols=min(3, len(labels)))
    return figure


def _unit(found: Mapping[str, Any], name: str) -> str:
    """Return the unit of a signal."""
    return str(next(iter(found.values()))[name].attrs.get("units", ""))


def _draw(panel: Any, signal: Any, view: View, colour: str, prefix: str) -> None:
    """Draw the bands of a signal, the wider the fainter, and its median; or a line where it has no quantiles."""
    part = view.part(signal[TIME].values)
    times = signal[TIME].values[part]
    values = np.atleast_2d(signal.values * shown_in(str(signal.attrs.get("units", "")), view.units)[1])[:, part]
    if "quantile" not in signal.dims:
        panel.plot(times, values[0], color=colour, linewidth=0.9, label=prefix.removesuffix(": ") or None)
        return
    parts: list[float] = signal["quantile"].values.tolist()
    pairs = len(parts) // 2
    for number in range(pairs):
        low, high = parts[number], parts[-1 - number]
        strength = _FAINTEST + (_STRONGEST - _FAINTEST) * number / max(1, pairs - 1)
        label = f"{prefix}{100.0 * low:g} to {100.0 * high:g} % of the samples"
        edges = values[number], values[-1 - number]
        panel.fill_between(times, *edges, color=colour, alpha=strength, linewidth=0.0, label=label)
    if len(parts) % 2:
        label = f"{prefix}median" if parts[pairs] == 0.5 else f"{prefix}{100.0 * parts[pairs]:g} % lie below"
        panel.plot(times, values[pairs], color=colour, linewidth=1.1, label=label)
