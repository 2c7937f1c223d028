"""What the examination of a law gives, and the list of all laws."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Finding:
    """A law held against a computation.

    Attributes
    ----------
    compared : str
        What was compared with what.
    found, allowed : float
        Greatest error found, and allowed, in `unit`.
    reason : str
        Why that much is allowed.
    unit : str
        Empty for a number without one.
    """

    compared: str
    found: float
    allowed: float
    reason: str
    unit: str = ""

    @property
    def holds(self) -> bool:
        """Whether the error is within what is allowed; not if it is no number."""
        return self.found <= self.allowed

    @classmethod
    def broken_by(cls, error: Exception) -> Finding:
        """Return what is found where the examination itself ends with an error: the law is broken, and this is why."""
        return cls(f"nothing: {type(error).__name__}: {error}", np.nan, 0.0, "the examination has to come to its end")


@dataclass(frozen=True)
class Law:
    """A law and its examination.

    Attributes
    ----------
    name, statement, section : str
        Of the function that examines it, its docstring's first line, and the heading under which it is reported.
    examine : callable
        Returns what was found.
    """

    name: str
    statement: str
    section: str
    examine: Callable[[], Finding]


def greatest(errors: Iterable[ArrayLike]) -> float:
    """Return the greatest size among errors, numbers or arrays: no number if one of them is none, unlike `max`."""
    return float(np.max([np.max(np.abs(error)) for error in errors]))


LAWS: list[Law] = []
"""In the order of the report."""


def law(section: str) -> Callable[[Callable[[], Finding]], Callable[[], Finding]]:
    """Enter a function into the list of laws; its docstring states the law in one line."""

    def entered(examine: Callable[[], Finding]) -> Callable[[], Finding]:
        statement = (examine.__doc__ or "").strip().splitlines()[0].rstrip(".")
        LAWS.append(Law(examine.__name__, statement, section, examine))
        return examine

    return entered
