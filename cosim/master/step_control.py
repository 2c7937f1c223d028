"""Vary the communication step size: reject steps and halve them, and double what goes well.

The regular communication points, and those at which a signal jumps or kinks, are always met. Between two of them steps
have the size of the distance, a half, a quarter, and so on, and begin at multiples of their size. So time is never a
sum of steps.

With a tolerance every step is taken twice, whole and in two halves, and the halves are kept. What is compared are the
values at the end and in the middle of the step, where the whole step had to assume them; in a system with travelling
waves an assumption that was wrong in the middle shows much later, or never at a communication point. Richardson's
extrapolation makes the error of the halves from the difference.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from cosim.errors import EndRequestError, LoopError, SlaveError
from cosim.master.communication_points import Grid, Points, within
from cosim.master.run import WindowRecord, window_size
from cosim.master.stepper import Stepper, Taken
from cosim.master.wiring import Channel, Node, Span
from cosim.recording.record import Window

log = logging.getLogger("cosim")

BEGIN, MIDDLE, END, WHOLE = range(4)
"""Rows: where a step begins and ends; the middle, where two halves meet; the end of a whole step beside them."""
ROWS = 4

DEEPEST = 10
"""The times a step can be halved: the smallest is a 1024th of the distance between regular points."""
_FINEST = 1 << DEEPEST
# A step that is kept is recorded as at most so many: two halves.
_LEGS = 2
# The size is doubled when the error should then still be this part of the tolerance.
_SAFE = 0.5


@dataclass
class Tally:
    """Count what happened in a run.

    Attributes
    ----------
    steps, rejected : int
        Communication steps that were kept, and that were taken back.
    sweeps, most_sweeps : int
        How often components were stepped for the kept steps, in sum and at most for one.
    largest_error, error_time : float
        Of the estimates, relative to the tolerance: the greatest, and their integral over time, s.
    missed : int
        Steps of the smallest size that were kept although their error exceeds the tolerance.
    unsolved : int
        Steps that were kept although a loop was not closed.
    first_unsolved : float, optional
        Time of the first of them, s.
    largest_residual : float
        Of the loops that were not closed, in the units of their variables.
    """

    steps: int = 0
    rejected: int = 0
    sweeps: int = 0
    most_sweeps: int = 0
    largest_error: float = 0.0
    error_time: float = 0.0
    missed: int = 0
    unsolved: int = 0
    first_unsolved: float | None = None
    largest_residual: float = 0.0

    def count(self, taken: Taken) -> None:
        """Count a step that is kept."""
        self.steps += 1
        self.sweeps += taken.sweeps
        self.most_sweeps = max(self.most_sweeps, taken.sweeps)
        if taken.unsolved is not None:
            if self.first_unsolved is None:
                log.warning("%s; going on", taken.unsolved)
                self.first_unsolved = taken.unsolved.time
            self.unsolved += 1
            self.largest_residual = max(self.largest_residual, taken.unsolved.residual)


@dataclass(frozen=True)
class _Leg:
    """A step that is to be kept: its rows, its time, and how it was taken."""

    begin: int
    end: int
    span: Span
    taken: Taken


class StepControl:
    """Takes the steps of a run on a stage, and records those that are kept.

    Parameters
    ----------
    grid : Grid
        Communication points that are met in any case.
    stepper : Stepper
        The algorithm.
    nodes : sequence of Node
        All components.
    saved : sequence of Node
        Those whose steps may be taken back.
    recording : WindowRecord
        Where kept steps are recorded.
    error : ErrorEstimate, optional
        Estimates errors; without it, steps are kept if they can be taken.
    halves : bool
        Whether a step in which a loop has no solution is halved.

    Attributes
    ----------
    tally : Tally
        What has happened.
    reached : float
        The end of the last step that was kept, s.
    end : EndRequestError, optional
        What a component has asked for in a step that was not taken then, nor in smaller ones.
    """

    def __init__(
        self,
        grid: Grid,
        stepper: Stepper,
        nodes: Sequence[Node],
        saved: Sequence[Node],
        recording: WindowRecord,
        error: ErrorEstimate | None,
        *,
        halves: bool,
    ) -> None:
        self.tally = Tally()
        self.reached = grid.start_time
        self.end: EndRequestError | None = None
        self._grid = grid
        self._stop_time = grid.end
        self._stepper = stepper
        self._nodes = tuple(nodes)
        self._saved = tuple(saved)
        self._recording = recording
        self._error = error
        self._halves = halves
        self._order = 1 if error is None else error.order
        self._tolerance = 0.0 if error is None else error.tolerance
        self._interval = self._place = self._level = 0
        self._deepest = DEEPEST if error is None else DEEPEST - 1

    def windows(self) -> Iterator[Window]:
        """Take all steps, or those before a component asks to end, and give each window when it is complete.

        Raises
        ------
        LoopError
            If a loop has no solution, and smaller steps are not to be tried or have not helped.
        SlaveError
            If a component refuses a step.
        """
        size = window_size(self._grid.steps)
        while self._interval < self._grid.steps and self.end is None:
            first, last = self._interval, min(self._interval + size, self._grid.steps)
            points = self._grid.points(first, last)
            self._recording.begin(self.tally.steps, BEGIN, self._now(points))
            while self._interval < last and self._recording.room >= _LEGS and self.end is None:
                try:
                    self._advance(points, self._interval - first)
                except EndRequestError as end:
                    self.end = end
            window = self._recording.window()
            if window.times.size > 1 or not window.first:
                yield window

    @property
    def done(self) -> float:
        """Return the part of the run that has been taken, from 0 to 1."""
        return (self._interval + self._place / _FINEST) / self._grid.steps

    def snapshot(self) -> dict[str, Any]:
        """Return where the run is between two windows, and what has happened, as JSON can hold it."""
        return {
            "interval": self._interval, "place": self._place, "level": self._level, "tally": asdict(self.tally),
        }  # fmt: skip

    def restore(self, notes: Mapping[str, Any]) -> None:
        """Be where a run was when it gave a snapshot."""
        self._interval, self._place, self._level = (int(notes[name]) for name in ("interval", "place", "level"))
        placed = 0 <= self._interval <= self._grid.steps and 0 <= self._place < _FINEST
        if not placed or not 0 <= self._level <= self._deepest:
            raise ValueError("a place is given that no run comes to")
        self.tally = Tally(**notes["tally"])

    def _now(self, points: Points) -> float:
        """Return the time that has been reached within the first interval of points, s."""
        return _span(points, 0, self._place, 0, self._stop_time).time if self._place else float(points.times[0])

    def _advance(self, points: Points, index: int) -> None:
        """Take a step from where the run is, if it can be taken; it is in an interval between two points."""
        while self._place % (_FINEST >> self._level):
            self._level += 1
        self._place += self._step(points, index, self._place)
        if self._place == _FINEST:
            self._interval, self._place = self._interval + 1, 0

    def _step(self, points: Points, index: int, place: int) -> int:
        """Try a step from a place between two regular points; return how far it went, 0 if it was taken back."""
        for node in self._saved:
            node.slave.save(0)
        try:
            error, legs = self._attempt(points, index, place)
        except (LoopError, SlaveError) as failure:
            if self._level == self._deepest or not self._recovers(failure):
                raise
            self._take_back_after(failure)
            return 0
        if error > 1.0 and self._level < self._deepest:
            self._take_back(max(1, math.ceil(math.log2(error) / self._order)) if math.isfinite(error) else 1)
            return 0
        self._keep(legs, error)
        done = _FINEST >> self._level
        if self._level and error <= _SAFE / 2.0**self._order:
            self._level -= 1
        return done

    def _attempt(self, points: Points, index: int, place: int) -> tuple[float, list[_Leg]]:
        """Take a step, or a whole one and two halves; return the error and what is to be kept."""
        length = _FINEST >> self._level
        whole = _span(points, index, place, length, self._stop_time)
        if self._error is None:
            return 0.0, [_Leg(BEGIN, END, whole, self._stepper.step(BEGIN, END, whole, 0))]
        self._stepper.step(BEGIN, WHOLE, whole, 0)
        for node in self._saved:
            node.slave.restore(0)
        half = length // 2
        first, second = (_span(points, index, start, half, self._stop_time) for start in (place, place + half))
        legs = [_Leg(BEGIN, MIDDLE, first, self._stepper.step(BEGIN, MIDDLE, first, 0))]
        for node in self._saved:
            node.slave.save(1)
        legs.append(_Leg(MIDDLE, END, second, self._stepper.step(MIDDLE, END, second, 1)))
        return self._error.estimate(whole.size), legs

    def _recovers(self, failure: LoopError | SlaveError) -> bool:
        """Tell whether a smaller step may help."""
        if isinstance(failure, LoopError):
            return self._halves
        return failure.discarded and (self._halves or self._error is not None)

    def _take_back(self, levels: int) -> None:
        """Return to the beginning of the step, to try smaller ones."""
        for node in self._saved:
            node.slave.restore(0)
        self._level = min(self._level + levels, self._deepest)
        self.tally.rejected += 1

    def _take_back_after(self, failure: LoopError | SlaveError) -> None:
        """Return to the beginning of a step that failed; an FMU that has ended, and stays so, has the last word."""
        try:
            self._take_back(1)
        except SlaveError as error:
            if isinstance(failure, EndRequestError) and error.component == failure.component:
                raise failure from None
            raise

    def _keep(self, legs: Sequence[_Leg], error: float) -> None:
        """Step what could not be taken back, and record."""
        for leg in legs:
            self._stepper.finish(leg.begin, leg.end, leg.span)
            self._recording.append(
                leg.end, leg.span.end, iterations=leg.taken.sweeps, error_estimate=error * self._tolerance
            )
            self.tally.count(leg.taken)
            self.reached = leg.span.end
        self.tally.largest_error = max(self.tally.largest_error, error)
        self.tally.error_time += error * sum(leg.span.size for leg in legs)
        self.tally.missed += len(legs) if error > 1.0 else 0
        for node in self._nodes:
            node.block.roll(END)


def _span(points: Points, index: int, place: int, length: int, stop_time: float) -> Span:
    """Return the step from a place between two regular points on, both as parts of the distance."""
    time, size = float(points.times[index]), float(points.sizes[index])
    begin, end = (time + size * (number / _FINEST) for number in (place, place + length))
    first, last = begin, end
    part = size * (length / _FINEST)
    if place == 0:
        first = float(points.signal_times[index])
    if place + length == _FINEST:
        end, last = float(points.times[index + 1]), float(points.signal_times[index + 1])
        part = within(begin, part, stop_time)
    return Span(begin, part, end, first, last)


@dataclass(frozen=True)
class _Watched:
    """A connection; `waveform` says whether what the input was assumed to be within the step matters."""

    channel: Channel
    waveform: bool
    order: int


class ErrorEstimate:
    """Estimates the error of two half steps from the difference to a whole one.

    Where an input goes on a straight line, the assumption within a step is of second order; where it is held, of first.
    What an FMU makes of a held input need not show at the end of the step, if it delays or integrates. Only where each
    of its outputs depends directly on inputs it is taken to show there.

    Parameters
    ----------
    nodes : iterable of Node
        The components whose steps are repeated.
    tolerance : float
        Of the error, relative to the greater of value and nominal value.
    leads : bool
        Whether the algorithm gives inputs the values at the end of the step, on a straight line where it can.
    """

    def __init__(self, nodes: Iterable[Node], tolerance: float, *, leads: bool) -> None:
        self.tolerance = tolerance
        self._watched = [
            _Watched(channel, straight or not leads or _hides(node), 2 if straight else 1)
            for node in nodes
            for channel in node.channels
            if channel.continuous
            for straight in [leads and channel.target.slopes is not None]
        ]

    @property
    def order(self) -> int:
        """With which power of the step size the estimate goes to zero."""
        return min((watched.order for watched in self._watched if watched.waveform), default=2)

    @property
    def compares(self) -> bool:
        """Tell whether there is anything to compare; if not, an estimate of 0 says nothing."""
        return bool(self._watched)

    def not_estimated(self, nodes: Iterable[Node]) -> dict[str, list[str]]:
        """Name what the estimate says nothing of.

        Parameters
        ----------
        nodes : iterable of Node
            All components.

        Returns
        -------
        dict
            Under ``discrete``, outputs that are passed on and do not change continuously; under ``components``, those
            that have outputs, of which none is passed on to where it would be compared.
        """
        parts = tuple(nodes)
        passed = [channel for node in parts for channel in node.channels]
        discrete = dict.fromkeys(str(channel.source) for channel in passed if not channel.continuous)
        seen = {watched.channel.source.component for watched in self._watched}
        seen |= {channel.source.component for channel in passed if not channel.continuous}
        giving = [node.name for node in parts if node.slave.description.with_causality("output")]
        return {"discrete": list(discrete), "components": [name for name in giving if name not in seen]}

    def estimate(self, size: float) -> float:
        """Return the greatest estimate for a step of a size [s], relative to the tolerance."""
        worst = 0.0
        for watched in self._watched:
            error = _difference(watched, size) / (2**watched.order - 1)
            allowed = self.tolerance * max(watched.channel.nominal, abs(watched.channel.output(END)))
            worst = max(worst, error / allowed) if math.isfinite(error) else math.inf
        return worst


def _difference(watched: _Watched, size: float) -> float:
    """Return by how much the whole step differs from the halves, in the unit of the variable."""
    channel, target = watched.channel, watched.channel.target
    outputs = abs(channel.output(WHOLE) - channel.output(END))
    if not watched.waveform:
        return outputs
    end, middle = target.value(WHOLE), target.value(WHOLE) - 0.5 * size * target.slope(WHOLE)
    second_half = target.value(END) - 0.5 * size * target.slope(END)
    return max(outputs, abs(end - target.value(END)), abs(middle - target.value(MIDDLE)), abs(middle - second_half))


def _hides(node: Node) -> bool:
    """Tell whether a component has an output that no input feeds through to."""
    description = node.slave.description
    return any(not description.fed_through(variable.name) for variable in description.with_causality("output"))
