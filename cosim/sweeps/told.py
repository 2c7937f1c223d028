"""Gather what a report says of sweeps over two dimensions: maps, each with a cursor."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cosim.errors import InputError, printable
from cosim.files import why
from cosim.sweeps.reading import open_sweep
from cosim.system.field_units import shown_in

_MOST_POINTS = 40_000
"""Of a map that a browser draws at once."""
_BESIDES = ("failed", "message")


def gather(folders: Sequence[Path], units: str) -> dict[str, Any]:
    """Return what the page of some sweeps shows.

    Raises
    ------
    InputError
        If a store cannot be read, or is not over two dimensions.
    """
    told = [_sweep(folder, units) for folder in dict.fromkeys(folders)]
    titles = list(dict.fromkeys(each["title"] for each in told))
    maps = [each.pop("map") for each in told]
    return {"title": titles[0] if len(titles) == 1 else "Sweeps compared", "sweeps": told, "maps": maps}


def _sweep(folder: Path, units: str) -> dict[str, Any]:
    """Read what a store tells."""
    found = open_sweep(folder)
    try:
        return _told(folder, found, units)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError, OSError, RuntimeError) as error:
        # the last two are those of chunks that cannot be read or unpacked
        what = f"{error} is missing" if isinstance(error, KeyError) else why(error)
        raise InputError(f"{folder} holds a sweep that is damaged: {what}") from error


def _told(folder: Path, found: Any, units: str) -> dict[str, Any]:
    """Return what is said of a sweep, with its map."""
    axes = [str(name) for name in found.sizes]
    points = int(np.prod(list(found.sizes.values())))
    if len(axes) != 2 or any(axis not in found.coords for axis in axes):
        raise InputError(f"{folder} varies over {', '.join(axes) or 'nothing'}; expected a sweep over two dimensions")
    if points > _MOST_POINTS:
        raise InputError(f"{folder} has {points} points; expected {_MOST_POINTS} at most in a report")
    measures = [
        _shown(found[name], str(name), axes[::-1], units)
        for name in found.data_vars
        if name not in _BESIDES and found[name].dtype.kind in "fiu" and found[name].dims
    ]
    record: dict[str, Any] = json.loads(found.attrs["record"])
    failed = np.asarray(found["failed"].values)
    messages = [str(each) for each in found["message"].values[failed == 1]]
    return {
        "title": printable(str(found.attrs["title"] or record["scenario"])),
        "folder": folder.name,
        "map": {
            "axes": [_shown(found[axis], axis, [axis], units) for axis in axes],
            "measures": measures,
        },
        "axes": [_axis(found[axis], axis, units) for axis in axes],
        "measures": [_summary(each) for each in measures],
        "points": points,
        "failed": int(np.sum(failed == 1)),
        "open": int(np.sum(np.isnan(failed))),
        "messages": [printable(each) for each in dict.fromkeys(messages)][:20],
        "record": record,
        "about": {name: str(found.attrs[name]) for name in ("variant", "packaging", "commit", "sha256")},
        "command": _command(found, axes, record),
        "versions": dict(json.loads(found.attrs["versions"])),
        "components": [
            (name, str(each["model"]), str(each["sha256"]), {k: str(v) for k, v in each["parameters"].items()})
            for name, each in record["components"].items()
        ],
    }


def _command(found: Any, axes: Sequence[str], record: Mapping[str, Any]) -> str:
    """Return the command that makes a sweep again, but for values that differ from the scenario's own."""
    words = ["cosim", "sweep", str(record["scenario"])]
    for axis in axes:
        values = np.asarray(found[axis].values, dtype=np.float64)
        even: list[float] = np.linspace(float(values[0]), float(values[-1]), values.size).tolist()
        listed = ",".join(map(repr, values.tolist()))
        spread = f"{float(values[0])!r}:{float(values[-1])!r}:{values.size}"
        words += ["--grid", f"{axis}={spread if values.size > 1 and even == values.tolist() else listed}"]
    options: dict[str, Any] = {
        "packaging": found.attrs["packaging"],
        "variant": found.attrs["variant"],
        "branch": record["branch"],
        "along": record["along"],
    }
    options |= {"algorithm": record["method"]["algorithm"], "step-size": record["step_size"]}
    options |= {"stop-time": record["start_time"] + record["duration"]}
    for name, value in options.items():
        words += [f"--{name}", str(value)] if value != "" else []
    return shlex.join(words)


def _shown(variable: Any, name: str, axes: Sequence[str], units: str) -> dict[str, Any]:
    """Return values in the units that are shown, in the order of the axes; an axis as a list."""
    unit, factor = shown_in(str(variable.attrs.get("units", "")), units)
    values = np.asarray(variable.transpose(*axes).values, dtype=np.float64) * factor
    label = printable(str(variable.attrs.get("long_name", "")))
    told = {"name": printable(name), "unit": printable(unit), "label": label}
    return {**told, "values": values.tolist() if len(axes) == 1 else values.ravel()}


def _axis(variable: Any, name: str, units: str) -> tuple[str, str, str, str, int]:
    """Return name, unit, first and last value of an axis, and how many there are."""
    shown = _shown(variable, name, [name], units)
    values: list[float] = shown["values"]
    return shown["name"], shown["unit"], _number(values[0]), _number(values[-1]), len(values)


def _number(value: float) -> str:
    """Write a number for people."""
    return f"{value:.6g}"


def _summary(measure: Mapping[str, Any]) -> tuple[str, str, str, str, str, str]:
    """Return name, text and unit of a measure, and least, greatest and median of all points that have one."""
    values = measure["values"][np.isfinite(measure["values"])]
    name, label, unit = (str(measure[key]) for key in ("name", "label", "unit"))
    if not values.size:
        return name, label, unit, "-", "-", "-"
    least, greatest, median = float(values.min()), float(values.max()), float(np.median(values))
    return name, label, unit, _number(least), _number(greatest), _number(median)
