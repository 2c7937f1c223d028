"""Bit speed and torque from the top of the string: exactly, one travel time late, for a string without damping.

The wave that comes up left the bit a travel time ago, as the one arrived there that was sent down two travel times ago.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..numerics.low_pass import low_pass

MOST_SAMPLES = 1024
"""Of the wave sent down that are kept."""
SPACING = 1000.0
"""Samples nearer to each other than this part of the history are kept as one."""
STEEPER = 4.0
"""A sample that is further from the one before than so many times that one was, is taken for a jump."""
ON_TIME = 1e-9
"""A history shorter by this part counts as known."""


class Sample(NamedTuple):
    """The wave sent down at a time, whether it had jumped, and how far it was from the one before [s, rad/s]."""

    time: float
    down: float
    jumped: float
    change: float


class Observed(NamedTuple):
    """State of an observer.

    Attributes
    ----------
    clock : float
        Since the start [s].
    up, up_change : float
        The wave that comes up, and what it has changed by in the last step [rad/s].
    delayed : float
        The wave that was sent down two travel times ago [rad/s].
    valid : float
        1 if that is known and no jump is near.
    speed, torque : float
        Bit speed and torque of the string at the bit through the filter [rad/s, N m].
    samples : tuple of Sample
        What was sent down, from two travel times ago on.
    """

    clock: float
    up: float
    up_change: float
    delayed: float
    valid: float
    speed: float
    torque: float
    samples: tuple[Sample, ...]


@dataclass(frozen=True)
class BitSpeedObserver:
    """An observer of what the bit does.

    Attributes
    ----------
    impedance, travel_time, inertia : float
        Z [N m s/rad], Gamma [s] and I_B [kg m^2] of the string.
    filter_time : float
        Of the torque on bit, above 0 [s].
    jump : float
        Changes below this are no jumps [rad/s].
    """

    impedance: float
    travel_time: float
    inertia: float
    filter_time: float
    jump: float

    def begin(self, speed: float, torque: float) -> Observed:
        """Return the state in which the top has turned so for ever, which is not known to be true."""
        up, down = self.up(speed, torque), self.down(speed, torque)
        return Observed(0.0, up, 0.0, down, 0.0, speed, torque, (Sample(0.0, down, 0.0, 0.0),))

    def up(self, speed: float, torque: float) -> float:
        """Return the wave that comes up [rad/s]."""
        return (speed - torque / self.impedance) * 0.5

    def down(self, speed: float, torque: float) -> float:
        """Return the wave sent down [rad/s]."""
        return (speed + torque / self.impedance) * 0.5

    def advance(self, before: Observed, speed: float, torque: float, elapsed: float) -> Observed:
        """Return the state after `elapsed` seconds, at whose end speed and torque at the top are as given."""
        clock = before.clock + elapsed
        late = 2.0 * self.travel_time
        up = self.up(speed, torque)
        samples = list(self._kept(before.samples, clock, self.down(speed, torque), late))
        target = clock - late
        while len(samples) > 3 and samples[2].time <= target:
            del samples[0]
        place = 1 if len(samples) > 2 and samples[1].time <= target else 0
        first, second, *after = samples[place:]
        if target <= first.time:
            delayed = first.down
        else:
            share = (target - first.time) / (second.time - first.time)
            delayed = first.down + share * (second.down - first.down)
        change = up - before.up
        jumped = self._jumps(change, before.up_change) or first.jumped != 0.0 or second.jumped != 0.0
        if after and after[0].jumped != 0.0:
            jumped = True
        oldest = samples[0].time
        known = target >= oldest - ON_TIME * late and clock >= late * (1.0 - ON_TIME)
        found = up + delayed
        pull = self.impedance * (delayed - up)
        smooth_speed = low_pass(before.speed, found, 0.0, elapsed, self.filter_time)
        smooth_torque = low_pass(before.torque, pull, 0.0, elapsed, self.filter_time)
        valid = float(known and not jumped)
        return Observed(clock, up, change, delayed, valid, smooth_speed, smooth_torque, tuple(samples))

    def bit_torque(self, state: Observed, bit_speed: float) -> float:
        """Return the torque on bit, the string's less what turns the bit faster, filtered [N m]."""
        return state.torque - self.inertia * ((bit_speed - state.speed) / self.filter_time)

    def _kept(self, samples: tuple[Sample, ...], clock: float, down: float, late: float) -> tuple[Sample, ...]:
        """Return the samples with one more, or the newest renewed if that is too near."""
        last = samples[-1]
        change = down - last.down
        jumped = last.change != 0.0 and self._jumps(change, last.change)
        if len(samples) > 1 and last.time - samples[-2].time < late / SPACING * (1.0 - ON_TIME):
            change = down - samples[-2].down
            return (*samples[:-1], Sample(clock, down, float(jumped or last.jumped != 0.0), change))
        return (*samples, Sample(clock, down, float(jumped), change))

    def _jumps(self, change: float, before: float) -> bool:
        size = change if change >= 0.0 else -change
        least = STEEPER * (before if before >= 0.0 else -before)
        return size > self.jump and size > least
