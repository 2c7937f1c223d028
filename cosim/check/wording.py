"""How findings are put into words."""

from __future__ import annotations

from collections.abc import Sequence

_MANY = 3


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, in the plural unless there is one."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def some(texts: Sequence[str]) -> str:
    """Join the first few of many texts."""
    rest = len(texts) - _MANY
    return "; ".join(texts[:_MANY]) + (f"; and {rest} more" if rest > 0 else "")
