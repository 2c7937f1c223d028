"""Gather what a report says of sweeps, over any number of dimensions; those over the same points belong together."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError, printable
from cosim.files import why
from cosim.sweeps.design import SAMPLES
from cosim.sweeps.reading import HELD, QUANTILES, SAMPLING, SERIES, TIME, open_series, open_sweep, quantile_bands
from cosim.system.field_units import shown_in

MOST_NUMBERS = 280_000
"""Of all maps of a page, 2.7 bytes each."""
_MOST_CELLS = 40_000
"""Of a plane that a browser draws at once."""
MOST_SERIES = 400
"""Lines over time of a page."""
_BESIDES = ("failed", "message")


def gather(folders: Sequence[Path], units: str) -> dict[str, Any]:
    """Return what the page of some sweeps says.

    Returns
    -------
    dict
        `title`, and `sweeps`: each with `found`, the dataset as it is drawn, in the order of its numbers along each
        axis and with fewer points where a page would be too large, and `shown`, what is in it, in the units asked for.

    Raises
    ------
    InputError
        If a store cannot be read.
    """
    places = list(dict.fromkeys(folders))
    told = [_sweep(folder, units, len(places)) for folder in places]
    titles = list(dict.fromkeys(each["title"] for each in told))
    return {"title": titles[0] if len(titles) == 1 else "Sweeps compared", "sweeps": told}


def _sweep(folder: Path, units: str, sweeps: int) -> dict[str, Any]:
    """Read what a store tells."""
    found = open_sweep(folder)
    try:
        return _told(folder, found, units, sweeps)
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError, OSError, RuntimeError) as error:
        # the last two are those of chunks that cannot be read or unpacked
        what = f"{error} is missing" if isinstance(error, KeyError) else why(error)
        raise InputError(f"{folder} holds a sweep that is damaged: {what}") from error


def _told(folder: Path, found: Any, units: str, sweeps: int) -> dict[str, Any]:
    """Return what is said of a sweep, with what is drawn of it."""
    found = found.load()
    names = _measures_of(found)
    record: dict[str, Any] = json.loads(found.attrs["record"])
    failed = np.asarray(found["failed"].values)
    messages = [str(each) for each in found["message"].values[failed == 1]]
    drawn, thinned = _thinned(_in_order(found, found), MOST_NUMBERS // (sweeps * (len(names) + 1)))
    series, fewer = _series(folder, found, units, sweeps)
    return {
        "title": printable(str(found.attrs["title"] or record["scenario"])),
        "folder": folder.name,
        "branch": str(record["branch"]),
        "found": drawn,
        "shown": _contents(drawn, names, units),
        "series": series,
        "thinned": thinned + fewer,
        "samples": _sampled_in(found),
        "sizes": " x ".join(str(size) for size in failed.shape),
        "measures": [_summary(_shown(found[name], name, units)) for name in names],
        "points": failed.size,
        "failed": int(np.sum(failed == 1)),
        "open": int(np.sum(np.isnan(failed))),
        "messages": [printable(each) for each in dict.fromkeys(messages)][:20],
        "record": record,
        "about": {name: str(found.attrs[name]) for name in ("variant", "packaging", "commit", "sha256")},
        "command": _command(found, record),
        "distributions": _distributions(found),
        "held": {printable(name): str(value) for name, value in json.loads(found.attrs.get(HELD, "{}")).items()},
        "versions": dict(json.loads(found.attrs["versions"])),
        "components": [
            (name, str(each["model"]), str(each["sha256"]), {k: str(v) for k, v in each["parameters"].items()})
            for name, each in record["components"].items()
        ],
    }


def _contents(found: Any, measures: Sequence[str], units: str) -> dict[str, Any]:
    """Return what is drawn: values of measures and of what was sampled, the former in the order of axes, then samples.

    `failed` has the places of the points that have.
    """
    axes = _axes_of(found)
    order = [*axes, *([SAMPLES] if SAMPLES in found.sizes else [])]
    failed = np.asarray(found["failed"].transpose(*order).values) == 1
    return {
        "axes": [_axis(found, name, units) for name in axes],
        "samples": [_shown(found[name], name, units) for name in _sampled_in(found)],
        "count": int(found.sizes.get(SAMPLES, 0)),
        "measures": [_shown(found[name].transpose(*order), name, units) for name in measures],
        "failed": np.flatnonzero(failed).tolist(),
    }


def _series(folder: Path, found: Any, units: str, sweeps: int) -> tuple[dict[str, Any] | None, list[str]]:
    """Return what was kept over time, and what of it has been left out, in words.

    Returns
    -------
    dict or None, list of str
        `signals` with names and units; `axes`, the values that are kept of each; `time`; `values` of each signal, over
        the points that are kept and time; of samples, `quantiles`, and `values` over points, quantiles and time; and
        `messages`, why a point has none. None where nothing is kept.
    """
    if SERIES not in found.attrs:
        return None, []
    kept = _in_order(open_series(folder), found)
    signals = [str(name) for name, each in kept.data_vars.items() if TIME in each.dims]
    axes, sampled = _axes_of(found), SAMPLES in found.sizes
    most = max(1, MOST_SERIES // (sweeps * len(signals) * (3 if sampled else 1)))
    whole = int(np.prod([kept.sizes[name] for name in axes]))
    while int(np.prod([kept.sizes[name] for name in axes])) > most:
        kept = kept.isel({max(axes, key=lambda name: kept.sizes[name]): slice(None, None, 2)})
    points = int(np.prod([kept.sizes[name] for name in axes]))
    over = kept
    if sampled:
        over = quantile_bands(folder).sel({name: kept[name] for name in axes})
    order = [*axes, *(["quantile"] if sampled else []), TIME]
    shown = [_shown(over[name].transpose(*order), name, units) for name in signals]
    told = {
        "signals": [{key: each[key] for key in ("name", "unit", "label")} for each in shown],
        "axes": [_axis(kept, name, units) for name in axes],
        "time": np.asarray(kept[TIME].values, dtype=np.float64),
        "quantiles": list(QUANTILES) if sampled else [],
        "values": [each["values"].reshape(points, *([len(QUANTILES)] if sampled else []), -1) for each in shown],
        "messages": [] if sampled else [printable(str(each)) for each in kept["message"].values.ravel()],
    }
    return told, [f"series of {points} of {whole} points"] if points < whole else []


def _axes_of(found: Any) -> list[str]:
    """Return the dimensions of a sweep without that of its samples."""
    return [str(name) for name in found["failed"].dims if name != SAMPLES]


def _sampled_in(found: Any) -> list[str]:
    """Return the names of what was sampled."""
    return sorted(str(name) for name, each in found.coords.items() if each.dims == (SAMPLES,) and name != SAMPLES)


def _measures_of(found: Any) -> list[str]:
    """Return the names of the numbers that were kept of each point."""
    return [
        str(name)
        for name, each in found.data_vars.items()
        if name not in _BESIDES and each.dtype.kind in "fiu" and set(each.dims) == set(found["failed"].dims)
    ]


def _in_order(found: Any, sweep: Any) -> Any:
    """Return what is over the axes of a sweep with the numbers along each in their order."""
    numbers = [name for name in _axes_of(sweep) if sweep[name].dtype.kind in "fiu"]
    return found.sortby(numbers) if numbers else found


def _thinned(found: Any, most: int) -> tuple[Any, list[str]]:
    """Leave points out until a page can hold the others: of samples the last, else every other value of an axis.

    Returns
    -------
    xarray.Dataset, list of str
        What is left, and what has been left out, in words.
    """
    steps = dict.fromkeys(_axes_of(found), 1)
    whole = dict(found.sizes)

    def plane() -> int:
        largest = sorted((found.sizes[name] for name in steps), reverse=True)[:2]
        return int(np.prod(largest)) if len(largest) == 2 else 0

    while int(np.prod(list(found.sizes.values()))) > most or plane() > _MOST_CELLS:
        large = max(found.sizes, key=lambda name: found.sizes[name] if name in steps else found.sizes[name] / 4)
        if large in steps:
            steps[large] *= 2
            found = found.isel({large: slice(None, None, 2)})
        else:
            found = found.isel({large: slice(found.sizes[large] // 2)})
    told = [f"every {step}th value of {printable(name)}" for name, step in steps.items() if step > 2]
    told += [f"every other value of {printable(name)}" for name, step in steps.items() if step == 2]
    if found.sizes.get(SAMPLES) != whole.get(SAMPLES):
        told.append(f"{found.sizes[SAMPLES]} of {whole[SAMPLES]} samples")
    return found, told


def _command(found: Any, record: Mapping[str, Any]) -> str:
    """Return the command that makes a sweep again, but for values that differ from the scenario's own."""
    words = ["cosim", "sweep", str(record["scenario"])]
    for name in _axes_of(found):
        words += ["--grid", f"{name}={_values(found[name].values)}"]
    words += [*_drawn(found), *_keeping(found)]
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


