"""The number of zeros of an analytic function in a rectangle, by the argument principle."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .arrays import ComplexArray, FloatArray

LARGEST_TURN = 0.5
"""Between neighbouring points of the contour the argument turns by less than this [rad]."""
MOST_POINTS = 1_000_000


def zeros_inside(
    function: Callable[[ComplexArray], ComplexArray],
    real: tuple[float, float],
    imaginary: tuple[float, float],
    spacing: float,
) -> int:
    """Return the number of zeros in a rectangle, counted as often as their order.

    Parameters
    ----------
    function : callable
        Analytic in the rectangle; of arrays.
    real, imaginary : tuple of float
        Least and greatest real and imaginary part.
    spacing : float
        Of the first points on the contour: short against the distance over which the function can turn fully. Points
        are added until the argument turns little between neighbours.

    Raises
    ------
    ArithmeticError
        A zero lies on the contour, or so near that the argument cannot be followed.
    """
    corners = [complex(x, y) for x, y in zip((*real, *real[::-1]), np.repeat(imaginary, 2).tolist(), strict=True)]
    points = np.concatenate([_edge(a, b, spacing) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)])
    values = function(points)
    while True:
        if not values.all() or not np.isfinite(values).all():
            raise ArithmeticError(f"the function is zero or not finite on the edge of {real} by {imaginary}")
        following, ahead = np.roll(points, -1), np.roll(values, -1)
        turns: FloatArray = np.angle(ahead / values)
        coarse = np.flatnonzero(np.abs(turns) >= LARGEST_TURN)
        if not coarse.size:
            return round(float(turns.sum()) / (2.0 * np.pi))
        middles = 0.5 * (points[coarse] + following[coarse])
        if points.size > MOST_POINTS or np.any(np.abs(middles - points[coarse]) < 1e-14 * (1.0 + np.abs(middles))):
            raise ArithmeticError(f"a zero is too near the edge of {real} by {imaginary} to be counted")
        points = np.insert(points, coarse + 1, middles)
        values = np.insert(values, coarse + 1, function(middles))


def _edge(start: complex, end: complex, spacing: float) -> ComplexArray:
    """Return points on a straight line, the end excluded."""
    count = max(2, int(np.ceil(abs(end - start) / spacing)))
    return np.asarray(start + (end - start) * np.arange(count) / count, np.complex128)
