"""A first approximation of a stick-slip cycle: a short run of the plant on coarse cells."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import ceil

import numpy as np

from ...plant.neutral import DrillstringNeutral
from ...plant.parameters import DrillstringParameters
from ..stability.torque_curve import TorqueCurve
from .equations import Orbit
from .mesh import Resolution, Timing, cycle_mesh

CELLS = 48
LONGEST_RUN = 400
"""In travel times."""
QUIET = 150
"""Travel times without a stop after which none is waited for."""
MOST_SLIPS = 8
REPEATS = 1e-5
"""Intervals between stops repeat if they differ by less than this part of the period."""
RAMP_FROM = 1.5
"""Times the drive speed that the static torque can hold: there a bit from rest sticks and slips."""
SETTLING, RAMPING = 100, 200
"""Travel times before and on a ramp of the drive."""


@dataclass
class Run:
    """A run of the plant from rest, whose stops and releases are written down.

    Attributes
    ----------
    plant : DrillstringNeutral
        What runs.
    step : float
        Between looks [s].
    steps : int
        Taken.
    time, speed : float
        The present [s] and the bit speed [rad/s].
    stops, releases : list of float
        In s.
    """

    plant: DrillstringNeutral
    step: float
    time: float = 0.0
    speed: float = 0.0
    steps: int = 0
    stops: list[float] = field(default_factory=list[float])
    releases: list[float] = field(default_factory=list[float])

    @property
    def quiet(self) -> float:
        """Time since the last stop [s], since the beginning if there was none."""
        return self.time - (self.stops[-1] if self.stops else 0.0)

    def advance(self) -> None:
        """Take a step."""
        self.steps += 1
        self.time = self.steps * self.step
        self.plant.advance(self.time)
        outputs = self.plant.outputs()
        self.speed = outputs.bit_speed
        for found, last in ((self.releases, outputs.last_release_time), (self.stops, outputs.last_stop_time)):
            if last > (found[-1] if found else 0.0):
                found.append(last)

    def slips_per_period(self, since: float) -> int | None:
        """Return after how many stops the intervals between those after `since` repeat; None if they do not."""
        intervals = np.diff([stop for stop in self.stops if stop > since])
        for count in range(1, min(MOST_SLIPS, intervals.size // 2) + 1):
            last, before = intervals[-count:], intervals[-2 * count : -count]
            if np.abs(last - before).max() <= REPEATS * last.sum():
                return count
        return None

    def until_periodic(self) -> int | None:
        """Run on until the stops repeat, and return how many there are in a period; None if they do not."""
        travel_time, since = self.step * CELLS, self.time
        while self.time < since + LONGEST_RUN * travel_time:
            known = len(self.stops)
            self.advance()
            if len(self.stops) > known and (count := self.slips_per_period(since)):
                return count
            if min(self.quiet, self.time - since) > QUIET * travel_time:
                return None
        return None

    def last_period(self, slips: int) -> tuple[Timing, float]:
        """Return the timing of the last period with so many stops, and when it began [s]."""
        end = self.stops[-1]
        stops = self.stops[-slips - 1 :]
        releases = [release for release in self.releases if stops[0] < release < end]
        if len(releases) != slips:
            raise ArithmeticError(f"{len(releases)} releases were seen between {slips + 1} stops; expected {slips}")
        waits = np.subtract(releases, stops[:-1])
        first = int(np.argmax(waits))
        period = end - stops[0]
        starts = np.array([*releases[first:], *(release + period for release in releases[:first])])
        ends = np.array([*stops[first + 1 :], *(stop + period for stop in stops[1 : first + 1])])
        begin = releases[first]
        return Timing(slips, np.array([*(starts[1:] - begin), *(ends - begin), period])), begin


def simulated_cycle(parameters: DrillstringParameters, omega: float, wob: float, longest: float) -> Orbit:
    """Return the cycle that a bit from rest comes to, as far as a coarse run shows it.

    If the bit from rest comes to turn steadily, the drive is started at a lower speed, at which it sticks and slips,
    and brought to its speed slowly: stick-slip then goes on as far as it can.

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    omega, wob : float
        Drive speed [rad/s] and weight on bit [N].
    longest : float
        Of a piece of the orbit [s].

    Raises
    ------
    ValueError
        The bit ends at rest, in steady rotation, or in a motion that does not repeat, or it turns backwards.
    """
    tried = _run(parameters, omega, wob, omega)
    slips = tried.until_periodic()
    slow = RAMP_FROM * TorqueCurve.of(parameters, wob).static / parameters.c_a
    if slips is None and tried.speed > 0.0 and omega > slow:
        tried = _run(parameters, slow, wob, omega)
        slips = tried.until_periodic()
    if slips is None:
        end = "rest" if tried.speed == 0.0 else "steady rotation"
        if tried.quiet < QUIET * parameters.travel_time:
            end = "a motion that does not repeat"
        raise ValueError(f"no stick-slip cycle found at Omega = {omega} rad/s, WOB = {wob} N: the bit ends in {end}")
    timing, begin = tried.last_period(slips)
    mesh = cycle_mesh(parameters, timing, Resolution.fine(slips, longest))
    values: list[float] = []
    for time in (mesh.node_times + (begin + ceil((tried.time - begin) / timing.period) * timing.period)).tolist():
        tried.plant.advance(time)
        values.append(tried.plant.outputs().bit_speed)
    if min(values) < 0.0:
        raise ValueError(f"the bit turns backwards in the cycle at Omega = {omega} rad/s, WOB = {wob} N")
    return Orbit(parameters, omega, wob, mesh, np.array(values))


def _run(parameters: DrillstringParameters, first: float, wob: float, omega: float) -> Run:
    """Return a run from rest in which the drive, if need be, has gone from a first speed to its own [rad/s]."""
    run = Run(
        DrillstringNeutral(parameters, None, CELLS, 0.0, first, wob),
        parameters.travel_time / CELLS,
    )
    if first == omega:
        return run
    while run.time < SETTLING * parameters.travel_time:
        run.advance()
    rise = (omega - first) / (RAMPING * parameters.travel_time)
    run.plant.set_inputs(first, wob, rise)
    while run.time < (SETTLING + RAMPING) * parameters.travel_time:
        run.advance()
    run.plant.set_inputs(omega, wob)
    return run
