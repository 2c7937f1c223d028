"""Where the residual of a loop vanishes: by a fast method that is nearly always enough, and a sure one behind it."""

from __future__ import annotations

import math
import sys

import numpy as np

from cosim.master.loop.root_finding import (
    QuasiNewton,
    Residual,
    Trial,
    Trials,
    UnsolvedError,
    find_roots,
    find_single_root,
)
from cosim.system.signals import FloatArray

# An answer whose square overflows is as good as infinite: nothing can be extrapolated from it.
_OVERFLOWING = math.sqrt(sys.float_info.max) / 1e3
# So far is a start moved, relative to the usual size, where the answer to it overflows.
_FIRST_STRIDE = 0.01


class LoopSolver:
    """Finds values that come back as they were tried; learns from one step for the next.

    Parameters
    ----------
    low, high : ndarray, shape (n,)
        Between which values are tried; scaled so that 1 is a usual size, as everything here.
    tolerance : float
        Greatest residual, relative to the greater of 1 and the value.
    """

    def __init__(self, low: FloatArray, high: FloatArray, tolerance: float) -> None:
        self._low, self._high = low, high
        self._tolerance = tolerance
        self._quasi_newton = QuasiNewton(low.size)

    def solve(self, residual: Residual, start: FloatArray) -> tuple[FloatArray, int]:
        """Find where the residual vanishes.

        Parameters
        ----------
        residual : callable
            What comes back less what was tried. The last call is the one that vanishes.
        start : ndarray, shape (n,)
            Where to begin.

        Returns
        -------
        values : ndarray, shape (n,)
            The solution.
        trials : int
            How many it took.

        Raises
        ------
        UnsolvedError
            If none was found.
        """
        trials = Trials(residual, self._low, self._high, self._tolerance)
        trial = self._fast(trials, start)
        if trial is None:
            trial = find_single_root(trials) if self._low.size == 1 else find_roots(trials)
        return trial.values, len(trials.made)

    @property
    def learned(self) -> FloatArray:
        """What `QuasiNewton` has learned, shape (2 k, n)."""
        return self._quasi_newton.learned

    @learned.setter
    def learned(self, rows: FloatArray) -> None:
        self._quasi_newton.learned = rows

    def _fast(self, trials: Trials, start: FloatArray) -> Trial | None:
        """Try the quasi-Newton method for as long as it may take; nothing if that was not enough."""
        self._quasi_newton.begin()
        values = start
        last: Trial | None = None
        for _ in range(6 + 2 * self._low.size):
            trial = trials.make(values)
            if trials.solved(trial):
                return trial
            if trial.miss < _OVERFLOWING:
                values = self._quasi_newton.propose(trial.values, trial.residual)
                last = trial
            elif last is None:
                if np.isnan(trial.residual).any():
                    raise UnsolvedError(trials)
                # The components answered, and what they answered has overflowed: a pole is next to the start.
                values = trial.values + _FIRST_STRIDE * np.maximum(1.0, np.abs(trial.values))
            else:
                values = 0.5 * (trial.values + last.values)
        return None
