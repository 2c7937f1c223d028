"""The parameters of the string with damping along its length, and the grid they ask for."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from .clock import blocks_for
from .parameters import DrillstringParameters

MOST_STRENGTH = 0.125
"""Blocks are so short that a wave loses about this share of itself while it crosses one, at most."""


@dataclass(frozen=True)
class DistributedParameters(DrillstringParameters):
    """Parameters of the string with damping along it.

    Attributes
    ----------
    beta : float
        Damping per unit length [N s/rad], at least 0; the paper gives no value.
    """

    beta: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is not physical: ValueError with name, value and expected range."""
        super().__post_init__()
        if not isfinite(self.beta) or self.beta < 0.0:
            raise ValueError(f"parameter beta is {self.beta}; expected a finite value >= 0")

    @property
    def exchange_rate(self) -> float:
        """How fast waves that cross change each other, beta / (4 I), for a pair of blocks [1/s]."""
        return 0.25 * self.beta / self.I

    @property
    def damping_blocks(self) -> float:
        """Blocks in a travel time that the damping alone asks for."""
        return self.travel_time * self.exchange_rate / MOST_STRENGTH

    def blocks_for(self, cells: int, stations: int) -> int:
        """Return the blocks in a travel time: a multiple of the parts into which the stations divide the string."""
        blocks = blocks_for(cells)
        ratio = self.damping_blocks
        damped = int(ratio)
        if damped < ratio:
            damped += 1
        if damped > blocks:
            blocks = damped
        parts = stations + 1
        return (blocks + parts - 1) // parts * parts
