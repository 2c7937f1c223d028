"""Judge a run: what a law did with stick-slip, and at what price."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from cosim.recording.result import Result
from cosim.system.signals import FloatArray

WINDOW = 20.0
"""How long at the end what has settled is taken over [s]."""

_SLOWEST = 1e-9
_RATE, _LEAST_WEIGHT = 4.85e-9, 5e3
"""Rate of penetration a (WOB - W_0) v: a [m/(N rad)] and W_0 [N], as in the FMU Autodriller."""


@dataclass(frozen=True)
class Score:
    """Put a run into numbers.

    Attributes
    ----------
    time_to_free : float
        From when the law is switched on to when the bit is stuck last; infinite if it is in the window [s].
    stuck_fraction : float
        Part of the window in which the bit is stuck.
    ssi : float
        (max - min) / (2 mean) of the bit speed over the window; infinite without a mean.
    mean_bit_speed, mean_top_speed : float
        Over the window [rad/s]. A law that makes up for the slip of the drive turns the top faster.
    peak_bit_speed, least_bit_speed : float
        Since the law is switched on [rad/s]; a negative one is reverse rotation.
    greatest_torque : float
        Of the drive on the string, since then [N m].
    drive_swing : float
        Greatest less least speed of the drive over the window [rad/s].
    dip : float
        Greatest loss of bit speed while the weight rises and a window on [rad/s]; NaN where it is there from the start.
    penetration : float
        Rate of penetration over the window [m/h].
    energy_per_turn : float
        What the drive puts in while the bit turns once, over the window [kJ]; infinite if it does not turn.
    switched : bool
        The law was switched on in full stick-slip; one without a switch acts from rest.
    failure : str
        Why there is no such number; empty if there is.
    """

    time_to_free: float = math.nan
    stuck_fraction: float = math.nan
    ssi: float = math.nan
    mean_bit_speed: float = math.nan
    mean_top_speed: float = math.nan
    peak_bit_speed: float = math.nan
    least_bit_speed: float = math.nan
    greatest_torque: float = math.nan
    drive_swing: float = math.nan
    dip: float = math.nan
    penetration: float = math.nan
    energy_per_turn: float = math.nan
    switched: bool = True
    failure: str = ""

    @property
    def free(self) -> bool:
        """Tell whether the bit is not stuck any more at the end."""
        return math.isfinite(self.time_to_free)

    def record(self) -> dict[str, Any]:
        """Return what a file holds."""
        return asdict(self)


COLUMNS = tuple(each.name for each in fields(Score))


def judge(result: Result, engaged: float, loaded: float | None, *, switched: bool = True) -> Score:
    """Judge a run of a plant called ``plant`` behind a drive called ``drive``.

    Parameters
    ----------
    result : Result
        The run.
    engaged : float
        From when on [s].
    loaded : float or None
        Until when the weight rises; None if it is there from the start.
    switched : bool
        The law was switched on then.
    """
    time: FloatArray = result.time
    column = {name.partition(".")[2]: _numbers(result, name) for name in result.names if name.startswith("plant.")}
    end = float(time[-1])
    first = int(np.searchsorted(time, engaged - 1e-9))
    start = int(np.searchsorted(time, end - WINDOW - 1e-9))
    since, window = slice(first + 1, None), slice(start + 1, None)
    duration = end - float(time[start])

    def gained(name: str) -> float:
        return float(column[name][-1] - column[name][start])

    mean = gained("bit_angle") / duration
    swing = float(column["bit_speed_max"][window].max() - column["bit_speed_min"][window].min())
    drive = _numbers(result, "drive.Omega")[window]
    turning = mean > _SLOWEST
    return Score(
        time_to_free=_time_to_free(column, first, start, float(time[first])),
        stuck_fraction=gained("stuck_time") / duration,
        ssi=swing / (2.0 * mean) if turning else math.inf,
        mean_bit_speed=mean,
        mean_top_speed=gained("top_angle") / duration,
        peak_bit_speed=float(column["bit_speed_max"][since].max()),
        least_bit_speed=float(column["bit_speed_min"][since].min()),
        greatest_torque=float(column["top_torque"][since].max()),
        drive_swing=float(drive.max() - drive.min()),
        dip=math.nan if loaded is None else _dip(time, column, first, loaded),
        penetration=3600.0 * _RATE * max(0.0, float(column["WOB"][-1]) - _LEAST_WEIGHT) * max(0.0, mean),
        energy_per_turn=2.0 * math.pi * gained("drive_work") / gained("bit_angle") / 1e3 if turning else math.inf,
        switched=switched,
    )


def _numbers(result: Result, name: str) -> FloatArray:
    """Return a column as numbers."""
    return np.asarray(result[name], dtype=np.float64)


def _time_to_free(column: dict[str, FloatArray], first: int, start: int, engaged: float) -> float:
    """Return how long after the law was switched on the bit was stuck last [s]."""
    stuck = column["stuck_time"]
    if stuck[-1] > stuck[start]:
        return math.inf
    return 0.0 if stuck[-1] == stuck[first] else float(column["last_release_time"][-1]) - engaged


def _dip(time: FloatArray, column: dict[str, FloatArray], first: int, loaded: float) -> float:
    """Return how much bit speed is lost while the weight rises and is new [rad/s]."""
    rising = (time > time[first]) & (time <= loaded + WINDOW)
    return float(column["bit_speed"][first] - column["bit_speed_min"][rising].min())
