"""Places on the time axis as a cell number and a fraction of the cell, so that a delay of N cells is exact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

CELL_LIMIT = 0.0005
"""Longest cell of the default grid [s]."""

SNAP = 1e-11
"""Nearer than this to a boundary, an input change is taken to be at the boundary [cells]."""


@dataclass(frozen=True)
class Clock:
    """The grid of cells.

    Attributes
    ----------
    start : float
        Time of the begin of cell 0 [s].
    cell : float
        Duration of a cell [s].
    """

    start: float
    cell: float

    @property
    def coarseness(self) -> float:
        """How many times the longest cell of the default grid a cell is, at least 1; more error is allowed then."""
        ratio = self.cell / CELL_LIMIT
        return ratio if ratio > 1.0 else 1.0

    def place(self, time: float) -> tuple[int, float]:
        """Return the cell a time lies in and the fraction of it, in (0, 1]; (0, 0) at the start.

        A boundary belongs to the cell that ends there, so that values at it are left limits.
        """
        position = (time - self.start) / self.cell
        number = int(position)
        fraction = position - number
        if fraction == 0.0 and number > 0:
            return number - 1, 1.0
        return number, fraction

    def time(self, number: int, fraction: float) -> float:
        """Return the time of a place [s]."""
        return self.start + (number + fraction) * self.cell


class Ramp(NamedTuple):
    """An input that has a value at a place and changes by a slope [1/s] from there."""

    value: float
    slope: float = 0.0
    cell: int = 0
    fraction: float = 0.0

    def over(self, clock: Clock, cell: int, begin: float, end: float) -> tuple[float, float]:
        """Return the input at the begin of a piece and its rise over the piece."""
        if self.slope == 0.0:
            return self.value, 0.0
        slope = self.slope * clock.cell
        elapsed = (cell - self.cell) + (begin - self.fraction)
        return self.value + elapsed * slope, (end - begin) * slope
