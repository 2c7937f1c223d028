"""FMUs in processes of their own, and what they may use there."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Limits:
    """Time and memory that an isolated FMU may use.

    Parameters
    ----------
    time : float
        For each call into it, s.
    memory : float
        Beyond what its process holds before it is loaded, bytes. On Linux all that descends from the process counts;
        on macOS it counts alone, on Windows nobody counts.
    """

    time: float = 60.0
    memory: float = 4e9
