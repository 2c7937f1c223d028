"""One period of a cycle cut into pieces, on each of which the bit speed is a polynomial.

The bit speed has a kink where the bit stops, and a weaker one where it breaks loose. Both come back with every round
trip of the waves, fainter by Upsilon each time. Pieces end at all of them that matter, so that no polynomial has to
follow a kink. Their places depend on when the bit slips, and so on the cycle that is looked for; the derivatives of
all places are kept with them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from math import ceil, floor, log

import numpy as np

from ...plant.parameters import DrillstringParameters
from ..numerics.arrays import FloatArray, IntArray
from ..numerics.interpolation import chebyshev

DEGREE = 10
"""Of the bit speed on a piece."""
BINS = 64
"""Parts of a slip whose pieces have limits of their own."""
NARROWEST = 1e-7
"""Of two cuts closer than this [s], the fainter is left out."""


@dataclass(frozen=True)
class Timing:
    """Hold the times at which the bit slips in a period, which begins with its breaking loose.

    Attributes
    ----------
    slips : int
        Slips in a period; 0 if the bit never rests.
    vector : ndarray, shape (2 slips,), or (1,) without slips
        All releases but the first, which is at 0, then all stops, then the period [s].
    """

    slips: int
    vector: FloatArray

    @property
    def period(self) -> float:
        """In s."""
        return float(self.vector[-1])

    @property
    def releases(self) -> FloatArray:
        """Shape (slips,) [s]."""
        return np.concatenate([np.zeros(min(self.slips, 1)), self.vector[: max(self.slips - 1, 0)]])

    @property
    def stops(self) -> FloatArray:
        """Shape (slips,) [s]."""
        return self.vector[max(self.slips - 1, 0) : -1]

    @property
    def stuck(self) -> float:
        """Time for which the bit rests in a period [s]."""
        return self.period - float((self.stops - self.releases).sum()) if self.slips else 0.0

    @property
    def ordered(self) -> bool:
        """Tell whether every slip ends after it begins and before the next."""
        marks = np.stack([self.releases, self.stops], axis=1).ravel()
        return bool((np.diff([*marks, self.period]) > 0.0).all()) and self.period > 0.0

    @cached_property
    def derivatives(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Derivatives of releases, stops and period by the vector."""
        rows = np.eye(self.vector.size)
        first = np.zeros((min(self.slips, 1), self.vector.size))
        releases = np.concatenate([first, rows[: max(self.slips - 1, 0)]])
        return releases, rows[max(self.slips - 1, 0) : -1], rows[-1]


@dataclass(frozen=True)
class Resolution:
    """Fineness with which a period is cut.

    Attributes
    ----------
    limits : ndarray, shape (slips, BINS), or (1, BINS) without slips
        What no piece in each part of a slip may exceed [s]; the parts of a slip are of one length.
    faintest_stop, faintest_release : float
        Echoes of a stop and of a release are followed while more of them than this is left.
    """

    limits: FloatArray
    faintest_stop: float
    faintest_release: float

    @classmethod
    def fine(cls, slips: int, longest: float) -> Resolution:
        """Return limits [s] that are the same everywhere, and echoes for periods good to about 1e-11 s."""
        return cls(np.full((max(slips, 1), BINS), longest), 1e-10, 1e-7)

    @classmethod
    def coarse(cls, slips: int, longest: float) -> Resolution:
        """Return limits [s] that are the same everywhere, and echoes for periods good to about 1e-8 s."""
        return cls(np.full((max(slips, 1), BINS), longest), 1e-5, 1e-3)


@dataclass(frozen=True)
class Cut:
    """A place where pieces meet: time [s], what is left there of the event it echoes, derivatives by the timing."""

    time: float
    strength: float
    by_timing: FloatArray


