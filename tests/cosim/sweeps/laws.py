"""Laws that tests of sweeps put in the place of FMUs, in the workers as well, which import them from here."""

from __future__ import annotations


def weight(bit_speed: float, K_w: float = 3.0, WOB_0: float = 2e4) -> float:
    """Return a weight on bit that grows with its speed."""
    return WOB_0 + 1e3 * K_w * max(bit_speed, 0.0)


def stubborn(bit_speed: float, K_w: float = 3.0) -> float:
    """Have no answer for great gains."""
    if K_w > 5.0:
        raise ValueError("too much")
    return 2e4
