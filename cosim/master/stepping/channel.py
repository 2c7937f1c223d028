"""How an input is given its value for one step: held, or on a straight line from the beginning of the step to its end.

While a step is under way, the row it leads to holds what is set before it: the value at its beginning, and the slope.
When it is over, the row holds the value in force at its end, which is what a record holds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cosim.system.description import Variable
from cosim.system.signals import Constant, Signal


@dataclass(frozen=True)
class Span:
    """The time of a step.

    Attributes
    ----------
    time, size, end : float
        Communication point, communication step size and the next communication point, s.
    first, last : float
        When signals are evaluated for its beginning and its end, s: the same times but for rounding.
    """

    time: float
    size: float
    end: float
    first: float
    last: float

    @property
    def rounding(self) -> float:
        """By which part the step may be longer or shorter to an FMU that keeps a time of its own."""
        return 8.0 * math.ulp(max(abs(self.time), abs(self.end), self.size)) / self.size


@dataclass(frozen=True)
class Target:
    """A driven input.

    Attributes
    ----------
    name : str
        ``component.variable``.
    variable : Variable
        The input.
    values : memoryview
        Rows and columns that hold it.
    column : int
        In `values`.
    slopes : memoryview, optional
        Rows and columns of derivatives; None if the FMU holds what it is given.
    slope_column : int
        In `slopes`.
    """

    name: str
    variable: Variable
    values: Any
    column: int
    slopes: Any
    slope_column: int

    def hold(self, row: int, value: float) -> None:
        """Let the input be constant over the step."""
        self.values[row, self.column] = value
        if self.slopes is not None:
            self.slopes[row, self.slope_column] = 0.0

    def lead(self, row: int, first: float, last: float, span: Span) -> None:
        """Let the input go from one value to another; an FMU that holds what it is given is given the last."""
        if self.slopes is None:
            self.values[row, self.column] = last
        else:
            self.values[row, self.column] = first
            self.slopes[row, self.slope_column] = self._slope_within_bounds(first, last, span)

    def settle(self, row: int, last: float) -> None:
        """Note the value at the end of the step, which is over."""
        self.values[row, self.column] = last

    def _slope_within_bounds(self, first: float, last: float, span: Span) -> float:
        """Return the slope; where the value ends at a bound, so little less that rounding does not lead past it."""
        slope = (last - first) / span.size
        uncertain = abs(last - first) * span.rounding
        low, high = self.variable.minimum, self.variable.maximum
        if (low is not None and low <= last < low + uncertain) or (
            high is not None and high >= last > high - uncertain
        ):
            slope *= 1.0 - span.rounding
        return slope

    def value(self, row: int) -> float:
        """Return the value in force at the end of the step that led to a row."""
        return self.values[row, self.column]

    def slope(self, row: int) -> float:
        """Return the derivative in the step that led to a row."""
        return 0.0 if self.slopes is None else self.slopes[row, self.slope_column]


@dataclass(frozen=True)
class Channel:
    """A connection: an output and the input it drives.

    Attributes
    ----------
    source : str
        ``component.variable`` of the output.
    target : Target
        The input.
    nominal : float
        A usual size of the value, in its unit.
    continuous : bool
        Whether the value changes continuously but for a few places; if not, it is passed on as it is and held.
    outputs : memoryview
        Rows and columns that hold the output.
    column : int
        In `outputs`.
    derivatives : memoryview, optional
        Rows and columns of output derivatives, where the output goes on along its derivative whatever the others do.
    derivative_column : int
        In `derivatives`.
    """

    source: str
    target: Target
    nominal: float
    continuous: bool
    outputs: Any
    column: int
    derivatives: Any = None
    derivative_column: int = 0

    def output(self, row: int) -> float:
        """Return what the source put out at the end of the step that led to a row."""
        return self.outputs[row, self.column]

    def last(self, begin: int, end: int, size: float) -> float:
        """Return the output at the end of a step, before a jump: what came back, or what its derivative promised."""
        if self.derivatives is None:
            return self.output(end)
        return self.output(begin) + size * self.derivatives[begin, self.derivative_column]


@dataclass(frozen=True)
class Drive:
    """A signal and the input it drives.

    Every row holds the value of a constant from the start on, so that nothing is to be done for it.
    """

    signal: Signal
    target: Target

    @property
    def constant(self) -> bool:
        """Whether it never changes."""
        return isinstance(self.signal, Constant)

    def hold(self, row: int, span: Span) -> None:
        """Hold the value at the beginning of the step; an FMU that interpolates follows the slope there."""
        self.target.hold(row, self.first(span))
        if self.target.slopes is not None:
            self.target.slopes[row, self.target.slope_column] = self.signal.slopes(np.array([span.first]))[0]

    def lead(self, row: int, span: Span) -> None:
        """Go from the value at the beginning of the step to that at its end; what is not Real is held."""
        if self.target.variable.type == "Real":
            self.target.lead(row, self.first(span), self.last(span), span)
        else:
            self.target.hold(row, self.first(span))

    def settle(self, row: int, span: Span) -> None:
        """Note the value at the end of a step in which the input was not held."""
        if self.target.variable.type == "Real":
            self.target.settle(row, self.last(span))

    def first(self, span: Span) -> float:
        """Return the value at the beginning of a step, after a jump."""
        return self.signal.values(np.array([span.first]))[0].item()

    def last(self, span: Span) -> float:
        """Return the value at the end of a step, before a jump."""
        return self.signal.left_values(np.array([span.last]))[0].item()
