"""Show how far a long computation is."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, float], None]
"""Takes how far it is, in words, and which part of all is done, from 0 to 1."""
