"""Find the values at which a loop closes.

With one unknown, the sure way is to enclose a root where the residual changes its sign. Where it changes its sign by a
jump, as at a pole, both sides of the jump are searched for roots as well: next to a pole they come in pairs, between
which the residual dips through zero and back. With several unknowns, the sure way is Newton's method with a Jacobian by
fresh differences and a line search.

The fast way, for any number of unknowns, is interface quasi-Newton with inverse least squares (IQN-ILS): Degroote,
Bathe and Vierendeels (2009), Performance of a new partitioned procedure versus a monolithic procedure in
fluid-structure interaction, Computers & Structures 87. Nothing is known of the components but what they answer. The
differences between answers span a space in which the inverse Jacobian of the residual is known. Outside of it the
answer itself is the next value, as in a fixed-point iteration. Differences from earlier steps stay of use, because the
coupling changes little from one step to the next.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

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
        """Tell whether the components took the values."""
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
        """Tell whether a trial closes the loop."""
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


# The search for a change of sign begins this far away, relative to the usual size, and goes on in strides that grow.
_STRIDE = 0.01
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


def find_single_root(trials: Trials) -> Trial:
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

    low, high = math.log(_NEAREST), math.log(_STRIDE * _GROWTH ** (_STRIDES - 1))
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
    stride = _STRIDE * max(1.0, abs(_value(start)))
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


_ITERATIONS = 10
_HALVINGS = 8
# Finite differences of values scaled to 1: half the digits.
_DIFFERENCE = 1e-7
# A step must take away this part of what it promises (Armijo).
_SUFFICIENT = 1e-4


def find_roots(trials: Trials) -> Trial:
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
