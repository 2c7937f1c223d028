"""The limit cycle, at its older address: `models.theory.cycle.cycle`."""

from .theory.cycle.cycle import LimitCycle, broken_law, limit_cycle, measured, peak_speed

__all__ = ["LimitCycle", "broken_law", "limit_cycle", "measured", "peak_speed"]
