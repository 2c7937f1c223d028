"""Hand trajectories on to the tools in which people go on computing: xarray, pandas, Parquet, MATLAB, CSV, a notebook.

Units and the account of the run travel along, as far as a format has room for them. What writes a format is imported
when it is asked for. As CSV text, numbers have as many digits as read back to the same bits, and Booleans are 0 and 1.
"""

from __future__ import annotations

import csv
import html
import io
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError, OutputError, UnknownNameError, printable, require, suggestion
from cosim.files import replace_file, why

if TYPE_CHECKING:
    import pandas  # pyright: ignore[reportMissingTypeStubs]
    import xarray

_TIME = "time"
_LONGEST_NAME = 63
"""Of a variable or field in MATLAB."""
_MOST_ROWS = 100
"""Of a table in a notebook; a system may have thousands of variables."""


class Trajectories(Protocol):
    """Trajectories to hand on: those of a `cosim.recording.result.Result`."""

    @property
    def time(self) -> NDArray[np.float64]:
        """Communication points, s, shape (n,)."""
        ...

    @property
    def columns(self) -> Mapping[str, NDArray[Any]]:
        """Values by ``component.variable``, each of shape (n,)."""
        ...

    @property
    def units(self) -> Mapping[str, str]:
        """Unit of each column, empty where there is none."""
        ...

    @property
    def record(self) -> Mapping[str, Any]:
        """Account of how the run was made."""
        ...