@dataclass(frozen=True)
class CycleMesh:
    """The pieces of all slips, in order of time.

    The unknowns are the values at all nodes but the first of each slip, where the speed is zero; pieces that meet
    share theirs. If the bit never rests, the last is the first.

    Attributes
    ----------
    timing : Timing
        When the bit slips.
    resolution : Resolution
        How finely it was cut.
    starts, lengths : ndarray, shape (pieces,)
        In s.
    starts_by, lengths_by : ndarray, shape (pieces, timing.vector.size)
        Their derivatives.
    slip : ndarray of int, shape (pieces,)
        The slip a piece belongs to.
    columns : ndarray of int, shape (pieces, DEGREE + 1)
        Place of the value at each node among the unknowns; -1 for a speed of zero.
    """

    timing: Timing
    resolution: Resolution
    starts: FloatArray
    lengths: FloatArray
    starts_by: FloatArray
    lengths_by: FloatArray
    slip: IntArray
    columns: IntArray

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self.starts.size * DEGREE

    @cached_property
    def node_times(self) -> FloatArray:
        """Times of the unknowns [s], shape (size,)."""
        nodes = chebyshev(DEGREE).nodes[1:]
        return (self.starts[:, None] + self.lengths[:, None] * nodes).ravel()

    def spread(self, places: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the times of places in [0, 1] of every piece, and their derivatives, piece by piece."""
        times = self.starts[:, None] + self.lengths[:, None] * places
        by_timing = self.starts_by[:, None, :] + places[:, None] * self.lengths_by[:, None, :]
        return times.ravel(), by_timing.reshape(times.size, -1)

    def nodal(self, values: FloatArray) -> FloatArray:
        """Return the values at all nodes of the pieces, shape (pieces, DEGREE + 1)."""
        return np.append(values, 0.0)[self.columns]

    def locate(self, times: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the piece that holds each time of the period, -1 while the bit rests, and the place in it."""
        piece = np.searchsorted(self.starts, times, side="right") - 1
        inside = (piece >= 0) & (times <= self.starts[piece] + self.lengths[piece])
        place = np.where(inside, (times - self.starts[piece]) / self.lengths[piece], 0.0)
        return np.where(inside, piece, -1), np.minimum(place, 1.0)

    def sample(self, values: FloatArray, times: FloatArray) -> FloatArray:
        """Return the bit speed at times of the period [rad/s]."""
        piece, place = self.locate(times)
        speeds = np.einsum("ij,ij->i", chebyshev(DEGREE).at(place), self.nodal(values)[piece])
        return np.where(piece >= 0, speeds, 0.0)

    def moved(self, change: FloatArray) -> CycleMesh:
        """Return the same pieces where they are after a change of the timing's vector."""
        return replace(
            self,
            timing=Timing(self.timing.slips, self.timing.vector + change),
            starts=self.starts + self.starts_by @ change,
            lengths=self.lengths + self.lengths_by @ change,
        )


def cycle_mesh(parameters: DrillstringParameters, timing: Timing, resolution: Resolution) -> CycleMesh:
    """Return the pieces for a timing."""
    releases_by, stops_by, period_by = timing.derivatives
    if not timing.slips:
        ends = [Cut(0.0, 1.0, 0.0 * period_by), Cut(timing.period, 1.0, period_by)]
        return _assembled(timing, resolution, [ends])
    echoes = echo_cuts(parameters, timing, resolution)
    slips = zip(timing.releases.tolist(), releases_by, timing.stops.tolist(), stops_by, strict=True)
    cuts: list[list[Cut]] = []
    for release, release_by, stop, stop_by in slips:
        inner = [cut for cut in echoes if release < cut.time < stop]
        cuts.append(thinned([Cut(release, 1.0, release_by), *inner, Cut(stop, 1.0, stop_by)]))
    return _assembled(timing, resolution, cuts)


def bins(start: float, end: float) -> slice:
    """Return the parts of a slip that a piece touches, given the shares of the slip at which it starts and ends."""
    return slice(min(floor(start * BINS), BINS - 1), min(ceil(end * BINS), BINS - 1) + 1)


def echo_cuts(parameters: DrillstringParameters, timing: Timing, resolution: Resolution) -> list[Cut]:
    """Return all echoes that are followed in a period, in order of time."""
    round_trip, reflection = 2.0 * parameters.travel_time, abs(parameters.reflection)
    releases_by, stops_by, period_by = timing.derivatives
    events = [(time, by, resolution.faintest_stop) for time, by in zip(timing.stops.tolist(), stops_by, strict=True)]
    events += [
        (time, by, resolution.faintest_release) for time, by in zip(timing.releases.tolist(), releases_by, strict=True)
    ]
    cuts: list[Cut] = []
    for time, by_timing, faintest in events:
        for k in range(1, floor(log(faintest) / log(reflection)) + 1 if reflection else 1):
            periods = floor((time + k * round_trip) / timing.period)
            place = time + k * round_trip - periods * timing.period
            cuts.append(Cut(place, reflection**k, by_timing - periods * period_by))
    return sorted(cuts, key=lambda cut: cut.time)


def thinned(cuts: list[Cut]) -> list[Cut]:
    """Return cuts in order of time without the fainter of any two that are too close."""
    kept: list[Cut] = []
    for cut in cuts:
        if kept and cut.time - kept[-1].time < NARROWEST:
            if cut.strength <= kept[-1].strength:
                continue
            kept.pop()
        kept.append(cut)
    return kept


def _assembled(timing: Timing, resolution: Resolution, slips: list[list[Cut]]) -> CycleMesh:
    starts: list[float] = []
    lengths: list[float] = []
    starts_by: list[FloatArray] = []
    lengths_by: list[FloatArray] = []
    slip: list[int] = []
    for number, cuts in enumerate(slips):
        begin, whole = cuts[0].time, cuts[-1].time - cuts[0].time
        for left, right in pairwise(cuts):
            part = bins((left.time - begin) / whole, (right.time - begin) / whole)
            count = max(1, ceil((right.time - left.time) / float(resolution.limits[number, part].min())))
            step, step_by = (right.time - left.time) / count, (right.by_timing - left.by_timing) / count
            starts += [left.time + k * step for k in range(count)]
            starts_by += [left.by_timing + k * step_by for k in range(count)]
            lengths += [step] * count
            lengths_by += [step_by] * count
            slip += [number] * count
    columns = np.arange(-1, DEGREE) + DEGREE * np.arange(len(starts))[:, None]
    first = np.flatnonzero(np.diff(slip, prepend=-1))
    columns[first, 0] = -1 if timing.slips else columns[-1, -1]
    return CycleMesh(
        timing=timing,
        resolution=resolution,
        starts=np.array(starts),
        lengths=np.array(lengths),
        starts_by=np.array(starts_by),
        lengths_by=np.array(lengths_by),
        slip=np.array(slip),
        columns=columns,
    )
