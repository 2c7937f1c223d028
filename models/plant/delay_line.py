"""A wave under way between the ends of the string: a queue of quartic pieces, one travel time long.

Time is divided into blocks, M to a travel time, so that a piece leaves the queue M blocks after it entered, at the same
place in its block: the delay is exact. A piece lies inside one block. Where nothing happens it is the whole block; a
*break* (a jump of the wave or of its slope at a place on no grid) is simply a boundary between two pieces in a block.

Breaks come back every two travel times, weaker by the reflections. One too weak to matter is folded: its two pieces
become one, with the same first four moments. When many are under way, only the stronger ones are kept.
"""

from __future__ import annotations

from math import ldexp
from typing import Any

from ..numerics.quartic import ZERO, Quartic, flatten, merge, square_integral
from .clock import BLOCK

NEGLIGIBLE = 1e-9
"""Strength below which a break is folded without being counted, on the default grid [rad/s]."""

LEAST_NEGLIGIBLE = 1e-13
MOST_NEGLIGIBLE = 1e-4
"""Bounds to which it falls on fine grids and rises on coarse ones, as the fourth power of the block [rad/s]."""

LEAST_BREAKS = 256
"""Breaks a queue can hold at least; on fine grids it holds one for each cell."""

MOST_BREAKS = 12.5
"""Of these, a queue with more breaks than cells keeps at most so many in the time of a block of the default grid: in a
short string each comes to both ends over and over."""

DOUBLINGS = 40
"""A queue full of breaks keeps only those stronger than the negligible times 2^DOUBLINGS."""

Piece = tuple[float, float, Quartic, float]
"""Begin and end inside the block, in [0, 1], the wave between them [rad/s], the integral of its square, in blocks."""

NOTHING: Piece = (0.0, 0.0, ZERO, 0.0)
"""No piece: it ends where a block begins."""


class DelayLine:
    """First-in first-out queue of pieces with the integral of the squared wave kept up to date.

    Attributes
    ----------
    pieces : list of Piece
        Ring of fixed capacity; `first` is the oldest, `count` are in it.
    breaks : int
        Pieces in the queue that begin inside a block.
    square, square_rest : float
        Integral of the squared wave over the queue, in blocks [rad^2/s^2], and its compensation.
    negligible : float
        Strength below which a break is folded without being counted [rad/s].
    folded : int
        Breaks folded although they were not negligible.
    folded_square : float
        What those folds took from the integral of the square.
    """

    __slots__ = (
        "break_limit",
        "breaks",
        "count",
        "first",
        "folded",
        "folded_square",
        "negligible",
        "pieces",
        "square",
        "square_rest",
    )

    def __init__(self, blocks: int, level: float, coarseness: float) -> None:
        """Fill one travel time with a constant wave `level` [rad/s]."""
        square = coarseness * coarseness
        self.negligible = min(max(NEGLIGIBLE * (square * square), LEAST_NEGLIGIBLE), MOST_NEGLIGIBLE)
        room = max(BLOCK * blocks, LEAST_BREAKS)
        most = max(float(BLOCK * blocks), 1.0 + MOST_BREAKS * (coarseness * blocks))
        self.break_limit = int(min(float(room), most))
        empty: Piece = (0.0, 1.0, (level, 0.0, 0.0, 0.0, 0.0), level * level)
        self.pieces = [empty] * (blocks + 2 + room)
        self.first = 0
        self.count = blocks
        self.breaks = 0
        self.square = blocks * (level * level)
        self.square_rest = 0.0
        self.folded = 0
        self.folded_square = 0.0

    def push(self, begin: float, end: float, wave: Quartic) -> None:
        """Append the next piece, or fold it into the last where the break between them is too weak to keep."""
        if begin > 0.0 and self._fold(begin, end, wave):
            return
        index = self.first + self.count
        if index >= len(self.pieces):
            index -= len(self.pieces)
        square = (end - begin) * square_integral(wave)
        self.pieces[index] = (begin, end, wave, square)
        self.count += 1
        if begin > 0.0:
            self.breaks += 1
        self._add(square)

    def pop(self) -> Piece:
        """Take the oldest piece out."""
        piece = self.pieces[self.first]
        self.first += 1
        if self.first >= len(self.pieces):
            self.first = 0
        self.count -= 1
        if piece[0] > 0.0:
            self.breaks -= 1
        self._add(-piece[3])
        return piece

    def _fold(self, begin: float, end: float, wave: Quartic) -> bool:
        """Fold a piece into the last one if the break between them is weak; say whether it was done."""
        if self.count == 0:
            return False
        last = self.first + self.count - 1
        if last >= len(self.pieces):
            last -= len(self.pieces)
        start, middle, before, former = self.pieces[last]
        if middle != begin:
            return False
        length = end - start
        limit = self.threshold()
        merged, strength = merge(before, wave, (middle - start) / length, limit)
        if strength > limit:
            return False
        if strength > self.negligible:
            # the projection of the two pieces: it adds no energy, and the bit's collocation follows a cubic exactly
            merged = flatten(merged)
            self.folded += 1
        square = length * square_integral(merged)
        added = (end - middle) * square_integral(wave)
        self.pieces[last] = (start, end, merged, square)
        self._add(square - former)
        self.folded_square += (former - square) + added
        return True

    def threshold(self) -> float:
        """Return the strength a break must exceed to be kept: the fuller the queue, the greater [rad/s]."""
        if self.breaks >= self.break_limit:
            return 1e300
        doublings = (2 * DOUBLINGS * self.breaks) // self.break_limit - DOUBLINGS
        return ldexp(self.negligible, doublings) if doublings > 0 else self.negligible

    def _add(self, amount: float) -> None:
        """Add to the integral of the square without losing what the sum cannot hold (Neumaier)."""
        total = self.square + amount
        if abs(self.square) >= abs(amount):
            self.square_rest += (self.square - total) + amount
        else:
            self.square_rest += (amount - total) + self.square
        self.square = total

    def state(self) -> dict[str, Any]:
        """Return everything that changes in time, as plain data."""
        return {name: getattr(self, name) for name in self.__slots__ if name != "pieces"} | {
            "pieces": list(self.pieces)
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Take a state of :meth:`state` back."""
        for name in self.__slots__:
            setattr(self, name, state[name])
        self.pieces = [(p[0], p[1], (p[2][0], p[2][1], p[2][2], p[2][3], p[2][4]), p[3]) for p in state["pieces"]]
