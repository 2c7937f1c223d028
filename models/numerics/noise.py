"""Noise that is the same on every platform: numbers by Lehmer, twelve of them added for one that is nearly normal."""

from __future__ import annotations

from typing import NamedTuple

MODULUS, MULTIPLIER = 2147483647, 48271
"""Of the generator of Park and Miller (1988), with the multiplier of 1993; products stay below 2^47."""


class Draw(NamedTuple):
    """A random number, and the state from which the next follows."""

    value: float
    state: float


def uniform(state: float) -> Draw:
    """Return a number between 0 and 1; the state is a whole number from 1 to 2147483646."""
    following = int(state) * MULTIPLIER % MODULUS
    return Draw(following / 2147483647.0, float(following))


def normal(state: float) -> Draw:
    """Return a number of mean 0 and deviation 1, between -6 and 6."""
    total = -6.0
    for _ in range(12):
        value, state = uniform(state)
        total = total + value
    return Draw(total, state)
