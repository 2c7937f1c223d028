"""Inputs held for one step each, and what a law with a memory makes of them, step by step with 40 digits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mpmath
import numpy as np

from tests.reference.experiment import Answers, Points, held

DIGITS = 40

Row = Mapping[str, Any]
"""Inputs as exact numbers, or outputs."""
Law = Callable[[], tuple[Callable[[Row], Row], Callable[[Row, Any], Row]]]
"""Returns a law at its beginning: first inputs to first outputs; then inputs and step size to outputs."""


class Stepwise:
    """A law driven by inputs that are held between communication points.

    Parameters
    ----------
    law : callable
        Returns the two functions of a fresh law.
    columns : mapping of str to sequence of float
        The values each input takes, one for each step.
    step : float
        The step [s].
    """

    def __init__(self, law: Law, columns: Mapping[str, Sequence[float]], step: float) -> None:
        self._law, self._columns, self._step = law, columns, step

    @property
    def inputs(self) -> Mapping[str, Points]:
        """The inputs over time."""
        return {
            name: held(*((index * self._step, value) for index, value in enumerate(values)))
            for name, values in self._columns.items()
        }

    @property
    def steps(self) -> int:
        """How many steps there are values for."""
        return len(next(iter(self._columns.values())))

    @property
    def stop_time(self) -> float:
        """When the last values have been held for a step [s]."""
        return self.steps * self._step

    def answer(self, times: np.ndarray, step_size: float) -> Answers:
        """Return the outputs: at a communication point they are those of the step that ends there."""
        with mpmath.workdps(DIGITS):
            given = [
                {name: mpmath.mpf(values[index]) for name, values in self._columns.items()}
                for index in range(self.steps)
            ]
            begin, go_on = self._law()
            rows = [begin(given[0]), *(go_on(row, mpmath.mpf(step_size)) for row in given)]
            kept = [rows[round(time / step_size)] for time in times]
            return {name: np.array([_plain(row[name]) for row in kept]) for name in kept[0]}


def _plain(value: Any) -> float | int | bool:
    return value if isinstance(value, bool | int) else float(value)
