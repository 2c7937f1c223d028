"""Draw what is not known for certain: bands of quantiles over time, and how much each variable has to do with it."""

from __future__ import annotations

import csv
import io
from collections.abc import Generator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cosim.drilling.reporting import NAMES
from cosim.drilling.sensitivity import VARIABLE
from cosim.errors import InputError, printable, suggestion
from cosim.files import replace_file
from cosim.recording.figure import COLOURS, LONGEST_NAME, STYLES, View, blank_figure, finish_row, save_figure
from cosim.system.field_units import shown_in

_FAINTEST, _STRONGEST = 0.18, 0.45
_TIME = "time"
_COLUMNS = ("first", "first_confidence", "total", "total_confidence")
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
        over = [str(name) for name in each.dims if name not in (_TIME, "quantile")]
        if over:
            raise InputError(f"{label} is over {', '.join(over)}; expected a point, as --at {over[0]}=VALUE")
        for name in shown:
            if name not in known:
                raise InputError(f"'{name}' was not kept over time{suggestion(name, known)}")
    save_figure(path, lambda: _compose(found, shown, view))


def _compose(found: Mapping[str, Any], shown: Sequence[str], view: View) -> Any:
    """Lay out the panels: a row for each signal, a column for each store unless they lie over each other.

    Above them stands the point that is shown, which is the nearest one that was kept to that which was asked for.
    """
    columns = 1 if view.overlay else len(found)
    figure = blank_figure(max(7.2, 3.6 * columns), 0.9 + 2.3 * len(shown))
    panels = figure.subplots(len(shown), columns, sharex=True, sharey="row", squeeze=False)
    for row, name in enumerate(shown):
        for number, (label, each) in enumerate(found.items()):
            colour = COLOURS[(number if view.overlay else row) % len(COLOURS)]
            prefix = f"{printable(label)[:LONGEST_NAME]}: " if view.overlay and len(found) > 1 else ""
            _draw(panels[row, 0 if view.overlay else number], each[name], view, colour, prefix)
        finish_row(panels[row], row, name, _unit(found, name), view)
    for panel, (label, each) in zip(panels[0], found.items(), strict=False):
        names = [printable(label)[:LONGEST_NAME]] if columns > 1 else []
        panel.set_title("\n".join([*names, *_point(each, view)]), fontsize=10)
    for panel in panels[-1]:
        panel.set_xlabel("Time [s]")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside lower center", fontsize=8, frameon=False, ncols=min(3, len(labels)))
    return figure


def _point(each: Any, view: View) -> Generator[str]:
    """Go through the values of what varies at the point of some series."""
    for name, held in each.coords.items():
        if held.ndim:
            continue
        unit, factor = shown_in(str(held.attrs.get("units", "")), view.units)
        value = f"{held.item() * factor:.5g} {unit}" if held.dtype.kind == "f" else str(held.item())
        text = view.names.get(str(name).partition(".")[2], str(name))
        yield printable(f"{text}: {value.strip()}")[:LONGEST_NAME]


def _unit(found: Mapping[str, Any], name: str) -> str:
    """Return the unit of a signal."""
    return str(next(iter(found.values()))[name].attrs.get("units", ""))


def _draw(panel: Any, signal: Any, view: View, colour: str, prefix: str) -> None:
    """Draw the bands of a signal, the wider the fainter, and its median; or a line where it has no quantiles."""
    part = view.part(signal[_TIME].values)
    times = signal[_TIME].values[part]
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


