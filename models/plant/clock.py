"""Places on the time axis as a block number and a fraction of the block, so that a delay of whole blocks is exact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

CELL_LIMIT = 0.0005
"""Longest cell of the default grid [s]."""

BLOCK = 8
"""Cells in a block, at most."""

LEAST_BLOCKS = 4
"""Blocks in a travel time, at least."""

SNAP = 1e-11
"""Nearer than this to a boundary, an input change is taken to be at the boundary [blocks]."""


def blocks_for(cells: int) -> int:
    """Return the blocks in a travel time of so many cells."""
    blocks = (cells + BLOCK - 1) // BLOCK
    return blocks if blocks > LEAST_BLOCKS else LEAST_BLOCKS


@dataclass(frozen=True)
class Clock:
    """The grid of blocks.

    Attributes
    ----------
    start : float
        Time of the begin of block 0 [s].
    block : float
        Duration of a block [s].
    """

    start: float
    block: float

    @property
    def coarseness(self) -> float:
        """Length of a block relative to the longest of the default grid: the longer, the more error is allowed."""
        return self.block / (BLOCK * CELL_LIMIT)

    def place(self, time: float) -> tuple[int, float]:
        """Return the block a time lies in and the fraction of it, in (0, 1]; (0, 0) at the start.

        A boundary belongs to the block that ends there, so that values at it are left limits.
        """
        position = (time - self.start) / self.block
        number = int(position)
        fraction = position - number
        if fraction == 0.0 and number > 0:
            return number - 1, 1.0
        return number, fraction

    def time(self, number: int, fraction: float) -> float:
        """Return the time of a place [s]."""
        return self.start + (number + fraction) * self.block


class Ramp(NamedTuple):
    """An input that has a value at a place and changes by a slope [1/s] from there."""

    value: float
    slope: float = 0.0
    block: int = 0
    fraction: float = 0.0

    def over(self, clock: Clock, block: int, begin: float, end: float) -> tuple[float, float]:
        """Return the input at the begin of a piece and its rise over the piece."""
        if self.slope == 0.0:
            return self.value, 0.0
        slope = self.slope * clock.block
        elapsed = (block - self.block) + (begin - self.fraction)
        return self.value + elapsed * slope, (end - begin) * slope
