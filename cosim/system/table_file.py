"""Tables from CSV files, which say what was taken for what, and are read by the type of what they drive."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from cosim.errors import ScenarioError, suggestion
from cosim.system.compatibility import convert, read_value
from cosim.system.description import Variable
from cosim.system.sheet import MISSING, NOT_MEASURED, Sheet, number_in, read_sheet, time_column, times_in
from cosim.system.signals import FloatArray, Level, Signal, Table
from cosim.system.staircase import Staircase

log = logging.getLogger("cosim")

_T = TypeVar("_T")

GAPS = ("refuse", "hold", "interpolate")
"""The ways to deal with a value that is missing."""


@dataclass(frozen=True)
class Column(Signal):
    """A column of a file over the times of another, read by the type of the variable that it drives.

    Real variables get straight lines between the values; all others hold each value until the next. Made by
    `read_column`.
    """

    kind: ClassVar[str] = "table"

    sheet: Sheet
    column: int
    times: tuple[float, ...]
    unit: str
    factor: float | None
    gaps: str

    @cached_property
    def numbers(self) -> Table:
        """The table of numbers that it is; ScenarioError, with file and line, if it is none."""
        points = [self.sheet.number(line, row, self.column) for line, row in self.sheet.rows]
        times, filled = self._filled(points, "a number", 'gaps = "hold" or "interpolate"')
        factor = 1.0 if self.factor is None else self.factor
        return Table(tuple(times), tuple(point * factor for point in filled), self.unit, self)

    def as_far_as_known(self) -> Table | Column:
        """Return the table of numbers that it is, or if it is none, itself; either may drive any type."""
        try:
            return self.numbers
        except ScenarioError:
            return self  # whose refusal is told if what it drives is Real

    def driving(self, port: str, variable: Variable) -> Signal:
        """Return what it is to a variable; ScenarioError, with file and line, if a value is none of its type's."""
        if variable.type == "Real":
            return self.numbers
        path = self.sheet.path
        if self.factor is not None:
            raise ScenarioError(
                f"table {path}: factor is {self.factor:g}, but {port} is {variable.type}; expected none"
            )
        if self.gaps == "interpolate":
            raise ScenarioError(f"table {path}: gaps is 'interpolate', but {port} is {variable.type}; expected 'hold'")
        if self.unit:
            log.warning("%s is %s; the values of the table in %s are taken as they are", port, variable.type, self.unit)
        known: dict[str, Level | None] = {}
        points: list[Level | None] = []
        for line, row in self.sheet.rows:
            cell = row[self.column] if self.column < len(row) else ""
            if cell not in known:
                known[cell] = self._level(f"table {path}, line {line}: {port}", cell, variable)
            points.append(known[cell])
        times, filled = self._filled(points, "a value", 'gaps = "hold"')
        return Staircase(tuple(times), tuple(filled))

    def _level(self, label: str, cell: str, variable: Variable) -> Level | None:
        """Read a cell as a value of a type other than Real; None where it is missing."""
        plain = cell.strip()
        if variable.type == "String":
            return convert(label, variable, cell) if plain else None
        if plain in variable.items:
            return convert(label, variable, plain)
        number = number_in(plain, self.sheet.decimal)
        if plain.lower() in MISSING or number == NOT_MEASURED:
            return None
        if variable.type == "Boolean" and number in (0.0, 1.0):
            return bool(number)
        whole = variable.type != "Boolean" and number is not None and number.is_integer()
        return convert(label, variable, int(number or 0) if whole else read_value(plain, variable))

    def _filled(self, points: Sequence[_T | None], wanted: str, way: str) -> tuple[list[float], list[_T]]:
        """Do with missing values what was asked for; return times and values."""
        path, missing = self.sheet.path, [number for number, point in enumerate(points) if point is None]
        if missing and self.gaps == "refuse":
            line, row = self.sheet.rows[missing[0]]
            cell = row[self.column].strip() if self.column < len(row) else "nothing"
            raise ScenarioError(
                f"table {path}, line {line}: '{cell}' is not {wanted}; {way} goes on "
                f"over {len(missing)} missing value{'s' if len(missing) > 1 else ''}"
            )
        if len(missing) == len(points):
            whole = self.sheet.names[self.column].whole
            raise ScenarioError(f"table {path}: column '{whole}' holds no value at all")
        kept: list[tuple[float, _T]] = []
        for moment, point in zip(self.times, points, strict=True):
            if point is not None:
                kept.append((moment, point))
            elif self.gaps == "hold" and kept:
                kept.append((moment, kept[-1][1]))
        return [moment for moment, _ in kept], [point for _, point in kept]

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The time of every cell."""
        return tuple(sorted(set(self.times)))

    def values(self, times: FloatArray) -> NDArray[np.generic]:
        """Interpolate; at a jump, return the value after it."""
        return self.numbers.values(times)

    def left_values(self, times: FloatArray) -> NDArray[np.generic]:
        """Interpolate; at a jump, return the value before it."""
        return self.numbers.left_values(times)

    def slopes(self, times: FloatArray) -> FloatArray:
        """Return the slope of the line that starts at or before each time; zero outside the table."""
        return self.numbers.slopes(times)


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
    """Read a table of numbers from a CSV file whose first line names the columns.

    Parameters
    ----------
    path, column, time, unit, factor, separator, decimal, gaps : optional but for the path
        As of `read_column`.

    Returns
    -------
    Table
        Over time, to drive a Real input with.

    Raises
    ------
    ScenarioError
        As `read_column`, and if the column holds something that is not a number; it names the file and the line.
    """
    read = read_column(
        path, column, time=time, unit=unit, factor=factor, separator=separator, decimal=decimal, gaps=gaps
    )
    return read.numbers


def read_column(
    path: Path | str,
    column: str | None = None,
    *,
    time: str | None = None,
    unit: str | None = None,
    factor: float | None = None,
    separator: str | None = None,
    decimal: str = ".",
    gaps: str = "refuse",
) -> Column:
    """Read a column of a CSV file whose first line names the columns, for a variable of any type.

    Parameters
    ----------
    path : Path or str
        The file; UTF-8, or with a warning windows-1252.
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
    Column
        Over time, to drive an input with. When a system is put together, cells are read by the type of the input: as
        numbers, whole numbers, ``true``, ``false``, ``1`` or ``0``, names or numbers of an enumeration's items, or
        text.

    Raises
    ------
    ScenarioError
        If the file cannot be read, lacks a column, has no header, or times that are none; it names the file and the
        line.
    """
    path = Path(path)
    _refuse_options(path, separator, decimal, factor, gaps)
    sheet = read_sheet(path, separator, decimal)
    when, guessed = time_column(sheet, time)
    others = [each for number, each in enumerate(sheet.names) if number != when]
    values = sheet.index(column, others) if column is not None else int(when == 0)
    times = times_in(sheet, when, guessed=bool(guessed))
    name = sheet.names[values]
    by_name = unit is None and factor is None
    own = name.unit if by_name else unit or ""
    guesses = [*sheet.guesses, *guessed]
    times_have = sheet.names[when]
    if times_have.unit and times_have.unit != "s":
        guesses.append(f"the times are in {times_have.unit}, as {times_have.guess} says")
    if own and by_name:
        guesses.append(f"the unit of '{name.whole}' is {own}, as {name.guess} says")
    if column is None and len(others) > 1:
        guesses.append(f"the values are those of '{name.whole}'")
    _tell(sheet, when, values, own, guesses)
    return Column(sheet, values, tuple(times), own, factor, gaps)


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


def _tell(sheet: Sheet, when: int, values: int, unit: str, guesses: list[str]) -> None:
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
