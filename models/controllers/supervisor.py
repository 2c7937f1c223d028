"""Supervise stick-slip: its severity is measured downhole over a window, and a set point raised while it is great."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

BINS = 40
"""Parts of the window."""
MOST_PARTS = 1e4
"""Parts and decisions in one step."""
ON_TIME = 1e-6
"""What happens within this part of the time between two of a kind after the end of a step, happens at it."""
ROUNDING = 1e-13
"""Of the clock, which is a sum of steps."""


class Supervision(NamedTuple):
    """State of a supervisor.

    Attributes
    ----------
    clock : float
        Since the start [s].
    parts : float
        Number of parts of windows that are complete.
    low, high, turned : float
        Least and greatest bit speed [rad/s] and angle turned [rad] in the part that is not.
    severity : float
        Of the last window that was complete.
    speed : float
        Set point [rad/s].
    decisions : float
        Number of decisions.
    limited : float
        1 if the last raise was cut.
    lows, highs, angles : tuple of float
        Of the parts of a window, by their number modulo their count.
    """

    clock: float
    parts: float
    low: float
    high: float
    turned: float
    severity: float
    speed: float
    decisions: float
    limited: float
    lows: tuple[float, ...]
    highs: tuple[float, ...]
    angles: tuple[float, ...]


class Reading(NamedTuple):
    """Hold what a supervisor is given: bit speed [rad/s] and slope [rad/s^2], what arrives at the top, its switch."""

    bit_speed: float
    slope: float
    measured: float
    valid: bool
    enabled: bool


@dataclass(frozen=True)
class SpeedSupervisor:
    """A meter of severity downhole, and a driller who raises the speed by what arrives.

    Attributes
    ----------
    window : float
        Time over which the severity is taken [s].
    most : float
        Greatest severity that is told.
    threshold : float
        Severity above which the speed is raised.
    interval : float
        Time between decisions [s].
    step, limit : float
        By how much the speed is raised, and how far at most [rad/s].
    """

    window: float
    most: float
    threshold: float
    interval: float
    step: float
    limit: float

    @property
    def width(self) -> float:
        """Length of a part of the window [s]."""
        return self.window / BINS

    def begin(self, bit_speed: float, speed: float) -> Supervision:
        """Return a supervisor that knows nothing yet, at a set point."""
        none = (0.0,) * BINS
        return Supervision(0.0, 0.0, bit_speed, bit_speed, 0.0, 0.0, speed, 0.0, 0.0, none, none, none)

    def advance(self, state: Supervision, given: Reading, elapsed: float) -> Supervision:
        """Return the supervisor after `elapsed` seconds; ValueError if too much would happen in them."""
        width, least = self.width, self.width if self.width < self.interval else self.interval
        if elapsed > MOST_PARTS * least:
            longest = MOST_PARTS * least
            raise ValueError(f"a step of {elapsed!r} s cannot be followed; expected at most {longest!r} s")
        start, end = state.clock, state.clock + elapsed
        at, late = start, end + (ON_TIME * width + ROUNDING * end)
        while (state.parts + 1.0) * width <= late:
            boundary = (state.parts + 1.0) * width
            first, last = (
                given.bit_speed + given.slope * (at - start),
                given.bit_speed + given.slope * (boundary - start),
            )
            state = self._closed(_taken(state, first, last, boundary - at), last)
            at = boundary
        if end > at:
            first, last = given.bit_speed + given.slope * (at - start), given.bit_speed + given.slope * elapsed
            state = _taken(state, first, last, end - at)
        late = end + (ON_TIME * self.interval + ROUNDING * end)
        while (state.decisions + 1.0) * self.interval <= late:
            state = self._decided(state, given)
        return state._replace(clock=end)

    def _closed(self, state: Supervision, last: float) -> Supervision:
        """Take up the next part of the window, which begins at a speed, and measure if a window is complete."""
        place = int(state.parts) % BINS
        lows, highs, angles = list(state.lows), list(state.highs), list(state.angles)
        lows[place], highs[place], angles[place] = state.low, state.high, state.turned
        parts = state.parts + 1.0
        severity = self._severity(lows, highs, angles) if parts >= BINS else 0.0
        return state._replace(
            parts=parts, low=last, high=last, turned=0.0, severity=severity,
            lows=tuple(lows), highs=tuple(highs), angles=tuple(angles),
        )  # fmt: skip

    def _severity(self, lows: list[float], highs: list[float], angles: list[float]) -> float:
        """Return (max - min) / (2 mean) of a window, at most `most`, which is told too where the bit does not turn."""
        low, high, turned = lows[0], highs[0], 0.0
        for place in range(BINS):
            low = lows[place] if lows[place] < low else low
            high = highs[place] if highs[place] > high else high
            turned = turned + angles[place]
        twice = 2.0 * (turned / self.window)
        swing = high - low
        return swing / twice if twice > 0.0 and swing <= self.most * twice else self.most

    def _decided(self, state: Supervision, given: Reading) -> Supervision:
        """Raise the speed, if what has arrived says so."""
        raised = given.enabled and given.valid and given.measured > self.threshold
        wanted = state.speed + self.step if raised else state.speed
        limited = wanted > self.limit
        speed = self.limit if limited else wanted
        return state._replace(speed=speed, decisions=state.decisions + 1.0, limited=float(limited))


def _taken(state: Supervision, first: float, last: float, duration: float) -> Supervision:
    """Count a straight line of speed among the part of the window that is not complete."""
    low, high = state.low, state.high
    low = first if first < low else low
    low = last if last < low else low
    high = first if first > high else high
    high = last if last > high else high
    return state._replace(low=low, high=high, turned=state.turned + 0.5 * (first + last) * duration)
