"""The theory of the string and its bit: equilibria, spectrum, limit cycles; NumPy and SciPy are welcome here."""

from __future__ import annotations

from ..plant.parameters import DrillstringParameters
from .cycle.cycle import limit_cycle
from .stability.spectrum import critical_omega, rightmost_roots

__all__ = ["DrillstringParameters", "critical_omega", "limit_cycle", "rightmost_roots"]
