"""A place along the string where speed, torque and angle are read: where two blocks begin to cross at whole blocks.

On the way of the place through a cell of `models.plant.exchange`, r = s = x, the trapezoidal rule gives, with u and d
the waves before they cross and w = U + D,

    (1 + kappa x / 2) U = (1 - kappa x / 2) u - kappa (integral of d from 0 to x - kappa x^2 w)

and likewise D. In uniform rotation this is exact.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from ..numerics.quartic import integral, value
from .delay_line import DelayLine
from .exchange import back, forth, newest


class StationOutputs(NamedTuple):
    """Outputs of a station: speed [rad/s], torque [N m], and twist of the string above it [rad]."""

    speed: float
    torque: float
    twist: float


class Reading(NamedTuple):
    """Reading of a station.

    Attributes
    ----------
    up, down : float
        The waves there [rad/s].
    turned : float
        Integral of their sum since the begin of the block [rad/s blocks].
    """

    up: float
    down: float
    turned: float


def read(up: DelayLine, above: int, down: DelayLine, below: int, fraction: float, strength: float) -> Reading:
    """Read at a fraction of the block where the blocks that begin at two places of the rings cross.

    Parameters
    ----------
    up, down : DelayLine
        The waves.
    above, below : int
        Places in their rings.
    fraction : float
        Of the block.
    strength : float
        kappa.
    """
    u, u_turned = _wave(up, above, fraction)
    d, d_turned = _wave(down, below, fraction)
    half = 0.5 * strength * fraction
    after, before = 1.0 + half, 1.0 - half
    bend = strength * fraction * (strength * fraction)
    speed = (before * (u + d) - strength * (u_turned + d_turned)) / (after - 2.0 * bend)
    return Reading(
        up=(before * u - (strength * d_turned - bend * speed)) / after,
        down=(before * d - (strength * u_turned - bend * speed)) / after,
        turned=(u_turned + d_turned) / (1.0 + 2.0 * half),
    )


def _wave(line: DelayLine, index: int, fraction: float) -> tuple[float, float]:
    """Return the wave at a fraction of a block, from the left, and its integral from the begin of the block."""
    total = 0.0
    while line.pieces[index][1] < fraction:
        begin, end, wave, _ = line.pieces[index]
        total = total + (end - begin) * integral(wave, 1.0)
        index = index + 1 if index + 1 < len(line.pieces) else 0
    begin, end, wave, _ = line.pieces[index]
    x = (fraction - begin) / (end - begin)
    return value(wave, x), total + (end - begin) * integral(wave, x)


class _Station:
    """Begins of the two blocks of a station in the rings, and its angle at the begin of the block [rad]."""

    __slots__ = ("above", "angle", "below")

    def __init__(self, angle: float) -> None:
        self.above = self.below = 0
        self.angle = angle


class Stations:
    """The stations of a string.

    Parameters
    ----------
    parts : int
        Parts into which they divide the string.
    strength : float
        kappa.
    angles : list of float
        Their angles at the start [rad].
    """

    def __init__(self, parts: int, strength: float, angles: list[float]) -> None:
        self.parts = parts
        self.strength = strength
        self._stations = [_Station(angle) for angle in angles]

    def __iter__(self) -> Iterator[object]:
        """Return an iterator over what changes in time."""
        return iter(self._stations)

    def find(self, up: DelayLine, down: DelayLine) -> None:
        """Find in the full lines where the blocks begin that cross at the stations at the start."""
        if not self._stations:
            return
        distance = (up.count - up.breaks) // self.parts
        above, below = up.first, forth(down, newest(down))
        for station in self._stations:
            for _ in range(distance):
                above = forth(up, above)
                below = back(down, below)
            station.above = above
            station.below = below

    def move(self, up: DelayLine, down: DelayLine) -> None:
        """Move on to the blocks that cross at the stations next, when the lines have moved by a block."""
        for station in self._stations:
            station.above = forth(up, station.above)
            station.below = forth(down, station.below)

    def read(self, up: DelayLine, down: DelayLine, fraction: float) -> list[tuple[float, Reading]]:
        """Return for each station its angle at the begin of the block and what it reads at a fraction of it."""
        return [(s.angle, read(up, s.above, down, s.below, fraction, self.strength)) for s in self._stations]

    def turn(self, up: DelayLine, down: DelayLine, duration: float) -> None:
        """Go to the end of the block, which has a duration [s]."""
        for station, (angle, reading) in zip(self._stations, self.read(up, down, 1.0), strict=True):
            station.angle = angle + duration * reading.turned

    def state(self) -> list[list[Any]]:
        """Return everything that changes in time, as plain data."""
        return [[station.above, station.below, station.angle] for station in self._stations]

    def restore(self, state: list[list[Any]]) -> None:
        """Take a state of :meth:`state` back."""
        for station, saved in zip(self._stations, state, strict=True):
            station.above, station.below, station.angle = saved
