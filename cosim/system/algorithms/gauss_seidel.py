"""Gauss-Seidel: components step one after the other, each with what those before it put out at the end of the step.

Only connections that lead back, to an earlier place in the stepping order or to the same one, are one step late.
"""

from __future__ import annotations


def lag(source: int, target: int) -> int:
    """Return how many steps old the value is that passes between two places of the order: 0 forwards, else 1."""
    return 0 if source < target else 1
