"""One unknown, the sure way: a root where the residual changes its sign, or the jump that is there instead."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from cosim.stepping.loop.trials import Trial, Trials, UnsolvedError

# The search for a change of sign begins this far away, relative to the usual size, and goes on in strides that grow.
_FIRST_STRIDE = 0.01
_GROWTH = 4.0
_STRIDES = 12
# Between values this near to each other the residual jumps if it changes more steeply than that, and at the least width
# in any case.
_NEAR = 1e-6
_STEEPEST = 1e9
_LEAST_WIDTH = 1e-14


def find_root(trials: Trials) -> Trial:
    """Find where the residual of one unknown vanishes.

    Parameters
    ----------
    trials : Trials
        Of one unknown; the trials already made are made use of.

    Raises
    ------
    UnsolvedError
        If the residual has one sign wherever it was tried, or changes it by a jump.
    """
    found = _bracket(trials)
    if isinstance(found, Trial):
        return found
    left, right = found
    halve = False
    while True:
        width = _value(right) - _value(left)
        drop = abs(_residual(left)) + abs(_residual(right))
        apart = width / max(1.0, abs(_value(left)))
        if apart <= _LEAST_WIDTH or (apart <= _NEAR and drop > _STEEPEST * width):
            raise UnsolvedError(trials, (left, right))
        part = 0.5 if halve else abs(_residual(left)) / drop
        trial = trials.make(left.values + min(max(part, 0.01), 0.99) * width)
        if trials.solved(trial):
            return trial
        if not trial.answered:
            raise UnsolvedError(trials)
        if _residual(trial) * _residual(left) > 0.0:
            left = trial
        else:
            right = trial
        # The secant is fast where the residual is smooth; where it did not help, halve.
        halve = _value(right) - _value(left) > 0.5 * width


def _bracket(trials: Trials) -> Trial | tuple[Trial, Trial]:
    """Find two trials of different sign, making more until there are some; or a root, if one is met on the way."""
    pair = _change_of_sign(trials)
    start = trials.best
    stride = _FIRST_STRIDE * max(1.0, abs(_value(start)))
    towards = math.copysign(1.0, _residual(start))
    for _ in range(_STRIDES):
        if pair is not None:
            return pair
        for direction in (towards, -towards):
            trial = trials.make(start.values + direction * stride)
            if trials.solved(trial):
                return trial
        stride *= _GROWTH
        pair = _change_of_sign(trials)
    if pair is None:
        raise UnsolvedError(trials)
    return pair


def _change_of_sign(trials: Trials) -> tuple[Trial, Trial] | None:
    """Return the neighbours of different sign that are nearest to each other."""
    made = sorted((trial for trial in trials.made if trial.answered), key=_value)
    pairs = [(a, b) for a, b in pairwise(made) if _residual(a) * _residual(b) < 0.0]
    return min(pairs, key=lambda pair: _value(pair[1]) - _value(pair[0]), default=None)


def _value(trial: Trial) -> float:
    """Return the one value."""
    return float(trial.values[0])


def _residual(trial: Trial) -> float:
    """Return the one residual."""
    return float(np.ravel(trial.residual)[0])