def _drawn(found: Any) -> list[str]:
    """Return how a command draws the samples of a sweep; distributions are in a file, which the page shows."""
    told: dict[str, Any] = json.loads(found.attrs.get(SAMPLING, "null")) or {"from": {}}
    words: list[str] = []
    for name, spread in told["from"].items():
        if not isinstance(spread, dict):
            bounds = spread if isinstance(spread, str) else ":".join(map(repr, spread))
            words += ["--sample", f"{name}={bounds}"]
    if _distributions(found):
        words += ["--uncertain", "uncertain.toml"]
    if told["from"]:
        words += ["--count", str(told["count"]), "--sampling", str(told["method"]), "--seed", str(told["seed"])]
    return words


def _keeping(found: Any) -> list[str]:
    """Return how a command keeps the series of a sweep: as many points of the grid as are kept are those."""
    told: dict[str, Any] | None = json.loads(found.attrs.get(SERIES, "null"))
    if told is None:
        return []
    words = [word for name in told["signals"] for word in ("--keep", str(name))]
    spread = [name for name in _axes_of(found) if found[name].dtype.kind in "fiub"]
    kept = {name: told["points"][name] for name in spread}
    points = math.prod(found.sizes[name] if each == "all" else len(each) for name, each in kept.items())
    return [*words, "--keep-every", repr(told["every"]), "--keep-points", str(points)]


