"""Linear neutral delay systems: their characteristic matrix, and a discretisation of their infinitesimal generator."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..numerics.arrays import ComplexArray, FloatArray
from ..numerics.interpolation import chebyshev


@dataclass(frozen=True)
class LinearNeutral:
    """x'(t) = sum_{k=1..q} E_k x'(t - k delay) + sum_{k=0..q} A_k x(t - k delay).

    Attributes
    ----------
    delay : float
        The common unit of the delays [s].
    E : ndarray, shape (q, n, n)
        E_1 ... E_q.
    A : ndarray, shape (q + 1, n, n)
        A_0 ... A_q.
    """

    delay: float
    E: FloatArray
    A: FloatArray

    def characteristic(self, s: complex) -> ComplexArray:
        """Return s I - s sum E_k exp(-k s delay) - sum A_k exp(-k s delay), singular at the roots [1/s]."""
        powers = np.exp(-s * self.delay * np.arange(len(self.A)))
        identity = np.eye(self.A.shape[1])
        return s * identity - s * np.tensordot(powers[1:], self.E, 1) - np.tensordot(powers, self.A, 1)

    def generator(self, degree: int) -> FloatArray:
        """Return a matrix whose eigenvalues of small modulus approximate the characteristic roots.

        The generator of the semigroup takes a segment phi on [-q delay, 0] to phi'; the system itself is the condition
        its segments meet at 0. Here a segment is a polynomial: phi' is taken at all Chebyshev points but 0, and there
        the right side of the system takes its place. For a root s the segment is exp(s theta), which is entire, so the
        error falls faster than any power of the degree once that exceeds about |s| q delay: Breda, Maset and Vermiglio
        (2006), Pseudospectral approximation of eigenvalues of derivative operators with non-local boundary
        conditions, Applied Numerical Mathematics 56.

        Parameters
        ----------
        degree : int
            Of the polynomials, at least 1.

        Returns
        -------
        ndarray, shape (n (degree + 1), n (degree + 1))
        """
        basis, size, count = chebyshev(degree), self.A.shape[1], len(self.E)
        derivative = basis.differentiation() / (count * self.delay)
        at_delays = basis.at(1.0 - np.arange(count + 1) / count)
        matrix = np.asarray(np.kron(derivative, np.eye(size)), np.float64)
        condition = np.einsum("kij,kp->ipj", self.E, at_delays[1:] @ derivative)
        condition += np.einsum("kij,kp->ipj", self.A, at_delays)
        matrix[-size:] = condition.reshape(size, -1)
        return matrix
