"""What users would otherwise do: careful simulations of the same plant with other tools, to be timed side by side.

``PEERS`` holds the cases to time, each a peer at the coarsest resolution that finds the period of the stick-slip cycle
within an error. A resolution counts only if every finer one tried is within it too, so that none is picked by luck.
``RECORDED`` holds single runs of cases too slow to repeat.
"""

from .cycle import CYCLES, REFERENCE_PERIOD, Slips, cycle_stops, limit_cycle_period, period_error
from .table import END_TIME, PEERS, RECORDED, Case, Recorded

__all__ = [
    "CYCLES",
    "END_TIME",
    "PEERS",
    "RECORDED",
    "REFERENCE_PERIOD",
    "Case",
    "Recorded",
    "Slips",
    "cycle_stops",
    "limit_cycle_period",
    "period_error",
]
