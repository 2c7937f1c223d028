"""Polynomials by their values at nodes: barycentric interpolation, and differentiation at Chebyshev points.

Formulas: Berrut and Trefethen (2004), Barycentric Lagrange Interpolation, SIAM Review 46.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .arrays import FloatArray


class Interpolation:
    """Polynomials through values at nodes in [0, 1].

    Attributes
    ----------
    nodes, weights : ndarray, shape (n,)
        The nodes, increasing, and their barycentric weights.
    """

    def __init__(self, nodes: FloatArray, weights: FloatArray) -> None:
        self.nodes = nodes
        self.weights = weights

    def at(self, places: FloatArray) -> FloatArray:
        """Return the matrix from values at the nodes to values at places, shape (places, n)."""
        gaps = places[:, None] - self.nodes
        at_node = gaps == 0.0
        gaps[at_node] = 1.0
        matrix = self.weights / gaps
        matrix /= matrix.sum(axis=1, keepdims=True)
        hit = at_node.any(axis=1)
        matrix[hit] = at_node[hit]
        return matrix

    def differentiation(self) -> FloatArray:
        """Return the matrix from values at the nodes to values of the derivative there, shape (n, n)."""
        gaps = self.nodes[:, None] - self.nodes + np.eye(self.nodes.size)
        matrix = self.weights / self.weights[:, None] / gaps
        np.fill_diagonal(matrix, 0.0)
        # rows that sum to zero differentiate constants exactly, whatever the rounding
        np.fill_diagonal(matrix, -matrix.sum(axis=1))
        return matrix


@lru_cache
def chebyshev(degree: int) -> Interpolation:
    """Return interpolation at the extrema of a Chebyshev polynomial, degree + 1 nodes, both ends among them."""
    places = np.arange(degree + 1)
    weights = np.where(places % 2, -1.0, 1.0)
    weights[[0, -1]] *= 0.5
    return Interpolation(0.5 * (1.0 + np.sin(0.5 * np.pi * (2.0 * places - degree) / degree)), weights)


@lru_cache
def gauss(count: int) -> Interpolation:
    """Return interpolation at Gauss-Legendre nodes, all inside (0, 1)."""
    nodes, quadrature = np.polynomial.legendre.leggauss(count)
    signs = np.where(np.arange(count) % 2, -1.0, 1.0)
    return Interpolation(0.5 * (1.0 + nodes), signs * np.sqrt((1.0 - nodes**2) * quadrature))