def _distributions(found: Any) -> list[str]:
    """Return the lines of the file of distributions that samples of a sweep were drawn from."""
    told: dict[str, Any] = json.loads(found.attrs.get(SAMPLING, "null")) or {"from": {}}
    spreads: dict[str, dict[str, Any]] = {name: each for name, each in told["from"].items() if isinstance(each, dict)}
    return [
        f'"{printable(name)}" = {{ {", ".join(f"{key} = {json.dumps(value)}" for key, value in spread.items())} }}'
        for name, spread in spreads.items()
    ]


def _values(values: NDArray[Any]) -> str:
    """Write the values of an axis as a command takes them."""
    if values.dtype.kind not in "fiu":
        return ",".join(str(each).lower() if isinstance(each, bool) else str(each) for each in values.tolist())
    listed: list[float] = values.tolist()
    even: list[float] = np.linspace(float(values[0]), float(values[-1]), values.size).tolist()
    spread = f"{float(values[0])!r}:{float(values[-1])!r}:{values.size}"
    return spread if values.size > 1 and even == listed else ",".join(map(repr, listed))


def _shown(variable: Any, name: str, units: str) -> dict[str, Any]:
    """Return values in the units that are shown, with `name`, `unit` and `label`."""
    unit, factor = shown_in(str(variable.attrs.get("units", "")), units)
    label = printable(str(variable.attrs.get("long_name", "")))
    values = np.asarray(variable.values, dtype=np.float64) * factor
    return {"name": printable(name), "unit": printable(unit), "label": label, "values": values}


def _axis(found: Any, name: str, units: str) -> dict[str, Any]:
    """Return name, unit and values of an axis: `texts`, and `values`, which are numbers, else None."""
    variable = found[name]
    if variable.dtype.kind not in "fiu":
        texts = [printable(str(each)) for each in variable.values.tolist()]
        return {"name": printable(name), "unit": "", "values": None, "texts": texts}
    told = _shown(variable, name, units)
    values: list[float] = told["values"].tolist()
    return {"name": told["name"], "unit": told["unit"], "values": values, "texts": [_number(each) for each in values]}


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
