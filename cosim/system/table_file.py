"""Tables from CSV files as they come from the field: with units in names or below them, clock times, and gaps.

What a file does not say is guessed only where there is one sensible guess, and then said. A file that could be read in
two ways is refused.
"""

from __future__ import annotations

import csv
import logging
import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, time
from pathlib import Path

from cosim.errors import ScenarioError, suggestion
from cosim.files import read_file
from cosim.system.field_units import field_unit
from cosim.system.signals import Table

log = logging.getLogger("cosim")

MOST_BYTES = 2**30
"""In a file."""
GAPS = ("refuse", "hold", "interpolate")
"""The ways to deal with a value that is missing."""
_SEPARATORS = (",", ";", "\t")
_NAMES_OF_TIME = ("time", "t", "timestamp", "time stamp", "datetime", "date time", "date/time", "elapsed time")
# -999.25 is what LAS files, and CSV files made from them, hold where nothing was measured (CWLS, LAS 2.0, ~W NULL).
_MISSING = ("", "nan", "null", "na", "n/a", "none", "-999.25")
_NAME_WITH_UNIT = re.compile(r"(?P<name>.*\S)\s*[(\[](?P<unit>[^()\[\]]+)[)\]]")


@dataclass(frozen=True)
class _Name:
    """A column as its header has it: the whole, the name alone, its unit, and where that was found."""

    whole: str
    plain: str
    unit: str = ""
    guess: str = ""


@dataclass(frozen=True)
class _Sheet:
    """A file of cells.

    Attributes
    ----------
    path : Path
        For messages.
    names : tuple of _Name
        Its columns.
    rows : list of (int, list of str)
        Number of the line, and cells.
    decimal : str
        What stands before decimals.
    guesses : tuple of str
        What had to be guessed to read it.
    """

    path: Path
    names: tuple[_Name, ...]
    rows: list[tuple[int, list[str]]]
    decimal: str
    guesses: tuple[str, ...]

    def index(self, name: str, known: Sequence[_Name]) -> int:
        """Return the number of a column, by its name with or without the unit; or refuse the name."""
        found = [number for number, each in enumerate(self.names) if name == each.whole]
        found = found or [number for number, each in enumerate(self.names) if name == each.plain]
        if len(found) == 1 and self.names[found[0]] in known:
            return found[0]
        if len(found) > 1:
            both = " and ".join(f"'{self.names[number].whole}'" for number in found)
            raise ScenarioError(f"table {self.path}, line 1: column '{name}' may be {both}; expected one of them")
        names = ", ".join(each.whole for each in known)
        raise ScenarioError(f"table {self.path}: there is no column '{name}'; known: {names}")

    def number(self, line: int, row: list[str], column: int) -> float | None:
        """Read a cell; None where the value is missing."""
        cell = row[column].strip() if column < len(row) else ""
        if cell.lower() in _MISSING:
            return None
        number = _number(cell, self.decimal)
        if number is None:
            hint = self._hint(cell)
            raise ScenarioError(f"table {self.path}, line {line}: '{cell}' is not a number{hint}")
        if not math.isfinite(number):
            raise ScenarioError(f"table {self.path}, line {line}: '{cell}' is not a finite number")
        return number

    def _hint(self, cell: str) -> str:
        """Say what else a cell may be."""
        other = "," if self.decimal == "." else "."
        return "" if _number(cell, other) is None else f'; decimal = "{other}" reads it'


def read_table(
    path: Path | str,
    column: str | None = None,
    *,
    time: str | None = None,
    unit: str | None = None,
    factor: float | None = None,
    separator: str | None = None,
    decimal: str = ".",
    gaps: str = "refuse",
) -> Table:
    """Read a table from a CSV file whose first line names the columns.

    Parameters
    ----------
    path : Path or str
        The file; UTF-8.
    column : str, optional
        Name of the column that holds the values, with or without the unit in it; by default the first that is not the
        time.
    time : str, optional
        Name of the column that holds the times: numbers, in s or in the unit that the header gives, or clock times by
        ISO 8601, counted from the first. By default the one that is called time, or else the first, if it rises.
    unit : str, optional
        Unit of the values; by default the one in the name, as in ``WOB (klbf)``, or in a second row of the header.
        When a system is put together, values are converted to the unit that the input declares.
    factor : float, optional
        What the values are multiplied by. They are then in `unit`, or if there is none, in the input's own.
    separator, decimal : str
        What stands between cells, by default a comma, a semicolon or a tabulator; and before decimals.
    gaps : str
        What to do where a value is missing: ``"refuse"``; ``"hold"``, the last value; or ``"interpolate"``.

    Returns
    -------
    Table
        Over time, to drive an input with.

    Raises
    ------
    ScenarioError
        If the file cannot be read, lacks a column, has no header, or holds something that is not a number; it names
        the file and the line.
    """
    path = Path(path)
    _refuse_options(path, separator, decimal, factor, gaps)
    sheet = _sheet(path, separator, decimal)
    when, guessed = _time_column(sheet, time)
    others = [each for number, each in enumerate(sheet.names) if number != when]
    values = sheet.index(column, others) if column is not None else int(when == 0)
    times = _times(sheet, when, guessed=bool(guessed))
    points = [sheet.number(line, row, values) for line, row in sheet.rows]
    times, filled = _filled(sheet, values, times, points, gaps)
    name = sheet.names[values]
    by_name = unit is None and factor is None
    own = name.unit if by_name else unit or ""
    guesses = [*sheet.guesses, *guessed]
    if own and by_name:
        guesses.append(f"the unit of '{name.whole}' is {own}, as {name.guess} says")
    if column is None and len(others) > 1:
        guesses.append(f"the values are those of '{name.whole}'")
    _tell(sheet, when, values, own, guesses)
    return Table(tuple(times), tuple(point * (1.0 if factor is None else factor) for point in filled), own)


