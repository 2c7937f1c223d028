"""One unknown, the sure way: a root where the residual changes its sign.

Where it changes its sign by a jump, as at a pole, both sides of the jump are searched for roots as well: next to a pole
they come in pairs, between which the residual dips through zero and back.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from cosim.master.loop.trials import Trial, Trials, UnsolvedError

# The search for a change of sign begins this far away, relative to the usual size, and goes on in strides that grow.
_FIRST_STRIDE = 0.01
_GROWTH = 4.0
_STRIDES = 12
# Between values this near to each other the residual jumps if it changes more steeply than that, and at the least width
# in any case.
_NEAR = 1e-6
_STEEPEST = 1e9
_LEAST_WIDTH = 1e-14
# The search beside a jump begins this near to it, and makes so many sections.
_NEAREST = 1e-6
_SECTIONS = 18
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


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
    try:
        return _narrow(trials, *found)
    except UnsolvedError as failure:
        if failure.jump is None:
            raise
        jump = failure.jump
    for edge, direction in zip(jump, (-1.0, 1.0), strict=True):
        dip = _dip(trials, edge, direction)
        if dip is not None:
            if trials.solved(dip):
                return dip if dip is trials.made[-1] else trials.make(dip.values)
            return _narrow(trials, *_sorted(_last_before(trials, edge, dip), dip))
    trials.make(jump[0].values)  # so that guards and limits are seen as they are at the jump
    raise UnsolvedError(trials, jump)


def _narrow(trials: Trials, left: Trial, right: Trial) -> Trial:
    """Find the root between two trials of different sign; UnsolvedError if there is a jump."""
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


def _dip(trials: Trials, edge: Trial, direction: float) -> Trial | None:
    """Search one side of a jump for a trial whose residual differs in sign from that next to it; None if none is met.

    The search is by golden sections of the logarithm of the distance, along which c / x + x - k has one least value.
    """
    sign = math.copysign(1.0, _residual(edge))

    def height(place: float) -> tuple[float, Trial]:
        trial = trials.make(edge.values + direction * math.exp(place))
        return (sign * _residual(trial) if trial.answered else math.inf), trial

    low, high = math.log(_NEAREST), math.log(_FIRST_STRIDE * _GROWTH ** (_STRIDES - 1))
    inner, outer = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    (first, at_inner), (second, at_outer) = height(inner), height(outer)
    for _ in range(_SECTIONS):
        for value, trial in ((first, at_inner), (second, at_outer)):
            if value < 0.0 or trials.solved(trial):
                return trial
        if first <= second:
            high, outer, second, at_outer = outer, inner, first, at_inner
            inner = high - _GOLDEN * (high - low)
            first, at_inner = height(inner)
        else:
            low, inner, first, at_inner = inner, outer, second, at_outer
            outer = low + _GOLDEN * (high - low)
            second, at_outer = height(outer)
    return None


def _last_before(trials: Trials, edge: Trial, dip: Trial) -> Trial:
    """Return the trial nearest to a dip, between it and the jump, that has the sign of the edge."""
    between = sorted((_value(edge), _value(dip)))
    made = [trial for trial in trials.made if trial.answered and between[0] <= _value(trial) <= between[1]]
    same = [trial for trial in made if _residual(trial) * _residual(edge) > 0.0]
    return min(same, key=lambda trial: abs(_value(trial) - _value(dip)))


def _sorted(one: Trial, other: Trial) -> tuple[Trial, Trial]:
    """Return two trials, the one with the lesser value first."""
    return (one, other) if _value(one) < _value(other) else (other, one)


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
