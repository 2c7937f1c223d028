"""Take steps, of any size, by an explicit or the implicit algorithm.

By an explicit one, every component is stepped once, with what is known by then. Which outputs are known is the lag of
the channels, by the algorithm. Runs whose communication points are known beforehand go another way, by
`cosim.master.fixed_step` or the same in C.

By the implicit one, every step is repeated until what each component was given is what the others put out at its end.
Components are stepped in an order in which all that a component depends on comes before it. Those that depend on each
other form a loop, which is closed by `coupled_loop`; the others are stepped once, with inputs that are final. Values
that do not change continuously (Integer, Boolean, discrete Real) are not iterated: they hold over a step what they are
at its beginning.

Where a value jumps at the beginning of a step, the inputs that it feeds through to jump as well. A straight line from
the value before would not; so these are held over the step at what they are at its end.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from numpy.typing import NDArray

from cosim.errors import LoopError
from cosim.master.coupled_loop import CoupledLoop
from cosim.master.run import Settling, exchange, initialise
from cosim.master.wiring import Channel, Node, Span
from cosim.system.signals import Value
from cosim.system.structure import Port


@dataclass(frozen=True)
class Taken:
    """A step that was taken.

    Attributes
    ----------
    sweeps : int
        How often components were stepped at most.
    unsolved : LoopError, optional
        A loop that was not closed, where the run is to go on all the same.
    """

    sweeps: int
    unsolved: LoopError | None = None


class Stepper(Protocol):
    """Takes all components from one row of the stage to another."""

    def initialise(self, time: float) -> Settling:
        """Initialise all components at a time [s], and leave row 0 consistent."""
        ...

    def step(self, begin: int, end: int, span: Span, slot: int) -> Taken:
        """Step every component but those that `finish` steps.

        Parameters
        ----------
        begin, end : int
            Rows of the stage.
        span : Span
            The time of the step.
        slot : int
            Where the states at its beginning are kept, if the algorithm needs them.

        Raises
        ------
        LoopError
            If a loop has no solution.
        SlaveError
            If a component refuses the step.
        """
        ...

    def finish(self, begin: int, end: int, span: Span) -> None:
        """Step the components that could not be taken back, once the step is kept; nothing depends on them."""
        ...

    def learned(self) -> dict[str, NDArray[Any]]:
        """Return by name what was learned from steps for those that follow."""
        ...

    def learn(self, learned: Mapping[str, NDArray[Any]]) -> None:
        """Know what another of its kind has learned; names of other things may be among them."""
        ...


class Explicit:
    """The stepper of explicit algorithms.

    Parameters
    ----------
    nodes : sequence of Node
        All components but the last ones, in stepping order.
    last : sequence of Node
        Components that are stepped when the step is kept.
    """

    def __init__(self, nodes: Sequence[Node], last: Sequence[Node]) -> None:
        self._nodes, self._last = tuple(nodes), tuple(last)

    def initialise(self, time: float) -> Settling:
        """Initialise all components."""
        del time
        return initialise((*self._nodes, *self._last))

    def step(self, begin: int, end: int, span: Span, slot: int) -> Taken:
        """Step every component but the last ones."""
        del slot
        for node in self._nodes:
            self._step(node, begin, end, span)
        return Taken(1)

    def finish(self, begin: int, end: int, span: Span) -> None:
        """Step the last components."""
        for node in self._last:
            self._step(node, begin, end, span)

    def learned(self) -> dict[str, NDArray[Any]]:
        """Nothing is learned from a step."""
        return {}

    def learn(self, learned: Mapping[str, NDArray[Any]]) -> None:
        """Nothing is to be learned."""

    def _step(self, node: Node, begin: int, end: int, span: Span) -> None:
        """Step one component with its inputs held."""
        for channel in node.channels:
            channel.target.hold(end, channel.output(begin if channel.lag else end))
        for drive in node.drives:
            if not drive.constant:
                drive.hold(end, span)
        node.advance(end, span)
        for drive in node.drives:
            if not drive.constant and drive.target.slopes is not None:
                drive.settle(end, span)


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
    units : sequence of Node or CoupledLoop
        All components but the last ones, in stepping order, those that depend on each other together.
    last : sequence of Node
        Components that are stepped when the step is kept.
    reach : mapping of Port to frozenset of Port
        By input, the inputs it feeds through to.
    goes_on : bool
        Whether a loop without a solution is stepped once with values from the beginning of the step.
    """

    def __init__(
        self,
        units: Sequence[Node | CoupledLoop],
        last: Sequence[Node],
        reach: Mapping[Port, frozenset[Port]],
        *,
        goes_on: bool = False,
    ) -> None:
        self._units = tuple(units)
        self._loops = [unit for unit in units if isinstance(unit, CoupledLoop)]
        self._last = tuple(last)
        self._reach = reach
        self._goes_on = goes_on
        inner = (unit.nodes if isinstance(unit, CoupledLoop) else (unit,) for unit in units)
        self._nodes = (*(node for nodes in inner for node in nodes), *last)
        self._jumping = [channel for node in self._nodes for channel in node.channels if not channel.continuous]

    def initialise(self, time: float) -> Settling:
        """Initialise all components; loops are closed as in a step."""
        return initialise(self._nodes, lambda: self._exchange(time))

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
        return exchange(self._nodes)

    def step(self, begin: int, end: int, span: Span, slot: int) -> Taken:
        """Step every component but the last ones."""
        held = self._jumps(begin, span)
        sweeps, unsolved = 1, None
        for unit in self._units:
            if isinstance(unit, Node):
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
        for node in self._last:
            node.lead(begin, end, span, held)
            node.settle(begin, end, span)

    def learned(self) -> dict[str, NDArray[Any]]:
        """Return what the loops have learned."""
        return {f"loop {number}": loop.learned for number, loop in enumerate(self._loops)}

    def learn(self, learned: Mapping[str, NDArray[Any]]) -> None:
        """Let the loops know what others have learned."""
        for number, loop in enumerate(self._loops):
            loop.learned = learned[f"loop {number}"]

    def _jumps(self, begin: int, span: Span) -> frozenset[Port]:
        """Return the inputs that jump at the beginning of a step, because one that feeds through to them does."""
        jumped = [
            drive.target.port
            for node in self._nodes
            for drive in node.drives
            if not drive.constant
            and _differ(drive.first(span), drive.target.value(begin), drive.target.variable.nominal)
        ]
        jumped += [
            channel.target.port
            for node in self._nodes
            for channel in node.channels
            if _jumps(channel, begin, span.size)
        ]
        return frozenset(port for entry in jumped for port in self._reach.get(entry, ()))


def _jumps(channel: Channel, begin: int, size: float) -> bool:
    """Tell whether an output is not what its input was up to now, or not where its derivative led it."""
    output, arrived = channel.output(begin), channel.target.value(begin)
    if not channel.continuous:
        return output != arrived
    if channel.derivatives is None:
        return False
    change = channel.last(begin, begin, size) - output
    return _differ(output, arrived, channel.nominal) and abs(output - arrived) > _CURVATURE * abs(change)


def _differ(first: Value, second: Value, nominal: float) -> bool:
    """Tell whether two values differ by more than rounding."""
    if isinstance(first, str) or isinstance(second, str):
        return first != second
    return abs(first - second) > _ROUNDING * max(abs(first), nominal)
