"""Polynomials on one piece, known by their values at the Gauss-Legendre nodes of [-1, 1]."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre
from scipy.optimize import brentq, minimize_scalar

SAMPLES = 41
"""Even points, both ends included, on which a polynomial is searched for its first sign change."""


class GaussBasis:
    """Matrices that turn values at `count` Gauss nodes into Legendre coefficients, integrals and samples.

    Attributes
    ----------
    nodes, weights : ndarray, shape (count,)
        Gauss-Legendre nodes and weights; the nodes never touch the ends, where neighbours may differ by a jump.
    to_coefficients : ndarray, shape (count, count)
        Values at the nodes to Legendre coefficients.
    antiderivative : ndarray, shape (count + 1, count)
        Legendre coefficients to those of the integral from -1.
    integration : ndarray, shape (count, count)
        Values at the nodes to the integral from -1 to each node.
    to_samples : ndarray, shape (SAMPLES, count)
        Values at the nodes to values at the even sample points.
    """

    def __init__(self, count: int):
        self.count = count
        self.nodes, _ = legendre.leggauss(count)
        degrees = np.arange(count)
        at_nodes = legendre.legvander(self.nodes, count)
        # Inverting the values is a digit or two better than the quadrature sum, whose weights carry an error of 1e-13.
        self.to_coefficients = np.linalg.inv(at_nodes[:, :count])
        self.weights = 2 * self.to_coefficients[0]
        self.antiderivative = np.zeros((count + 1, count))
        self.antiderivative[degrees + 1, degrees] = 1 / (2 * degrees + 1)
        self.antiderivative[degrees[1:] - 1, degrees[1:]] = -1 / (2 * degrees[1:] + 1)
        self.antiderivative[0, 0] = 1
        self.integration = at_nodes @ self.antiderivative @ self.to_coefficients
        self.sample_points = np.linspace(-1, 1, SAMPLES)
        self.to_samples = legendre.legvander(self.sample_points, count - 1) @ self.to_coefficients

    def at(self, values: np.ndarray, x: float) -> float:
        """Value at x of the polynomial with these node values."""
        return float(legendre.legval(x, self.to_coefficients @ values))

    def tail(self, values: np.ndarray) -> float:
        """Size of the last three coefficients: how far the polynomial is from resolving its function."""
        return float(np.abs(self.to_coefficients[-3:] @ values).max())

    def first_fall(self, values: np.ndarray, tolerance: float, *, from_zero: bool = False) -> float | None:
        """Return where the polynomial first goes below zero, as x in [-1, 1], or None.

        A dip shallower than `tolerance` is rounding and is not seen; the place returned is that of the zero itself.
        A polynomial known to start `from_zero` is divided by x + 1 to find the zero after that one: its own value at -1
        is rounding, and the sign of that would decide whether the fall is there or further on.
        """
        points, samples = self.sample_points, self.to_samples @ values
        coefficients = rest = self.to_coefficients @ values
        if from_zero:
            samples[0], rest = 0.0, self.to_coefficients @ (values / (self.nodes + 1))
        low = np.flatnonzero(samples < -tolerance)
        last = int(low[0]) if low.size else SAMPLES
        for dip in _possible_dips(samples[:last]):
            found = minimize_scalar(
                legendre.legval, args=(coefficients,), bounds=points[[dip - 1, dip + 1]], method="bounded"
            )
            if found.fun < -tolerance:
                return _zero_between(rest, points[dip - 1], float(found.x))
        if last == SAMPLES:
            return None
        above = np.flatnonzero(samples[:last] >= 0)
        return _zero_between(rest, points[above[-1]], points[last]) if above.size else -1.0


def _possible_dips(samples: np.ndarray) -> np.ndarray:
    """Sample indices next to which a minimum between samples could reach below zero."""
    inner, before, after = samples[1:-1], samples[:-2], samples[2:]
    rise = np.maximum(before, after) - inner
    return np.flatnonzero((inner <= before) & (inner <= after) & (inner < 2 * rise)) + 1


def _zero_between(coefficients: np.ndarray, above: float, below: float) -> float:
    if legendre.legval(above, coefficients) <= 0:
        return float(above)
    return float(brentq(legendre.legval, above, below, args=(coefficients,), xtol=1e-16, rtol=1e-15))


@lru_cache
def gauss_basis(count: int) -> GaussBasis:
    """Return the basis with `count` nodes, built once."""
    return GaussBasis(count)


def evaluate(coefficients: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Legendre series, one a row of shape (points, degree + 1), each at its own x of shape (points,)."""
    return legendre.legval(x, coefficients.T, tensor=False)
