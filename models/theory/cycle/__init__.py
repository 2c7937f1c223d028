"""Periodic motions: limit cycles, their multipliers, their branches, bistability."""
