"""Thin lines out for a page: few points, no extreme lost, and as little text as they need.

A line is cut into pieces of equal numbers of rows, and of each piece the first, the least, the greatest and the last
value are kept, so that a screen shows what it had shown of all of them (Jugel et al., M4, 2014). Times and values are
written in 65,535 parts of the range that they have.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.system.signals import FloatArray

_PARTS = 65535
_FAR = 300.0
"""How much larger than nine tenths of the others numbers may be, for a part of the range to be small beside those."""
_OF_A_PIECE = 4
"""Points that are kept of each piece."""


@dataclass(frozen=True)
class Line:
    """A line of a plot, and what a table says of it.

    Attributes
    ----------
    times, values : ndarray, shape (n,)
        What is drawn; NaN where there is no number.
    first, last, least, greatest : float
        Of all values.
    """

    times: FloatArray
    values: FloatArray
    first: float
    last: float
    least: float
    greatest: float

    def to_json(self) -> dict[str, Any]:
        """Return what the script of the page reads."""
        return {"x": packed(self.times), "y": packed(self.values), "n": self.times.size}


def line(times: FloatArray, values: NDArray[Any], most: int, factor: float = 1.0) -> Line | None:
    """Return a line with so many points at most.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Increasing.
    values : ndarray, shape (n,)
        Numbers or truth values.
    most : int
        Points to keep; a constant takes two.
    factor : float
        By which values are multiplied to be shown.

    Returns
    -------
    Line or None
        None of strings, or where there is no row.
    """
    if values.dtype == object or not values.size:
        return None
    numbers = values.astype(np.float64) * factor
    finite = numbers[np.isfinite(numbers)]
    least, greatest = (float(finite.min()), float(finite.max())) if finite.size else (np.nan, np.nan)
    rows = kept_rows(numbers, most)
    ends = float(numbers[0]), float(numbers[-1])
    return Line(times[rows], np.where(np.isfinite(numbers), numbers, np.nan)[rows], *ends, least, greatest)


def kept_rows(values: FloatArray, most: int) -> NDArray[np.intp]:
    """Return the rows to draw, increasing: all that fit, or the first, extremes and last of pieces."""
    count = values.size
    if count > 1 and bool(np.all(values == values[0])):
        return np.array([0, count - 1])
    if count <= most:
        return np.arange(count)
    edges = np.linspace(0, count, max(1, most // _OF_A_PIECE) + 1).astype(np.intp)
    # NaN is no extreme; a piece of nothing else keeps its ends, and so the gap
    low, high = np.where(np.isfinite(values), values, np.inf), np.where(np.isfinite(values), values, -np.inf)
    kept: list[int] = []
    for begin, end in pairwise(edges.tolist()):
        kept += [begin, end - 1, begin + int(low[begin:end].argmin()), begin + int(high[begin:end].argmax())]
    return np.unique(np.array(kept, dtype=np.intp))


def packed(values: FloatArray) -> list[Any]:
    """Write numbers: the least, the size of a part, and how many parts each is above the least; 65,535 is none."""
    known = np.isfinite(values)
    least, greatest = (float(values[known].min()), float(values[known].max())) if known.any() else (0.0, 0.0)
    part = (greatest / (_PARTS - 1)) - (least / (_PARTS - 1))
    parts = np.full(values.shape, _PARTS, dtype="<u2")
    if part > 0.0:
        parts[known] = np.rint((values[known] - least) / part).clip(0, _PARTS - 1)
    else:
        parts[known] = 0
    return [least, part, base64.b64encode(parts.tobytes()).decode()]


def packed_fully(values: FloatArray) -> list[Any]:
    """Write numbers, those of 32 bits after None twice where few are so large that the others were hardly a part."""
    known = np.abs(values[np.isfinite(values) & (values != 0.0)])
    if known.size and float(known.max()) > _FAR * float(np.quantile(known, 0.9, method="lower")):
        known = np.where(np.isfinite(values), values, np.nan).astype("<f4")
        return [None, None, base64.b64encode(known.tobytes()).decode()]
    return packed(values)


def shares(names: Sequence[str], shown: Sequence[str], runs: int, most: int) -> dict[str, int]:
    """Share points out among signals: those shown at first have more; signals that would have none are left out.

    Parameters
    ----------
    names, shown : sequence of str
        All signals, and those shown at first.
    runs : int
        Lines that each signal has.
    most : int
        Points of all lines together.

    Returns
    -------
    dict of str to int
        Points of a line, by signal.
    """
    first = [name for name in names if name in shown]
    rest = [name for name in names if name not in shown]
    lavish = min(_MOST, most // (2 * runs * len(first))) if first else 0
    left = most - lavish * runs * len(first)
    rest = rest[: max(0, left // (runs * _FEWEST))]
    plain = min(_MOST, left // (runs * len(rest))) if rest else 0
    points = {**dict.fromkeys(first, lavish), **dict.fromkeys(rest, plain)}
    return {name: points[name] for name in names if name in points}


_MOST, _FEWEST = 4000, 60
"""Points of a line."""
