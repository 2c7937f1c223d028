"""The search for values at which a loop closes: what has been tried, and what came back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from cosim.system.signals import FloatArray

Residual = Callable[[FloatArray], FloatArray]
"""From n tried values to what comes back, less what was tried; NaN where the components refuse. Scaled: 1 is usual."""


@dataclass(frozen=True)
class Trial:
    """Values that were tried, shape (n,), and their residual."""

    values: FloatArray
    residual: FloatArray

    @property
    def answered(self) -> bool:
        """Whether the components took the values."""
        return bool(np.isfinite(self.residual).all())

    @property
    def miss(self) -> float:
        """Greatest component of the residual."""
        return float(np.abs(self.residual).max()) if self.answered else np.inf


@dataclass
class Trials:
    """Tries values and remembers.

    Parameters
    ----------
    function : callable
        What is to vanish.
    low, high : ndarray, shape (n,)
        Between which values are tried.
    tolerance : float
        A residual this small, relative to the greater of 1 and the value, is taken for none.
    """

    function: Residual
    low: FloatArray
    high: FloatArray
    tolerance: float
    made: list[Trial] = field(default_factory=list[Trial])

    def make(self, values: FloatArray) -> Trial:
        """Try values, or the nearest that are allowed."""
        allowed = np.clip(values, self.low, self.high)
        self.made.append(Trial(allowed, self.function(allowed)))
        return self.made[-1]

    def solved(self, trial: Trial) -> bool:
        """Whether a trial closes the loop."""
        return bool((np.abs(trial.residual) <= self.tolerance * np.maximum(1.0, np.abs(trial.values))).all())

    @property
    def best(self) -> Trial:
        """The trial that came nearest."""
        return min(self.made, key=lambda trial: trial.miss)


class UnsolvedError(Exception):
    """A search that found nothing; who knows time and names catches it and tells.

    Attributes
    ----------
    trials : int
        How many were made.
    best : Trial
        The one that came nearest.
    jump : tuple of Trial, optional
        Two trials with next to nothing between them, between which the residual changes its sign by a jump.
    """

    def __init__(self, trials: Trials, jump: tuple[Trial, Trial] | None = None) -> None:
        super().__init__()
        self.trials = len(trials.made)
        self.best = trials.best
        self.jump = jump
