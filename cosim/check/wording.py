"""How findings are put into words, and how much is looked at where there is much."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

Thing = TypeVar("Thing")

_MANY = 3


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, in the plural unless there is one."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def sample(things: Sequence[Thing], most: int) -> Sequence[Thing]:
    """Return all of a few things, or as many as `most` spread evenly over many."""
    return things if len(things) <= most else [things[len(things) * place // most] for place in range(most)]


def some(texts: Sequence[str]) -> str:
    """Join the first few of many texts."""
    rest = len(texts) - _MANY
    return "; ".join(texts[:_MANY]) + (f"; and {rest} more" if rest > 0 else "")
