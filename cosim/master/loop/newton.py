"""Several unknowns, the sure way: Newton's method with a Jacobian by fresh differences and a line search."""

from __future__ import annotations

import numpy as np

from cosim.master.loop.trials import Trial, Trials, UnsolvedError
from cosim.system.signals import FloatArray

_ITERATIONS = 10
_HALVINGS = 8
# Finite differences of values scaled to 1: half the digits.
_DIFFERENCE = 1e-7
# A step must take away this part of what it promises (Armijo).
_SUFFICIENT = 1e-4


def find_root(trials: Trials) -> Trial:
    """Find where the residual vanishes, from the best of the trials already made.

    Parameters
    ----------
    trials : Trials
        At least one of them answered.

    Raises
    ------
    UnsolvedError
        If a line search or the number of iterations comes to an end.
    """
    trial = trials.best
    for _ in range(_ITERATIONS):
        direction = np.linalg.lstsq(_jacobian(trials, trial), -trial.residual, rcond=None)[0]
        trial = _search(trials, trial, direction.astype(np.float64))
        if trials.solved(trial):
            return trial
    raise UnsolvedError(trials)


def _jacobian(trials: Trials, trial: Trial) -> FloatArray:
    """Take differences, inwards where a value is at its upper bound."""
    columns: list[FloatArray] = []
    for index, value in enumerate(trial.values):
        size = _DIFFERENCE * max(1.0, abs(float(value)))
        values = trial.values.copy()
        values[index] += size if value + size <= trials.high[index] else -size
        other = trials.make(values)
        if not other.answered:
            raise UnsolvedError(trials)
        columns.append((other.residual - trial.residual) / (other.values[index] - value))
    return np.column_stack(columns)


def _search(trials: Trials, start: Trial, direction: FloatArray) -> Trial:
    """Go as far in a direction as the residual becomes less for it."""
    part = 1.0
    for _ in range(_HALVINGS):
        trial = trials.make(start.values + part * direction)
        if trials.solved(trial) or trial.miss < (1.0 - _SUFFICIENT * part) * start.miss:
            return trial
        part *= 0.5
    raise UnsolvedError(trials)
