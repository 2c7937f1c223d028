"""Read a CSV file as it comes from the field: header, units in names or below them, cells, and times.

What a file does not say is guessed only where there is one sensible guess, and then told. A file that could be read in
two ways is refused.
"""

from __future__ import annotations

import codecs
import csv
import io
import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, time
from pathlib import Path

from cosim.errors import ScenarioError
from cosim.files import read_file
from cosim.system.field_units import field_unit

MOST_BYTES = 2**30
"""In a file."""
MISSING = ("", "nan", "null", "na", "n/a", "none")
"""What cells hold where a value is missing, in small letters."""
NOT_MEASURED = -999.25
"""What LAS files, and CSV files made from them, hold instead, with any number of noughts (CWLS, LAS 2.0, ~W NULL)."""
_SEPARATORS = (",", ";", "\t")
_NAMES_OF_TIME = ("time", "t", "timestamp", "time stamp", "datetime", "date time", "date/time", "elapsed time")
_NAME_WITH_UNIT = re.compile(r"(?P<name>.*\S)\s*[(\[](?P<unit>[^()\[\]]+)[)\]]")


@dataclass(frozen=True)
class Name:
    """A column as its header has it: the whole, the name alone, its unit, and where that was found."""

    whole: str
    plain: str
    unit: str = ""
    guess: str = ""


@dataclass(frozen=True)
class Sheet:
    """A file of cells.

    Attributes
    ----------
    path : Path
        For messages.
    names : tuple of Name
        Its columns.
    rows : list of (int, list of str)
        Number of the line, and cells.
    decimal : str
        What stands before decimals.
    guesses : tuple of str
        What had to be guessed to read it.
    """

    path: Path
    names: tuple[Name, ...]
    rows: list[tuple[int, list[str]]]
    decimal: str
    guesses: tuple[str, ...]

    def index(self, name: str, known: Sequence[Name]) -> int:
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
        number = number_in(cell, self.decimal)
        if cell.lower() in MISSING or number == NOT_MEASURED:
            return None
        if number is None:
            hint = self._hint(cell)
            raise ScenarioError(f"table {self.path}, line {line}: '{cell}' is not a number{hint}")
        if not math.isfinite(number):
            raise ScenarioError(f"table {self.path}, line {line}: '{cell}' is not a finite number")
        return number

    def _hint(self, cell: str) -> str:
        """Say what else a cell may be."""
        other = "," if self.decimal == "." else "."
        number = number_in(cell, other)
        return "" if number is None else f'; decimal = "{other}" reads it as {number:g}'


def read_sheet(path: Path, separator: str | None, decimal: str) -> Sheet:
    """Read cells and header."""
    try:
        text, guesses = _text(read_file(path, MOST_BYTES))
        chosen = separator or _guessed_separator(text, decimal)
        reader = csv.reader(io.StringIO(text, newline=None), delimiter=chosen, skipinitialspace=True)
        rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ScenarioError(f"table {path}: cannot be read: {error}") from error
    header = [name.strip() for name in rows[0][1]] if rows else []
    if len(header) < 2:
        raise ScenarioError(f"table {path}: the first line must name at least two columns, the time first")
    if all(number_in(cell, decimal) is not None for cell in header):
        raise ScenarioError(f"table {path}, line 1: there are only numbers; expected the names of the columns")
    for name, count in Counter(header).items():
        if name and count > 1:
            raise ScenarioError(
                f"table {path}, line 1: column '{name}' is there {count} times; expected each name once"
            )
    for line, row in rows[1:]:
        if any(cell.strip() for cell in row[len(header) :]):
            raise ScenarioError(
                f"table {path}, line {line}: there are {len(row)} cells; expected {len(header)} at most"
            )
    names, rows = _with_units(header, rows[1:], decimal)
    if not rows:
        raise ScenarioError(f"table {path}: there is no row below the names of the columns; expected at least one")
    told = {"\t": "a tabulator", ";": "a semicolon"}
    if not separator and chosen != ",":
        guesses.append(f"cells are separated by {told[chosen]}")
    return Sheet(path, names, rows, decimal, tuple(guesses))


def _text(content: bytes) -> tuple[str, list[str]]:
    """Decode a file, and say what had to be guessed for it."""
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return content.decode("utf-16"), []
    try:
        return content.decode("utf-8-sig"), []
    except UnicodeDecodeError:
        return content.decode("windows-1252"), ["the file, which is not in UTF-8, is in windows-1252"]


def _guessed_separator(text: str, decimal: str) -> str:
    """Return a comma, or what separates the first line if no comma does."""
    first = next((line for line in text.splitlines() if line.strip()), "")
    usable = [each for each in _SEPARATORS if each != decimal]
    return next((each for each in usable if each in first), usable[0])


def _with_units(
    header: list[str], rows: list[tuple[int, list[str]]], decimal: str
) -> tuple[tuple[Name, ...], list[tuple[int, list[str]]]]:
    """Find the units in names and in a second row of the header, and return the rows below."""
    named = [_NAME_WITH_UNIT.fullmatch(name) for name in header]
    names = [
        Name(name, found["name"], found["unit"].strip(), "its name") if found else Name(name, name)
        for name, found in zip(header, named, strict=True)
    ]
    if not rows or not _holds_units(rows[0][1], decimal):
        return tuple(names), rows
    units = [cell.strip().strip("()[]").strip() for cell in rows[0][1]]
    units += [""] * (len(names) - len(units))
    below = f"line {rows[0][0]}"
    return tuple(
        Name(name.whole, name.plain, unit, below) if unit and not name.unit else name
        for name, unit in zip(names, units, strict=False)
    ), rows[1:]


def _holds_units(row: list[str], decimal: str) -> bool:
    """Tell whether a row is one of units: some are known, and no cell is a time, or a number but 1."""
    cells = [cell.strip() for cell in row if cell.strip()]
    texts = [cell for cell in cells if number_in(cell, decimal) is None]
    if any(cell != "1" for cell in cells if cell not in texts) or any(_clock(cell) is not None for cell in texts):
        return False
    return any(field_unit(cell.strip("()[]").strip()) is not None for cell in texts)


def time_column(sheet: Sheet, given: str | None) -> tuple[int, list[str]]:
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


def times_in(sheet: Sheet, column: int, *, guessed: bool) -> list[float]:
    """Read the times [s], which must not decrease."""
    line, row = sheet.rows[0]
    first = row[column].strip() if column < len(row) else ""
    if number_in(first, sheet.decimal) is None and _clock(first) is not None:
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


def _seconds(sheet: Sheet, name: Name) -> float:
    """Return how many seconds the unit of the times has."""
    if not name.unit:
        return 1.0
    unit, second = field_unit(name.unit), field_unit("s")
    if unit is None or second is None or unit.powers != second.powers:
        raise ScenarioError(f"table {sheet.path}, line 1: '{name.whole}': '{name.unit}' is no unit of time known here")
    return unit.factor


def _clock_times(sheet: Sheet, column: int) -> list[float]:
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


def number_in(cell: str, decimal: str) -> float | None:
    """Read a number, if a cell is one; the Python underscore is none of a number's characters."""
    text = cell.strip()
    if "_" in text or (decimal == "," and "." in text):
        return None
    try:
        return float(text.replace(",", ".") if decimal == "," else text)
    except ValueError:
        return None
