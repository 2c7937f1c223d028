"""Sweeps over the inputs of a law without memory, answered by closed forms in decimal arithmetic of 40 digits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from decimal import Decimal, localcontext

import numpy as np

from tests.reference.experiment import Answers, Points, held

STEP = 0.25
"""Communication step size of the sweeps; every one of its multiples is a number without rounding [s]."""
DIGITS = 40

Row = Mapping[str, Decimal]
Formula = Callable[[Row], Mapping[str, Decimal | bool]]


def spread(count: int, low: float, high: float, stride: float) -> tuple[float, ...]:
    """Return numbers all over a range, in no order, with at most three digits after the point."""
    return tuple(round(low + (high - low) * ((0.5 + index * stride) % 1.0), 3) for index in range(count))


class Sweep:
    """Inputs held for one step each, and what a law without memory makes of them.

    Parameters
    ----------
    formula : callable
        From the inputs to the outputs.
    columns : mapping of str to sequence of float
        The values each input takes, one for each step.
    """

    def __init__(self, formula: Formula, columns: Mapping[str, Sequence[float]]) -> None:
        self._formula, self._columns = formula, columns

    @property
    def inputs(self) -> Mapping[str, Points]:
        """The inputs over time."""
        return {
            name: held(*((index * STEP, value) for index, value in enumerate(values)))
            for name, values in self._columns.items()
        }

    @property
    def stop_time(self) -> float:
        """When the last values have been held for a step [s]."""
        return len(next(iter(self._columns.values()))) * STEP

    def answer(self, times: np.ndarray, step_size: float) -> Answers:
        """Return the outputs: at a communication point they are those of the step that ends there."""
        with localcontext() as context:
            context.prec = DIGITS
            places = [max(round(time / step_size) - 1, 0) for time in times]
            rows = [{name: Decimal(values[place]) for name, values in self._columns.items()} for place in places]
            return columns([self._formula(row) for row in rows])


def columns(rows: Sequence[Mapping[str, Decimal | bool]]) -> Answers:
    """Turn rows of exact answers into columns of the nearest doubles."""
    return {
        name: np.array([row[name] if isinstance(row[name], bool) else float(row[name]) for row in rows])
        for name in rows[0]
    }
