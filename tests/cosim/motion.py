"""A bit that sticks and slips by formula: each slip is half a sine, so every measure is known in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cosim.recording.result import Result


@dataclass(frozen=True)
class Slip:
    """Released at `release`, stopped at `stop`, s; the greatest speed in between is `peak`, rad/s."""

    release: float
    stop: float
    peak: float

    def speed(self, t: float) -> float:
        inside = self.release < t < self.stop
        return self.peak * math.sin(math.pi * (t - self.release) / (self.stop - self.release)) if inside else 0.0

    def angle(self, t: float) -> float:
        part = min(1.0, max(0.0, (t - self.release) / (self.stop - self.release)))
        return self.peak * (self.stop - self.release) / math.pi * (1.0 - math.cos(math.pi * part))

    def greatest(self, start: float, end: float) -> float:
        middle = 0.5 * (self.release + self.stop)
        return self.peak if start <= middle <= end else max(self.speed(start), self.speed(end))

    def duration_until(self, t: float) -> float:
        return min(max(t - self.release, 0.0), self.stop - self.release)


def record(slips: list[Slip], times: np.ndarray) -> Result:
    """What a plant would put out at the communication points `times`."""
    names = (
        "bit_speed", "bit_angle", "bit_speed_max", "bit_speed_min", "stuck_time", "last_stop_time",
        "last_release_time", "slip_count", "bit_stuck",
    )  # fmt: skip
    rows = []
    for before, t in zip([times[0], *times[:-1]], times, strict=True):
        rows.append(
            (
                sum(slip.speed(t) for slip in slips),
                sum(slip.angle(t) for slip in slips),
                max(slip.greatest(before, t) for slip in slips),
                0.0,
                t - times[0] - sum(slip.duration_until(t) for slip in slips),
                max([times[0], *(slip.stop for slip in slips if slip.stop <= t)]),
                max([times[0], *(slip.release for slip in slips if slip.release <= t)]),
                sum(slip.release <= t for slip in slips),
                not any(slip.release <= t < slip.stop for slip in slips),
            )
        )
    columns = {f"plant.{name}": np.array(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)}
    return Result(times, columns, dict.fromkeys(columns, ""))


def cycle(period: float, pattern: list[Slip], count: int) -> list[Slip]:
    """Repeat slips within a period."""
    shifts = [index * period for index in range(count)]
    return [Slip(slip.release + shift, slip.stop + shift, slip.peak) for shift in shifts for slip in pattern]
