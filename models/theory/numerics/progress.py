"""Tell how far a computation is that takes long."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, float], None]
"""Takes how far it is, in words, and which part of all is done, from 0 to 1; where that is not known, a guess."""


def silent(done: str, part: float) -> None:
    """Tell nobody."""