def _refuse_options(path: Path, separator: str | None, decimal: str, factor: float | None, gaps: str) -> None:
    """Refuse options that make no sense."""
    if separator is not None and (len(separator) != 1 or separator in '"\r\n'):
        raise ScenarioError(f"table {path}: separator is {separator!r}; expected one character")
    if decimal not in (".", ","):
        raise ScenarioError(f'table {path}: decimal is {decimal!r}; expected "." or ","')
    if separator == decimal:
        raise ScenarioError(f"table {path}: separator and decimal are both {decimal!r}; expected two that differ")
    if factor is not None and (not math.isfinite(factor) or factor == 0.0):
        raise ScenarioError(f"table {path}: factor is {factor:g}; expected a finite number other than 0")
    if gaps not in GAPS:
        raise ScenarioError(f"table {path}: gaps is '{gaps}'{suggestion(gaps, GAPS)}")


def _sheet(path: Path, separator: str | None, decimal: str) -> _Sheet:
    """Read cells and header."""
    try:
        text = read_file(path, MOST_BYTES).decode("utf-8-sig").replace("\r\n", "\n")
        chosen = separator or _guessed_separator(text, decimal)
        reader = csv.reader(text.splitlines(keepends=True), delimiter=chosen, skipinitialspace=True)
        rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ScenarioError(f"table {path}: cannot be read: {error}") from error
    header = [name.strip() for name in rows[0][1]] if rows else []
    if len(header) < 2:
        raise ScenarioError(f"table {path}: the first line must name at least two columns, the time first")
    if all(_number(cell, decimal) is not None for cell in header):
        raise ScenarioError(f"table {path}, line 1: there are only numbers; expected the names of the columns")
    for name, count in Counter(header).items():
        if name and count > 1:
            raise ScenarioError(
                f"table {path}, line 1: column '{name}' is there {count} times; expected each name once"
            )
    names, rows = _with_units(header, rows[1:], decimal)
    if not rows:
        raise ScenarioError(f"table {path}: there is no row below the names of the columns; expected at least one")
    told = {"\t": "a tabulator", ";": "a semicolon"}
    guesses = () if separator or chosen == "," else (f"cells are separated by {told[chosen]}",)
    return _Sheet(path, names, rows, decimal, guesses)


def _guessed_separator(text: str, decimal: str) -> str:
    """Return a comma, or what separates the first line if no comma does."""
    first = next((line for line in text.splitlines() if line.strip()), "")
    usable = [each for each in _SEPARATORS if each != decimal]
    return next((each for each in usable if each in first), usable[0])


def _with_units(
    header: list[str], rows: list[tuple[int, list[str]]], decimal: str
) -> tuple[tuple[_Name, ...], list[tuple[int, list[str]]]]:
    """Find the units in names and in a second row of the header, and return the rows below."""
    named = [_NAME_WITH_UNIT.fullmatch(name) for name in header]
    names = [
        _Name(name, found["name"], found["unit"].strip(), "its name") if found else _Name(name, name)
        for name, found in zip(header, named, strict=True)
    ]
    if not rows or not _holds_units(rows[0][1], decimal):
        return tuple(names), rows
    units = [cell.strip().strip("()[]").strip() for cell in rows[0][1]]
    units += [""] * (len(names) - len(units))
    below = f"line {rows[0][0]}"
    return tuple(
        _Name(name.whole, name.plain, unit, below) if unit and not name.unit else name
        for name, unit in zip(names, units, strict=False)
    ), rows[1:]


def _holds_units(row: list[str], decimal: str) -> bool:
    """Tell whether a row is one of units: some are known, and no cell is a time, or a number but 1."""
    cells = [cell.strip() for cell in row if cell.strip()]
    texts = [cell for cell in cells if _number(cell, decimal) is None]
    if any(cell != "1" for cell in cells if cell not in texts) or any(_clock(cell) is not None for cell in texts):
        return False
    return any(field_unit(cell.strip("()[]").strip()) is not None for cell in texts)


def _time_column(sheet: _Sheet, given: str | None) -> tuple[int, list[str]]:
    """Return the number of the column of times, and what had to be guessed."""
    if given is not None:
        return sheet.index(given, sheet.names), []
    called = [number for number, name in enumerate(sheet.names) if _is_called_time(name.plain)]
    if len(called) > 1:
        both = " and ".join(f"'{sheet.names[number].whole}'" for number in called)
        raise ScenarioError(f"table {sheet.path}, line 1: {both} may both be the time; expected time = one of them")
    if called:
        return called[0], []
    return 0, [f"the time is in the first column, '{sheet.names[0].whole}'"]


