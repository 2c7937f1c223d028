"""Implicit: every step is repeated until what each component was given is what the others put out at its end.

Components are stepped in an order in which all that a component depends on comes before it. Those that depend on each
other form a loop, which is closed by `loop.coupled`; the others are stepped once, with inputs that are final.
Values that do not change continuously (Integer, Boolean, discrete Real) are not iterated: they hold over a step what
they are at its beginning.

Where a value jumps at the beginning of a step, the inputs that it feeds through to jump as well. A straight line from
the value before would not; so these are held over the step at what they are at its end.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from typing import Any

from numpy.typing import NDArray

from cosim.errors import LoopError
from cosim.master.loop.coupled import CoupledLoop
from cosim.master.stepping.channel import Channel, Span
from cosim.master.stepping.initialisation import Settling, exchange, initialise
from cosim.master.stepping.stage import Part
from cosim.master.stepping.stepper import Taken

log = logging.getLogger("cosim")

# How often values are exchanged at the start until those that are not iterated have settled as well.
_ROUNDS = 50
# Output and prediction may differ by this part of the nominal value, and of the change in a step, without a jump.
_ROUNDING = 1e-9
_CURVATURE = 0.1


class Implicit:
    """The stepper of the implicit algorithm.

    Parameters
    ----------
    units : sequence of Part or CoupledLoop
        All components but the last ones, in stepping order, those that depend on each other together.
    last : sequence of Part
        Components that are stepped when the step is kept.
    reach : mapping of str to frozenset of str
        By the name of an input, the inputs it feeds through to.
    goes_on : bool
        Whether a loop without a solution is stepped once with values from the beginning of the step.
    """

    def __init__(
        self,
        units: Sequence[Part | CoupledLoop],
        last: Sequence[Part],
        reach: Mapping[str, frozenset[str]],
        *,
        goes_on: bool = False,
    ) -> None:
        self._units = tuple(units)
        self._loops = [unit for unit in units if isinstance(unit, CoupledLoop)]
        self._last = tuple(last)
        self._reach = reach
        self._goes_on = goes_on
        inner = (unit.parts if isinstance(unit, CoupledLoop) else (unit,) for unit in units)
        self._parts = (*(part for parts in inner for part in parts), *last)
        self._jumping = [channel for part in self._parts for channel in part.channels if not channel.continuous]

    def initialise(self, time: float) -> Settling:
        """Initialise all components; loops are closed as in a step."""
        return initialise(self._parts, lambda: self._exchange(time))

    def _exchange(self, time: float) -> Settling:
        """Exchange values in initialization mode until they agree, whether iterated or not."""
        trials = 0
        try:
            for _ in range(_ROUNDS):
                for unit in (*self._units, *self._last):
                    trials += unit.start(time)
                if all(channel.target.value(0) == channel.output(0) for channel in self._jumping):
                    return Settling(True, trials)
        except LoopError as error:
            if not self._goes_on:
                raise
            log.warning("%s", error)
        return exchange(self._parts)

    def step(self, begin: int, end: int, span: Span, slot: int) -> Taken:
        """Step every component but the last ones."""
        held = self._jumps(begin, span)
        sweeps, unsolved = 1, None
        for unit in self._units:
            if isinstance(unit, Part):
                unit.lead(begin, end, span, held)
                unit.settle(begin, end, span)
                continue
            try:
                sweeps = max(sweeps, unit.close(begin, end, span, slot, held))
            except LoopError as error:
                if not self._goes_on:
                    raise
                unit.restore(slot)
                unit.step_once(begin, end, span)
                sweeps, unsolved = max(sweeps, error.trials + 1), error
        return Taken(sweeps, unsolved)

    def finish(self, begin: int, end: int, span: Span) -> None:
        """Step the last components."""
        held = self._jumps(begin, span)
        for part in self._last:
            part.lead(begin, end, span, held)
            part.settle(begin, end, span)

    def learned(self) -> dict[str, NDArray[Any]]:
        """Return what the loops have learned."""
        return {f"loop {number}": loop.learned for number, loop in enumerate(self._loops)}

    def learn(self, learned: Mapping[str, NDArray[Any]]) -> None:
        """Let the loops know what others have learned."""
        for number, loop in enumerate(self._loops):
            loop.learned = learned[f"loop {number}"]

    def _jumps(self, begin: int, span: Span) -> frozenset[str]:
        """Return the inputs that jump at the beginning of a step, because one that feeds through to them does."""
        jumped = [
            drive.target.name
            for part in self._parts
            for drive in part.drives
            if not drive.constant
            and _differ(drive.first(span), drive.target.value(begin), drive.target.variable.nominal)
        ]
        jumped += [
            channel.target.name
            for part in self._parts
            for channel in part.channels
            if _jumps(channel, begin, span.size)
        ]
        return frozenset(name for entry in jumped for name in self._reach.get(entry, ()))


def _jumps(channel: Channel, begin: int, size: float) -> bool:
    """Whether an output is not what its input was up to now, or not where its derivative led it."""
    output, arrived = channel.output(begin), channel.target.value(begin)
    if not channel.continuous:
        return output != arrived
    if channel.derivatives is None:
        return False
    change = channel.last(begin, begin, size) - output
    return _differ(output, arrived, channel.nominal) and abs(output - arrived) > _CURVATURE * abs(change)


def _differ(first: float, second: float, nominal: float) -> bool:
    """Whether two values differ by more than rounding."""
    return abs(first - second) > _ROUNDING * max(abs(first), nominal)