def simple_attributes(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is told of a run as netCDF knows attributes too: text and numbers; anything else as JSON."""
    simple = (str, int, float)
    return {
        key: value if isinstance(value, simple) and not isinstance(value, bool) else json.dumps(value, default=str)
        for key, value in record.items()
    }


def to_dataset(result: Trajectories) -> xarray.Dataset:
    """Return a result as `Result.to_xarray` does."""
    xarray = require("xarray", extra="data", purpose="an xarray.Dataset")
    variables = {
        name: ((_TIME,), values, {"units": unit} if (unit := result.units.get(name)) else {})
        for name, values in result.columns.items()
    }
    coordinates = {_TIME: ((_TIME,), result.time, {"units": "s"})}
    return xarray.Dataset(variables, coordinates, simple_attributes(result.record))


def to_dataframe(result: Trajectories) -> pandas.DataFrame:
    """Return a result as `Result.to_dataframe` does."""
    pandas = require("pandas", extra="data", purpose="a pandas.DataFrame")
    frame = pandas.DataFrame(dict(result.columns), index=pandas.Index(result.time, name=_TIME))
    frame.attrs = {"units": dict(result.units), "record": dict(result.record)}
    return frame


def write_parquet(result: Trajectories, path: str | Path) -> None:
    """Write a result as `Result.to_parquet` does."""
    arrow = require("pyarrow", extra="data", purpose="writing Parquet")
    parquet = require("pyarrow.parquet", extra="data", purpose="writing Parquet")
    units = {_TIME: "s", **result.units}
    arrays = {name: arrow.array(values) for name, values in {_TIME: result.time, **result.columns}.items()}
    fields = [
        arrow.field(name, array.type, nullable=False, metadata={"unit": units.get(name, "")})
        for name, array in arrays.items()
    ]
    about = {"record": json.dumps(dict(result.record), default=str)}
    table = arrow.Table.from_arrays(list(arrays.values()), schema=arrow.schema(fields, metadata=about))
    content = io.BytesIO()
    parquet.write_table(table, content)
    _write(Path(path), content.getvalue())


def write_mat(result: Trajectories, path: str | Path) -> None:
    """Write a result as `Result.to_mat` does."""
    matlab = require("scipy.io", extra="data", purpose="writing MAT files")
    names, values = _fields(result.columns), dict[str, Any]()
    units, original = dict[str, Any](), dict[str, Any]()
    for name, (component, variable) in names.items():
        for tree, leaf in ((values, result.columns[name]), (units, result.units.get(name, "")), (original, name)):
            tree.setdefault(component, {})[variable] = leaf
    record = json.dumps(dict(result.record), default=str)
    content = io.BytesIO()
    whole = {**values, _TIME: result.time, "units": units, "names": original, "record": record}
    matlab.savemat(content, whole, long_field_names=True, oned_as="column", do_compression=True)
    _write(Path(path), content.getvalue())


def _fields(columns: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Name each column as MATLAB can, as a field of its component; no two are named alike."""
    taken: dict[str, dict[str, str]] = {"": dict.fromkeys((_TIME, "units", "names", "record"), "")}
    found: dict[str, tuple[str, str]] = {}
    for name in columns:
        component, _, variable = name.partition(".")
        place = _free(component, taken[""])
        found[name] = place, _free(variable, taken.setdefault(place, {}))
    return found


def _free(name: str, taken: dict[str, str]) -> str:
    """Return an identifier for a name that no other name has, and take it."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)
    plain = (plain if plain[:1].isalpha() else f"x{plain}")[:_LONGEST_NAME]
    candidate, number = plain, 1
    while taken.get(candidate, name) != name:
        number += 1
        candidate = f"{plain[: _LONGEST_NAME - 6]}_{number}"
    taken[candidate] = name
    return candidate


def write_csv(
    result: Trajectories,
    path: str | Path,
    columns: Sequence[str] | None = None,
    *,
    decimate: int = 1,
    units: bool = False,
) -> None:
    """Write a result as `Result.to_csv` does."""
    if isinstance(columns, str):
        raise InputError(f"columns is '{columns}'; expected a list of names")
    if isinstance(decimate, bool) or decimate < 1:
        raise InputError(f"decimate is {decimate!r}; expected a whole number >= 1, to write every row or every Nth")
    names = list(result.columns) if columns is None else list(columns)
    for name in names:
        if name not in result.columns:
            raise UnknownNameError(f"'{name}' was not recorded{suggestion(name, result.columns)}")
    known = {_TIME: "s", **result.units}
    heads = [f"{name} [{known[name]}]" if units and known.get(name) else name for name in (_TIME, *names)]
    step = slice(None, None, decimate)
    try:
        with Path(path).open("w", encoding="utf-8", newline="\n") as file:
            csv.writer(file, lineterminator="\n").writerow(heads)
            file.writelines(lines(result.time[step], *(result.columns[name][step] for name in names)))
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {why(error)}") from error


def header(names: Iterable[str]) -> str:
    """Write the first line: ``time``, then the names of the columns, quoted where RFC 4180 asks for it."""
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(["time", *names])
    return line.getvalue()


def lines(times: NDArray[Any], *columns: NDArray[Any]) -> Iterator[str]:
    """Write a line for each row; `repr` of a float is the shortest text that reads back the same."""
    return (",".join(row) + "\n" for row in zip(*map(_texts, (times, *columns)), strict=True))


def _texts(column: NDArray[Any]) -> Iterator[str]:
    """Write each value of a column."""
    if column.dtype == object:
        return map(_quoted, column.tolist())
    return map(repr, column.astype(np.int32).tolist() if column.dtype == np.bool_ else column.tolist())


def _quoted(text: str) -> str:
    """Write a string, quoted where RFC 4180 asks for it."""
    if any(mark in text for mark in ',"\r\n'):
        return '"' + text.replace('"', '""') + '"'
    return text


def to_html(result: Trajectories) -> str:
    """Describe a result as a table, for a notebook; texts are escaped."""
    head = "".join(f"<th>{each}</th>" for each in ("", "unit", "first", "last", "least", "greatest"))
    shown = list(result.columns)[:_MOST_ROWS]
    rows = "".join(f"<tr>{''.join(_cells(result, name))}</tr>" for name in shown)
    left = len(result.columns) - len(shown)
    more = f"<p>and {left} more</p>" if left else ""
    return (
        f"<div><p>{html.escape(repr(result)[1:-1])}</p>"
        f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>{more}</div>"
    )


def _cells(result: Trajectories, name: str) -> Iterator[str]:
    """Write the cells of a column's row."""
    values = result.columns[name]
    yield f'<th style="text-align:left">{html.escape(printable(name))}</th>'
    yield f"<td>{html.escape(printable(result.units.get(name, '')))}</td>"
    for value in _ends(values):
        yield f"<td>{html.escape(printable(value))}</td>"


def _ends(values: NDArray[Any]) -> list[str]:
    """Write the first and the last value, and the least and the greatest where they are numbers."""
    if not values.size:
        return ["", "", "", ""]
    if values.dtype == object or values.dtype == np.bool_:
        return [str(values[0])[:_LONGEST_NAME], str(values[-1])[:_LONGEST_NAME], "", ""]
    return [f"{each:.6g}" for each in (values[0], values[-1], values.min(), values.max())]


def _write(path: Path, content: bytes) -> None:
    """Write a file, which replaces one that is there when it is complete."""
    try:
        replace_file(path, content)
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {why(error)}") from error
