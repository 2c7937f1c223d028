"""Polynomials by their values at Chebyshev points: differentiation and barycentric interpolation.

The points are the extrema of a Chebyshev polynomial on [0, 1], both ends included; the formulas are those of Berrut and
Trefethen (2004), Barycentric Lagrange Interpolation, SIAM Review 46.
"""

from __future__ import annotations

from functools import cached_property, lru_cache

import numpy as np

from models.arrays import FloatArray


class Chebyshev:
    """Polynomials of one degree on [0, 1].

    Parameters
    ----------
    degree : int
        At least 1.

    Attributes
    ----------
    nodes : ndarray, shape (degree + 1,)
        The points, increasing from 0 to 1.
    differentiation : ndarray, shape (degree + 1, degree + 1)
        Values to values of the derivative.
    """

    def __init__(self, degree: int) -> None:
        self.degree = degree
        places = np.arange(degree + 1)
        self.nodes: FloatArray = 0.5 * (1.0 + np.sin(0.5 * np.pi * (2.0 * places - degree) / degree))
        self._weights: FloatArray = np.where(places % 2, -1.0, 1.0)
        self._weights[[0, -1]] *= 0.5
        gaps = self.nodes[:, None] - self.nodes + np.eye(degree + 1)
        matrix = self._weights / self._weights[:, None] / gaps
        np.fill_diagonal(matrix, 0.0)
        # rows that sum to zero differentiate constants exactly, whatever the rounding
        np.fill_diagonal(matrix, -matrix.sum(axis=1))
        self.differentiation: FloatArray = matrix

    @cached_property
    def gauss(self) -> FloatArray:
        """Gauss-Legendre points of (0, 1), for collocation, shape (degree,)."""
        return 0.5 * (1.0 + np.polynomial.legendre.leggauss(self.degree)[0])

    def interpolation(self, places: FloatArray) -> FloatArray:
        """Return the matrix from values at the nodes to values at places in [0, 1], shape (places, degree + 1)."""
        gaps = places[:, None] - self.nodes
        at_node = gaps == 0.0
        gaps[at_node] = 1.0
        matrix = self._weights / gaps
        matrix /= matrix.sum(axis=1, keepdims=True)
        hit = at_node.any(axis=1)
        matrix[hit] = at_node[hit]
        return matrix


@lru_cache
def chebyshev(degree: int) -> Chebyshev:
    """Return the polynomials of a degree, made once."""
    return Chebyshev(degree)