def _is_called_time(name: str) -> bool:
    """Tell whether a column is that of the times by its name."""
    return name.lower().replace("_", " ") in _NAMES_OF_TIME


def _times(sheet: _Sheet, column: int, *, guessed: bool) -> list[float]:
    """Read the times [s], which must not decrease."""
    line, row = sheet.rows[0]
    first = row[column].strip() if column < len(row) else ""
    if _number(first, sheet.decimal) is None and _clock(first) is not None:
        times = _clock_times(sheet, column)
    else:
        second = _seconds(sheet, sheet.names[column])
        times: list[float] = []
        for line, row in sheet.rows:
            number = sheet.number(line, row, column)
            if number is None:
                raise ScenarioError(f"table {sheet.path}, line {line}: the time is missing; expected a number")
            times.append(number * second)
    for index, (line, _) in enumerate(sheet.rows[1:], 1):
        if times[index] < times[index - 1]:
            if guessed:
                name = sheet.names[column].whole
                raise ScenarioError(
                    f"table {sheet.path}, line {line}: no column is called time, and the first, '{name}', does not "
                    "rise; expected time = the name of the column"
                )
            raise ScenarioError(f"table {sheet.path}, line {line}: times must not decrease, as this one does")
        if index > 1 and times[index] == times[index - 2]:
            raise ScenarioError(f"table {sheet.path}, line {line}: this time is given more than twice")
    return times


def _seconds(sheet: _Sheet, name: _Name) -> float:
    """Return how many seconds the unit of the times has."""
    if not name.unit:
        return 1.0
    unit, second = field_unit(name.unit), field_unit("s")
    if unit is None or second is None or unit.powers != second.powers:
        raise ScenarioError(f"table {sheet.path}, line 1: '{name.whole}': '{name.unit}' is no unit of time known here")
    return unit.factor


def _clock_times(sheet: _Sheet, column: int) -> list[float]:
    """Read clock times, and count seconds from the first."""
    moments: list[datetime] = []
    for line, row in sheet.rows:
        cell = row[column].strip() if column < len(row) else ""
        moment = _clock(cell)
        if moment is None:
            raise ScenarioError(f"table {sheet.path}, line {line}: '{cell}' is not a time by ISO 8601")
        if moments and (moment.tzinfo is None) is not (moments[0].tzinfo is None):
            raise ScenarioError(
                f"table {sheet.path}, line {line}: '{cell}' and the first time are not both with a time zone, or both "
                "without"
            )
        moments.append(moment)
    return [(moment - moments[0]).total_seconds() for moment in moments]


def _clock(cell: str) -> datetime | None:
    """Read a date and time, or a time of day, by ISO 8601."""
    if ":" not in cell and "T" not in cell:
        return None
    try:
        return datetime.fromisoformat(cell)
    except ValueError:
        try:
            return datetime.combine(datetime(2000, 1, 1, tzinfo=UTC).date(), time.fromisoformat(cell))
        except ValueError:
            return None


def _filled(
    sheet: _Sheet, column: int, times: list[float], points: list[float | None], gaps: str
) -> tuple[list[float], list[float]]:
    """Do with missing values what was asked for; return times and values."""
    missing = [number for number, point in enumerate(points) if point is None]
    if missing and gaps == "refuse":
        line, row = sheet.rows[missing[0]]
        cell = row[column].strip() if column < len(row) else "nothing"
        raise ScenarioError(
            f'table {sheet.path}, line {line}: \'{cell}\' is not a number; gaps = "hold" or "interpolate" goes on '
            f"over {len(missing)} missing value{'s' if len(missing) > 1 else ''}"
        )
    if len(missing) == len(points):
        raise ScenarioError(f"table {sheet.path}: column '{sheet.names[column].whole}' holds no value at all")
    kept: list[tuple[float, float]] = []
    for moment, point in zip(times, points, strict=True):
        if point is not None:
            kept.append((moment, point))
        elif gaps == "hold" and kept:
            kept.append((moment, kept[-1][1]))
    return [moment for moment, _ in kept], [point for _, point in kept]


def _tell(sheet: _Sheet, when: int, values: int, unit: str, guesses: list[str]) -> None:
    """Say what was taken for what, as a warning if something was guessed."""
    if guesses:
        log.warning("table %s: taken as follows: %s", sheet.path, "; ".join(guesses))
        return
    log.info(
        "table %s: times from '%s', values from '%s' in %s",
        sheet.path,
        sheet.names[when].whole,
        sheet.names[values].whole,
        unit or "the unit of the input",
    )


def _number(cell: str, decimal: str) -> float | None:
    """Read a number, if a cell is one; the Python underscore is none of a number's characters."""
    text = cell.strip()
    if "_" in text or (decimal == "," and "." in text):
        return None
    try:
        return float(text.replace(",", ".") if decimal == "," else text)
    except ValueError:
        return None
