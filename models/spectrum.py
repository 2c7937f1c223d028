"""The spectrum of the running equilibrium, at its older address: `models.theory.stability.spectrum`."""

from .theory.stability.spectrum import (
    CriticalPoint,
    critical_omega,
    critical_point,
    critical_slope,
    critical_wob,
    rightmost_roots,
    roots_about,
    spectral_abscissa,
    unstable_count,
)

__all__ = [
    "CriticalPoint",
    "critical_omega",
    "critical_point",
    "critical_slope",
    "critical_wob",
    "rightmost_roots",
    "roots_about",
    "spectral_abscissa",
    "unstable_count",
]
