"""The driller's commands over time: one change of rotation and of weight, or a table of both."""

from __future__ import annotations

import re
from codecs import BOM_UTF8
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

AT_ONCE = 1e-9
"""A change within this of a communication point is taken to be at it, relative to max(1, |t|) [s]."""

HEADER = "time,speed,WOB"
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\Z")


class Point(NamedTuple):
    """A value and its derivative from now on [1/s]."""

    value: float
    slope: float


def _late(time: float) -> float:
    return time + AT_ONCE * max(1.0, abs(time))


@dataclass(frozen=True)
class Change:
    """A value that changes once: from `initial` to `final`, from `start` [s] on, in `duration` [s]; 0 is a step."""

    initial: float
    final: float
    start: float = 0.0
    duration: float = 0.0

    def at(self, time: float) -> Point:
        """Return value and derivative from a time [s] on."""
        late = _late(time)
        if late < self.start:
            return Point(self.initial, 0.0)
        if late >= self.start + self.duration:
            return Point(self.final, 0.0)
        slope = (self.final - self.initial) / self.duration
        return Point(self.initial + slope * (time - self.start), slope)


@dataclass(frozen=True)
class Table:
    """Rows of time [s], speed [rad/s] and WOB [N]: straight lines between rows, a jump where two rows share a time."""

    rows: tuple[tuple[float, float, float], ...]

    def at(self, time: float, column: int) -> Point:
        """Return value and derivative of a column (1 or 2) from a time [s] on."""
        late = _late(time)
        last = 0
        for index, row in enumerate(self.rows):
            if row[0] > late:
                break
            last = index
        row = self.rows[last]
        if last + 1 == len(self.rows) or late < row[0]:
            return Point(row[column], 0.0)
        after = self.rows[last + 1]
        slope = (after[column] - row[column]) / (after[0] - row[0])
        return Point(row[column] + slope * (time - row[0]), slope)


def read_table(path: str) -> Table:
    """Read a table from a CSV file with the header ``time,speed,WOB``.

    Raises
    ------
    ValueError
        Naming file, line, what was found and what was expected.
    """
    try:
        lines = Path(path).read_bytes().removeprefix(BOM_UTF8).decode("ascii").splitlines()
    except (OSError, UnicodeDecodeError):
        raise ValueError(f"table {path} cannot be read; expected a CSV file with the header {HEADER}") from None
    if not lines or lines[0].replace(" ", "") != HEADER:
        raise ValueError(f"table {path}, line 1: expected the header {HEADER}")
    rows: list[tuple[float, float, float]] = []
    for number, line in enumerate(lines[1:], start=2):
        if line.strip():
            rows.append(_row(path, number, line, rows))
    if not rows:
        raise ValueError(f"table {path} has no rows; expected at least one")
    return Table(tuple(rows))


def _row(path: str, number: int, line: str, before: list[tuple[float, float, float]]) -> tuple[float, float, float]:
    fields = [field.strip() for field in line.split(",")]
    if len(fields) != 3 or not all(_NUMBER.match(field) for field in fields):
        raise ValueError(f"table {path}, line {number}: expected three numbers")
    time, speed, weight = (float(field) for field in fields)
    if not (abs(time) <= 1e9 and abs(speed) <= 1e4 and 0.0 <= weight <= 1e8):
        raise ValueError(
            f"table {path}, line {number}: expected |time| <= 1e9 s, |speed| <= 1e4 rad/s, 0 <= WOB <= 1e8 N"
        )
    if before and (time < before[-1][0] or (len(before) > 1 and time == before[-2][0])):
        raise ValueError(f"table {path}, line {number}: expected times that do not fall, at most two rows at one time")
    return time, speed, weight
