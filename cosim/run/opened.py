"""Open the folder of a run that is finished: each variant as the result that `cosim.simulate` had returned."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError, suggestion
from cosim.files import read_file, why
from cosim.recording.result import Result, finished_result
from cosim.run.report import MANIFEST, UNFINISHED, read_content
from cosim.run.trajectory import open_trajectory
from cosim.run.zarr_layout import TRAJECTORY

_MOST_BYTES = 2**34
"""In a CSV file."""
_SPECIAL = {"inf", "-inf", "nan"}


def open_run(folder: str | Path, variant: str | None = None) -> Result:
    """Open a run that was written to a folder.

    Parameters
    ----------
    folder : str or Path
        Of a finished run, as `cosim run` writes it; streamed or not.
    variant : str, optional
        Which of its variants; needed where there are several.

    Returns
    -------
    Result
        Its trajectories, all of them in memory; `open_trajectory` reads a streamed one as it is asked for. Its record
        is what the manifest tells, with measures and energy.

    Raises
    ------
    InputError
        If the folder holds no finished run, or no such variant, or its files are not as they were written.
    """
    entries = _entries(folder)
    if variant is None and len(entries) > 1:
        names = ", ".join(f"'{name}'" for name in entries)
        raise InputError(f"{folder} holds the variants {names}; expected the name of one, or open_variants for all")
    if variant is not None and variant not in entries:
        raise InputError(f"{folder} holds no variant '{variant}'{suggestion(variant, entries)}")
    return _opened(Path(folder), entries[variant] if variant is not None else next(iter(entries.values())))


def open_variants(folder: str | Path) -> dict[str, Result]:
    """Open all variants of a run that was written to a folder.

    Parameters
    ----------
    folder : str or Path
        Of a finished run.

    Returns
    -------
    dict of str to Result
        By name of variant; by the scenario's, where it has none.

    Raises
    ------
    InputError
        As `open_run` does.
    """
    return {name: _opened(Path(folder), entry) for name, entry in _entries(folder).items()}


def _entries(folder: str | Path) -> dict[str, Mapping[str, Any]]:
    """Return what the manifest tells of all variants, by name; of a scenario without, by the name of that."""
    content = read_content(Path(folder))
    if content is None:
        raise InputError(f"{folder} holds no run; expected a folder with a {MANIFEST}")
    if content.get("state") == UNFINISHED:
        raise InputError(f"{folder} holds an unfinished run; expected a finished one: cosim resume {folder}")
    try:
        head = {name: content[name] for name in ("scenario", "title", "created", "versions")}
        head["commit"] = content.get("commit")
        found: dict[str, Mapping[str, Any]] = {
            str(entry["variant"] or content["scenario"]): {**head, **entry} for entry in content["variants"]
        }
    except (KeyError, TypeError) as error:
        raise InputError(f"{folder}: {MANIFEST} is damaged: {why(error)} is missing") from error
    if not found:
        raise InputError(f"{folder}: {MANIFEST} is damaged: it tells of no variant")
    return found


def _opened(folder: Path, entry: Mapping[str, Any]) -> Result:
    """Read the trajectory of a variant."""
    record = {name: value for name, value in entry.items() if name not in ("trajectory", "units", "types", "figure")}
    try:
        path = folder / str(entry["trajectory"])
        units: dict[str, str] = dict(entry["units"])
        types: dict[str, str] = dict(entry.get("types", {}))
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{folder}: {MANIFEST} is damaged: {why(error)} is missing") from error
    if ".." in path.relative_to(folder).parts or not path.resolve().is_relative_to(folder.resolve()):
        raise InputError(f"{folder}: {MANIFEST} leads out of the folder, to {path}")
    if path.name == TRAJECTORY:
        return _of_zarr(path, record)
    times, columns = _of_csv(path, types)
    steps = entry.get("steps")
    if set(units) == set(columns) and isinstance(steps, int) and times.size != steps + 1:
        raise InputError(f"{path} has {times.size} rows; {MANIFEST} tells of {steps + 1}")
    return finished_result(times, columns, {name: units.get(name, "") for name in columns}, record)


def _of_zarr(path: Path, record: Mapping[str, Any]) -> Result:
    """Read a streamed trajectory, all columns of which are stored for the same rows."""
    with open_trajectory(path) as found:
        axes = [str(name) for name in found.sizes]
        if len(axes) > 1:
            raise InputError(
                f"{path}: columns are stored over {', '.join(axes)}, and a result has one time axis; "
                "cosim.open_trajectory reads them"
            )
        columns = {str(name): np.asarray(values.values) for name, values in found.data_vars.items()}
        units = {str(name): str(values.attrs.get("units", "")) for name, values in found.data_vars.items()}
        return finished_result(np.array(found[axes[0]].values), columns, units, record)


def _of_csv(path: Path, types: Mapping[str, str]) -> tuple[NDArray[np.float64], dict[str, NDArray[Any]]]:
    """Read a file that `Result.to_csv` has written."""
    try:
        text = read_file(path, _MOST_BYTES, follow=False).decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path} cannot be read: {why(error)}") from error
    try:
        rows = csv.reader(io.StringIO(text, newline=""), strict=True)
        names = next(rows)
        first = next(rows)
        kinds = [_type(cell, types.get(name)) for name, cell in zip(names, first, strict=True)]
        values = _numbers(text, kinds) if object not in kinds else _cells([first, *rows], kinds)
    except StopIteration:
        raise InputError(f"{path} is not as it was written: rows are missing") from None
    except (csv.Error, ValueError, OverflowError) as error:
        raise InputError(f"{path} is not as it was written: {why(error)}") from error
    if names[0] != "time" or len(set(names)) < len(names):
        raise InputError(f"{path} is not as it was written: its first column is '{names[0]}'; expected time")
    return values[0], dict(zip(names[1:], values[1:], strict=True))


def _type(cell: str, told: str | None) -> Any:
    """Return the type of a column, as the manifest tells it, or else as its first number is written."""
    known: dict[str, Any] = {"float64": np.float64, "int32": np.int32, "bool": np.bool_, "object": object}
    if told is not None:
        return known.get(told, object)
    if cell in _SPECIAL or (any(mark in cell for mark in ".e") and _is_number(cell)):
        return np.float64
    return np.int32 if _is_number(cell) else object


def _is_number(cell: str) -> bool:
    """Tell whether a cell is a number."""
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _numbers(text: str, kinds: list[Any]) -> list[NDArray[Any]]:
    """Read rows of numbers, fast."""
    whole = [(f"{place}", np.int32 if kind is np.bool_ else kind) for place, kind in enumerate(kinds)]
    table = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=_lines_of_header(text), dtype=whole, comments=None)
    table = np.atleast_1d(table)
    return [table[f"{place}"].astype(kind) for place, kind in enumerate(kinds)]


def _lines_of_header(text: str) -> int:
    """Count the lines of the header, in which a name may have several."""
    rows = csv.reader(io.StringIO(text, newline=""), strict=True)
    next(rows)
    return rows.line_num


def _cells(rows: list[list[str]], kinds: list[Any]) -> list[NDArray[Any]]:
    """Read rows of numbers and strings."""
    columns = list(zip(*rows, strict=True))
    read = {np.float64: float, np.int32: int, np.bool_: int, object: str}
    return [np.array(list(map(read[kind], column)), dtype=kind) for kind, column in zip(kinds, columns, strict=True)]
