"""Difference operators of neutral systems: formal stability, eq. (18), and strong stability, which is more."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from math import inf, log, pi

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize

from ..numerics.arrays import ComplexArray, FloatArray

SETS = 4096
"""Sets of phases tried for the strong radius, of which the best few are improved."""
IMPROVED = 6


@dataclass(frozen=True)
class DifferenceOperator:
    """The operator x(t) - sum over k of E_k x(t - k delay), k = 1 ... q, whose delays are multiples of one.

    Its characteristic roots are the s at which I - sum E_k exp(-k s delay) has no full rank. With z = exp(-s delay)
    they are the roots of the polynomial det(I - sum E_k z^k), or with lambda = 1/z the eigenvalues of its companion
    matrix, repeated on vertical chains 2 pi / delay apart.

    Attributes
    ----------
    delay : float
        The common unit of the delays [s].
    matrices : tuple of ndarray, each of shape (n, n)
        E_1 ... E_q; at least one.
    """

    delay: float
    matrices: tuple[FloatArray, ...]

    @classmethod
    def of(cls, delay: float, matrices: Iterable[ArrayLike]) -> DifferenceOperator:
        """Return the operator of a delay [s] and of matrices E_1, E_2, ... or, for n = 1, numbers.

        Raises
        ------
        ValueError
            The delay is not above 0, or the matrices are not square, finite and of one size.
        """
        if not 0.0 < delay < inf:
            raise ValueError(f"delay is {delay} s; expected a finite value > 0")
        read = tuple(np.atleast_2d(np.asarray(matrix, dtype=np.float64)) for matrix in matrices)
        if not read:
            raise ValueError("no matrix was given; expected E_1 at least")
        size = read[0].shape[0]
        for number, matrix in enumerate(read, 1):
            if matrix.shape != (size, size) or not np.isfinite(matrix).all():
                raise ValueError(f"E_{number} is {matrix.tolist()}; expected finite numbers, {size} by {size}")
        return cls(delay, read)

    def matrix(self, s: complex) -> ComplexArray:
        """Return I - sum E_k exp(-k s delay), the matrix of the rank condition (18), at s [1/s]."""
        z = np.exp(-s * self.delay)
        powers = np.power(z, np.arange(1, len(self.matrices) + 1))
        size = self.matrices[0].shape[0]
        return np.eye(size, dtype=np.complex128) - np.tensordot(powers, np.array(self.matrices), 1)

    @cached_property
    def multipliers(self) -> ComplexArray:
        """Factors by which the solutions of the difference equation grow in one delay, shape (n q,)."""
        size, count = self.matrices[0].shape[0], len(self.matrices)
        companion = np.eye(size * count, k=-size)
        companion[:size] = np.hstack(self.matrices)
        return np.linalg.eigvals(companion).astype(np.complex128)

    @property
    def radius(self) -> float:
        """Greatest absolute multiplier."""
        return float(np.abs(self.multipliers).max())

    @property
    def abscissa(self) -> float:
        """Real part of the rightmost chain of roots [1/s]; minus infinity if there is none."""
        return log(self.radius) / self.delay if self.radius > 0.0 else -inf

    @property
    def margin(self) -> float:
        """1 - radius: positive if and only if formally stable."""
        return 1.0 - self.radius

    @property
    def formally_stable(self) -> bool:
        """Tell whether the rank condition (18) holds for all Re s >= 0."""
        return self.radius < 1.0

    @cached_property
    def strong_radius(self) -> float:
        """Greatest spectral radius of sum E_k exp(i phase_k) over all phases.

        The operator is stable for all delays near the given ones, each changed on its own, if and only if this is
        below 1; and it is then so for all delays whatever: Hale and Verduyn Lunel (1993), chapter 9, theorem 6.1. The
        maximum is looked for from many sets of phases; where it equals :attr:`strong_bound` it is certainly the
        greatest.
        """
        present = np.array([matrix for matrix in self.matrices if matrix.any()])
        if not present.size:
            return 0.0
        # a common phase does not matter, so the first is 0
        tried = np.random.default_rng(0).uniform(0.0, 2.0 * pi, (SETS, len(present)))
        tried[0] = tried[:, 0] = 0.0
        radii = _radii(present, tried)
        best = float(radii.max())
        for phases in tried[np.argsort(radii)[-IMPROVED:], 1:] if len(present) > 1 else ():
            found = minimize(
                lambda free: -float(_radii(present, np.concatenate([[0.0], free])[None])[0]),
                phases,
                method="Nelder-Mead",
                options={"xatol": 1e-9, "fatol": 1e-14},
            )
            best = max(best, -float(found.fun))
        return best

    @property
    def strong_bound(self) -> float:
        """Spectral radius of sum |E_k|, entry by entry: an upper bound of :attr:`strong_radius`."""
        total: FloatArray = np.abs(np.array(self.matrices)).sum(axis=0)
        return float(np.abs(np.linalg.eigvals(total)).max())

    @property
    def strongly_stable(self) -> bool:
        """Tell whether stability survives any small change of the delays, each on its own."""
        return self.strong_bound < 1.0 or self.strong_radius < 1.0


def _radii(matrices: FloatArray, phases: FloatArray) -> FloatArray:
    """Return the spectral radius of sum E_k exp(i phase_k) for each row of phases."""
    return np.abs(np.linalg.eigvals(np.tensordot(np.exp(1j * phases), matrices, 1))).max(axis=1)
