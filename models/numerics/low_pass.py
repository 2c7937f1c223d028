"""The filter of first order, exactly for an input that goes on a straight line."""

from __future__ import annotations

from .exponential import exponential


def fading(elapsed: float, time_constant: float) -> float:
    """Return what is left after `elapsed` seconds of what dies away with a time constant; 0 dies at once."""
    return exponential(-elapsed / time_constant) if time_constant > 0.0 else 0.0


def low_pass(before: float, value: float, slope: float, elapsed: float, time_constant: float) -> float:
    """Return the output of x' = (input - x) / time_constant after `elapsed` seconds.

    Parameters
    ----------
    before : float
        The output so far.
    value, slope : float
        The input at the beginning, and its derivative.
    elapsed : float
        Time that passes [s].
    time_constant : float
        Of the filter [s]; with 0 the output is the input.
    """
    lag = slope * time_constant
    return (value + slope * elapsed - lag) + (before - (value - lag)) * fading(elapsed, time_constant)
