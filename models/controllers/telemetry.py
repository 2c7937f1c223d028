"""A value sent from downhole in frames of bits: late, coarse, and now and then lost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..numerics.noise import uniform

MOST_UNDER_WAY = 256
"""Frames that can be under way at a time."""
MOST_FRAMES = 1e6
"""In one step."""
ON_TIME = 1e-6
"""What happens within this part of the time between frames after the end of a step, happens at it."""
ROUNDING = 1e-13
"""Of the clock, which is a sum of steps."""
LOST = -1.0


class Link(NamedTuple):
    """State of a link.

    Attributes
    ----------
    clock : float
        Since the start [s].
    sent, due : float
        Numbers of the frames that are sent and that arrive next.
    measured, stamp : float
        What has arrived last, and when it was sampled; -1 if nothing has [s].
    limited : float
        1 if that was at an end of the range.
    random : float
        State of the noise.
    codes : tuple of float
        Frames under way, by their number modulo their count; -1 if lost.
    """

    clock: float
    sent: float
    due: float
    measured: float
    stamp: float
    limited: float
    random: float
    codes: tuple[float, ...]


@dataclass(frozen=True)
class MudPulse:
    """A link from downhole.

    Attributes
    ----------
    interval, latency : float
        Between frames, and from a sample to its arrival [s].
    least, extent : float
        Least value that is sent, and range above it.
    steps : float
        Quanta in the range.
    loss : float
        Probability that a frame is lost.
    """

    interval: float
    latency: float
    least: float
    extent: float
    steps: float
    loss: float

    def begin(self, value: float, seed: int) -> Link:
        """Return a link that has taken its first sample."""
        empty = Link(0.0, 0.0, 0.0, self.least, -1.0, 0.0, float(seed), (0.0,) * MOST_UNDER_WAY)
        return self._sampled(empty, value)

    def advance(self, link: Link, value: float, slope: float, elapsed: float) -> Link:
        """Return the link after `elapsed` seconds; ValueError if too many frames are sent in them."""
        if elapsed > MOST_FRAMES * self.interval:
            raise ValueError(f"a step of {elapsed!r} s has more than 1e+06 frames; expected fewer")
        begin, end = link.clock, link.clock + elapsed
        late = end + (ON_TIME * self.interval + ROUNDING * end)
        while True:
            sample = link.sent * self.interval
            arrival = link.due * self.interval + self.latency
            if link.due < link.sent and arrival <= sample and arrival <= late:
                link = self._arrived(link)
            elif sample <= late:
                link = self._sampled(link, value + slope * (sample - begin))
            elif link.due < link.sent and arrival <= late:
                link = self._arrived(link)
            else:
                return link._replace(clock=end)

    def _sampled(self, link: Link, value: float) -> Link:
        code = (value - self.least) / self.extent * self.steps
        code = self.steps if code > self.steps else 0.0 if code < 0.0 else float(int(code + 0.5))
        drawn, random = uniform(link.random)
        place = int(link.sent) % MOST_UNDER_WAY
        codes = (*link.codes[:place], LOST if drawn < self.loss else code, *link.codes[place + 1 :])
        return link._replace(sent=link.sent + 1.0, random=random, codes=codes)

    def _arrived(self, link: Link) -> Link:
        code = link.codes[int(link.due) % MOST_UNDER_WAY]
        stamp = link.due * self.interval
        link = link._replace(due=link.due + 1.0)
        if code == LOST:
            return link
        measured = self.least + self.extent * (code / self.steps)
        return link._replace(measured=measured, stamp=stamp, limited=float(code in (0.0, self.steps)))

    def age(self, link: Link) -> float:
        """Return how old the value is; before the first one, how long none has come [s]."""
        return link.clock - link.stamp if link.stamp >= 0.0 else link.clock

    def valid(self, link: Link) -> bool:
        """Return whether a value has come, and none that should have come after it was lost."""
        return link.stamp >= 0.0 and (link.due - 1.0) * self.interval <= link.stamp + ON_TIME * self.interval
