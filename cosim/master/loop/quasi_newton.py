"""The fast way, for any number of unknowns: interface quasi-Newton with inverse least squares (IQN-ILS).

Degroote, Bathe and Vierendeels (2009), Performance of a new partitioned procedure versus a monolithic procedure in
fluid-structure interaction, Computers & Structures 87. Nothing is known of the components but what they answer. The
differences between answers span a space in which the inverse Jacobian of the residual is known. Outside of it the
answer itself is the next value, as in a fixed-point iteration. Differences from earlier steps stay of use, because the
coupling changes little from one step to the next.
"""

from __future__ import annotations

import numpy as np

from cosim.system.signals import FloatArray

# A difference that points where newer ones do, but for this part of it, says nothing new.
_NEW = 1e-3
# A smaller difference holds too much rounding to be learned from.
_LEAST = 1e-8


class QuasiNewton:
    """Proposes values for n unknowns; keeps what it has learned from step to step.

    Parameters
    ----------
    unknowns : int
        n.
    """

    def __init__(self, unknowns: int) -> None:
        self._unknowns = unknowns
        self._differences: list[tuple[FloatArray, FloatArray]] = []
        self._last: tuple[FloatArray, FloatArray] | None = None

    @property
    def learned(self) -> FloatArray:
        """Differences between answers of earlier steps, shape (2 k, n): of a residual, of the answer, and so on."""
        return np.array([row for pair in self._differences for row in pair]).reshape(-1, self._unknowns)

    @learned.setter
    def learned(self, rows: FloatArray) -> None:
        self._differences = list(zip(rows[::2], rows[1::2], strict=True))

    def begin(self) -> None:
        """Begin a new step: the next answer has nothing to do with the last."""
        self._last = None

    def propose(self, values: FloatArray, residual: FloatArray) -> FloatArray:
        """Return values that should have a smaller residual.

        Parameters
        ----------
        values : ndarray, shape (n,)
            What was tried last; scaled so that 1 is a usual size.
        residual : ndarray, shape (n,)
            What came back, less what was tried.
        """
        answer = values + residual
        if self._last is not None and np.abs(residual - self._last[1]).max() > _LEAST:
            self._differences.insert(0, (residual - self._last[1], answer - self._last[0]))
            del self._differences[2 * self._unknowns + 4 :]
        self._last = (answer, residual)
        basis, chosen = self._independent()
        if not chosen:
            return answer
        # Least squares by the orthonormal basis: chosen residual differences = basis @ triangle.
        triangle = basis.T @ np.column_stack([self._differences[index][0] for index in chosen])
        weights = np.linalg.solve(triangle, -basis.T @ residual)
        return answer + np.column_stack([self._differences[index][1] for index in chosen]) @ weights

    def _independent(self) -> tuple[FloatArray, list[int]]:
        """Choose the newest differences that are linearly independent, with an orthonormal basis of them."""
        basis: list[FloatArray] = []
        chosen: list[int] = []
        for index, (difference, _) in enumerate(self._differences):
            if len(chosen) == self._unknowns:
                break
            rest = difference.copy()
            for direction in basis:
                rest -= direction * (direction @ rest)
            size = float(np.linalg.norm(rest))
            if size > _NEW * float(np.linalg.norm(difference)):
                basis.append(rest / size)
                chosen.append(index)
        return np.column_stack(basis) if basis else np.empty((self._unknowns, 0)), chosen