def draw_indices(path: Path, found: Mapping[str, Any], units: str = "metric") -> None:
    """Draw Sobol indices into a file: maps of the total ones where they are over a plane, else bars or lines.

    Those of each FMU that takes the place of a component are drawn apart. Of more than two axes of numbers two are
    drawn, drive speed and weight on bit if they are among them, and the others are in their middle; titles tell where.

    Parameters
    ----------
    path : Path
        The file.
    found : mapping of str to xarray.Dataset
        From `cosim.sobol_indices`, by what is above each.
    units : str
        As of `cosim.system.field_units.shown_in`.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    shown_in("", units)
    parts = {title: part for label, each in found.items() for title, part in _drawable(label, each, units)}
    save_figure(path, lambda: _compose_indices(parts, units))


def _drawable(label: str, indices: Any, units: str) -> Generator[tuple[str, Any]]:
    """Take indices apart into what is over two axes of numbers at most, each with a title that tells where it is."""
    numbers = _over(indices)
    indices = indices.sortby(numbers)
    varied = [name for name in numbers if int(indices.sizes[name]) > 1]
    drawn = sorted(varied, key=lambda name: not name.endswith((".Omega", ".WOB")))[:2]
    middle = {name: int(indices.sizes[name]) // 2 for name in numbers if name not in drawn}
    texts = [name for name in _places(indices) if name not in numbers]
    for place in np.ndindex(*(int(indices.sizes[name]) for name in texts)):
        at = {**dict(zip(texts, place, strict=True)), **middle}
        where = ", ".join(_said(indices, name, number, units) for name, number in at.items())
        yield f"{where}: {label}" if where else label, indices.isel(at)


def _said(indices: Any, name: str, number: int, units: str) -> str:
    """Tell the place of indices on an axis."""
    value = indices[name].values[number]
    unit, factor = _shown(indices, name, units)
    told = f"{float(value) * factor:.6g} {unit}".strip() if indices[name].dtype.kind in "fi" else str(value)
    return f"{name} = {told}"


def _compose_indices(found: Mapping[str, Any], units: str) -> Any:
    """Lay out the panels: a row of maps for what is over a plane, and one row of all else."""
    planes = {label: each for label, each in found.items() if len(_over(each)) == 2}
    others = {label: each for label, each in found.items() if label not in planes}
    rows = len(planes) + bool(others)
    widest = max([int(each.sizes[VARIABLE]) for each in planes.values()] + [len(others)])
    figure = blank_figure(max(7.2, 1.0 + 3.2 * widest), 3.3 * rows)
    parts = np.ravel(figure.subfigures(rows, 1, squeeze=False))
    for part, (label, each) in zip(parts, planes.items(), strict=False):
        _draw_planes(part, label, each, units)
    if others:
        panels = parts[-1].subplots(1, len(others), squeeze=False)[0]
        for panel, (label, each) in zip(panels, others.items(), strict=True):
            (_draw_lines if len(_over(each)) == 1 else _draw_bars)(panel, each, units)
            panel.set_title(printable(label)[:LONGEST_NAME], fontsize=10)
            panel.set_ylim(min(0.0, panel.get_ylim()[0]), max(1.0, panel.get_ylim()[1]))
            panel.spines[["top", "right"]].set_visible(False)
        panels[0].set_ylabel("Sobol index")
    return figure


def _over(indices: Any) -> list[str]:
    """Return the dimensions of numbers that indices are over."""
    dims = [str(name) for name in indices["total"].dims if name != VARIABLE]
    return [name for name in dims if name in indices.coords and indices[name].dtype.kind in "fi"]


def _draw_planes(part: Any, label: str, indices: Any, units: str) -> None:
    """Draw total indices as a map for each variable; white where the output does not vary."""
    x, y = sorted(_over(indices), key=lambda name: not name.endswith(".Omega"))
    names: list[str] = indices[VARIABLE].values.tolist()
    panels = part.subplots(1, len(names), sharey=True, squeeze=False)[0]
    shading = None
    for panel, name in zip(panels, names, strict=True):
        values = indices["total"].sel({VARIABLE: name}).transpose(y, x).values
        axes = [indices[each].values * _shown(indices, each, units)[1] for each in (x, y)]
        shading = panel.pcolormesh(*axes, values, cmap="viridis", vmin=0.0, vmax=1.0, shading="nearest")
        panel.set_title(printable(name)[:LONGEST_NAME], fontsize=10)
        panel.set_xlabel(_axis(indices, x, units))
    panels[0].set_ylabel(_axis(indices, y, units))
    part.colorbar(shading, ax=list(panels), label="Total Sobol index", extend="max")
    part.suptitle(printable(label)[:LONGEST_NAME], fontsize=10)


def _draw_lines(panel: Any, indices: Any, units: str) -> None:
    """Draw total indices over what varies, with their confidence intervals."""
    (over,) = _over(indices)
    places = indices[over].values * _shown(indices, over, units)[1]
    for number, name in enumerate(indices[VARIABLE].values.tolist()):
        each = indices.sel({VARIABLE: name})
        total, half = each["total"].values, each["total_confidence"].values
        colour, style = COLOURS[number % len(COLOURS)], STYLES[number // len(COLOURS) % len(STYLES)]
        panel.fill_between(places, total - half, total + half, color=colour, alpha=_FAINTEST, linewidth=0.0)
        panel.plot(places, total, style, color=colour, linewidth=1.2, label=f"{printable(name)[:LONGEST_NAME]}, total")
    panel.set_xlabel(_axis(indices, over, units))
    panel.legend(frameon=False, fontsize=8)


def _draw_bars(panel: Any, indices: Any, units: str) -> None:
    """Draw indices as bars, with their confidence intervals."""
    del units
    names: list[str] = indices[VARIABLE].values.tolist()
    places = np.arange(len(names))
    for shift, kind, label in ((-0.2, "first", "first order"), (0.2, "total", "total")):
        values, half = (indices[name].values for name in (kind, f"{kind}_confidence"))
        colour = COLOURS[shift > 0.0]
        panel.bar(places + shift, values, 0.38, yerr=half, color=colour, alpha=0.8, capsize=2, label=label)
    panel.set_xticks(places, [printable(name)[:LONGEST_NAME] for name in names])
    panel.legend(frameon=False, fontsize=8)


def _shown(indices: Any, name: str, units: str) -> tuple[str, float]:
    """Return the unit in which values of a dimension are shown, and the factor into it."""
    return shown_in(str(indices[name].attrs.get("units", "")), units)


def _axis(indices: Any, name: str, units: str) -> str:
    """Write the label of an axis."""
    text = NAMES.get(name.partition(".")[2], printable(name)[:LONGEST_NAME])
    unit = _shown(indices, name, units)[0]
    return f"{text} [{unit}]" if unit else text


def write_indices(path: Path, found: Mapping[str, Any]) -> None:
    """Write Sobol indices into a CSV file, a line for each variable at each point; SI units.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    places = list(dict.fromkeys(name for each in found.values() for name in _places(each)))
    written = io.StringIO()
    writer = csv.writer(written, lineterminator="\n")
    writer.writerow(["output", *places, VARIABLE, *_COLUMNS, "left_out"])
    for label, each in found.items():
        over = _places(each)
        for place in np.ndindex(*(int(each.sizes[name]) for name in over)):
            at = dict(zip(over, place, strict=True))
            point = each.isel(at)
            where = [each[name].values[at[name]] if name in at else "" for name in places]
            for number, name in enumerate(each[VARIABLE].values.tolist()):
                numbers = [repr(float(point[column].values[number])) for column in _COLUMNS]
                writer.writerow([label, *where, name, *numbers, int(point["left_out"])])
    replace_file(path, written.getvalue().encode())


def _places(indices: Any) -> list[str]:
    """Return the dimensions that indices are over."""
    return [str(name) for name in indices["total"].dims if name != VARIABLE]
