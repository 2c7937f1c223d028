"""Explicit algorithms on the stage: every component is stepped once, with what is known by then, in a step of any size.

Which outputs are known is the algorithm's lag. Runs whose communication points are known beforehand go another way, by
`cosim.master.stepping.readable_loop` or the same in C.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from numpy.typing import NDArray

from cosim.master.stepping.channel import Span
from cosim.master.stepping.initialisation import Settling, initialise
from cosim.master.stepping.stage import Part
from cosim.master.stepping.stepper import Taken
from cosim.system.algorithms import Lag
from cosim.system.structure import split_name


class Explicit:
    """The stepper of explicit algorithms.

    Parameters
    ----------
    parts : sequence of Part
        All components but the last ones, in stepping order.
    last : sequence of Part
        Components that are stepped when the step is kept.
    lag : callable
        Which algorithm.
    """

    def __init__(self, parts: Sequence[Part], last: Sequence[Part], lag: Lag) -> None:
        self._parts, self._last = tuple(parts), tuple(last)
        place = {part.name: index for index, part in enumerate((*parts, *last))}
        self._late = {
            channel.target.name: lag(place[split_name(channel.source)[0]], place[part.name]) > 0
            for part in (*parts, *last)
            for channel in part.channels
        }

    def initialise(self, time: float) -> Settling:
        """Initialise all components."""
        del time
        return initialise((*self._parts, *self._last))

    def step(self, begin: int, end: int, span: Span, slot: int) -> Taken:
        """Step every component but the last ones."""
        del slot
        for part in self._parts:
            self._step(part, begin, end, span)
        return Taken(1)

    def finish(self, begin: int, end: int, span: Span) -> None:
        """Step the last components."""
        for part in self._last:
            self._step(part, begin, end, span)

    def learned(self) -> dict[str, NDArray[Any]]:
        """Nothing is learned from a step."""
        return {}

    def learn(self, learned: Mapping[str, NDArray[Any]]) -> None:
        """Nothing is to be learned."""

    def _step(self, part: Part, begin: int, end: int, span: Span) -> None:
        """Step one component with its inputs held."""
        for channel in part.channels:
            channel.target.hold(end, channel.output(begin if self._late[channel.target.name] else end))
        for drive in part.drives:
            if not drive.constant:
                drive.hold(end, span)
        part.advance(end, span)
        for drive in part.drives:
            if not drive.constant and drive.target.slopes is not None:
                drive.settle(end, span)
