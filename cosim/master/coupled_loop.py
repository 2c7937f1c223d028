"""Step components that depend on each other again and again from the same state, until their values agree.

The components are stepped in order. Connections that lead forward pass on what has just been computed. Those that lead
back are torn: what they bring is tried, and compared with what comes back. An input of an FMU that interpolates goes on
a straight line from the value at the beginning of the step to that at its end; one of an FMU that does not is held at
the value at the end.

Where the residual of a loop vanishes is found by a fast method that is nearly always enough, and a sure one behind it.
Where it does not vanish, the error says when, between which variables, by how much it fails, and what to try.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Collection

import numpy as np

from cosim.errors import EndRequestError, LoopError, SlaveError, format_time
from cosim.master.root_finding import (
    QuasiNewton,
    Residual,
    Trial,
    Trials,
    UnsolvedError,
    find_roots,
    find_single_root,
)
from cosim.master.wiring import Channel, Node, Span
from cosim.system.dependency import Loop
from cosim.system.signals import FloatArray
from cosim.system.structure import Port

# An answer whose square overflows is as good as infinite: nothing can be extrapolated from it.
_OVERFLOWING = math.sqrt(sys.float_info.max) / 1e3
# So far is a start moved, relative to the usual size, where the answer to it overflows.
_FIRST_STRIDE = 0.01


class LoopSolver:
    """Finds values that come back as they were tried; learns from one step for the next.

    Parameters
    ----------
    low, high : ndarray, shape (n,)
        Between which values are tried; scaled so that 1 is a usual size, as everything here.
    tolerance : float
        Greatest residual, relative to the greater of 1 and the value.
    """

    def __init__(self, low: FloatArray, high: FloatArray, tolerance: float) -> None:
        self._low, self._high = low, high
        self._tolerance = tolerance
        self._quasi_newton = QuasiNewton(low.size)

    def solve(self, residual: Residual, start: FloatArray) -> tuple[FloatArray, int]:
        """Find where the residual vanishes.

        Parameters
        ----------
        residual : callable
            What comes back less what was tried. The last call is the one that vanishes.
        start : ndarray, shape (n,)
            Where to begin.

        Returns
        -------
        values : ndarray, shape (n,)
            The solution.
        trials : int
            How many it took.

        Raises
        ------
        UnsolvedError
            If none was found.
        """
        trials = Trials(residual, self._low, self._high, self._tolerance)
        trial = self._fast(trials, start)
        if trial is None:
            trial = find_single_root(trials) if self._low.size == 1 else find_roots(trials)
        return trial.values, len(trials.made)

    @property
    def learned(self) -> FloatArray:
        """Return what `QuasiNewton` has learned, shape (2 k, n)."""
        return self._quasi_newton.learned

    @learned.setter
    def learned(self, rows: FloatArray) -> None:
        self._quasi_newton.learned = rows

    def _fast(self, trials: Trials, start: FloatArray) -> Trial | None:
        """Try the quasi-Newton method for as long as it may take; nothing if that was not enough."""
        self._quasi_newton.begin()
        values = start
        last: Trial | None = None
        for _ in range(6 + 2 * self._low.size):
            trial = trials.make(values)
            if trials.solved(trial):
                return trial
            if trial.miss < _OVERFLOWING:
                values = self._quasi_newton.propose(trial.values, trial.residual)
                last = trial
            elif last is None:
                if np.isnan(trial.residual).any():
                    raise UnsolvedError(trials)
                # The components answered, and what they answered has overflowed: a pole is next to the start.
                values = trial.values + _FIRST_STRIDE * np.maximum(1.0, np.abs(trial.values))
            else:
                values = 0.5 * (trial.values + last.values)
        return None


Explain = Callable[["CoupledLoop", UnsolvedError, int, float], LoopError]
"""From what was not solved, the row of the last trial and the time [s] to the error that says so."""


class CoupledLoop:
    """A group of components that depend on each other.

    Parameters
    ----------
    nodes : tuple of Node
        In stepping order.
    tolerance : float
        How well tried and returned values agree in the end, relative to the greater of value and nominal value.
    explain : callable
        Puts failures into words.

    Attributes
    ----------
    nodes : tuple of Node
        As given.
    torn : tuple of Channel
        The connections whose values are the unknowns.
    """

    def __init__(self, nodes: tuple[Node, ...], tolerance: float, explain: Explain) -> None:
        self.nodes = nodes
        place = {node.name: index for index, node in enumerate(nodes)}
        self.torn = tuple(
            channel
            for index, node in enumerate(nodes)
            for channel in node.channels
            if channel.continuous and place.get(channel.source.component, -1) >= index
        )
        self._explain = explain
        self._unknowns = tuple(channel.target.port for channel in self.torn)
        self._scale = np.array([channel.nominal for channel in self.torn])
        variables = [channel.target.variable for channel in self.torn]
        low = np.array([-np.inf if variable.minimum is None else variable.minimum for variable in variables])
        high = np.array([np.inf if variable.maximum is None else variable.maximum for variable in variables])
        self._solver = LoopSolver(low / self._scale, high / self._scale, tolerance)
        self._starter = LoopSolver(low / self._scale, high / self._scale, tolerance)
        self._slopes = np.zeros(len(self.torn))

    def start(self, time: float) -> int:
        """Find values that agree in initialization mode, in row 0; return the number of trials.

        Raises
        ------
        LoopError
            If none are found.
        """
        begin = np.array([float(channel.target.variable.start or 0.0) for channel in self.torn])
        return self._solve(self._starter, self._exchange, begin, 0, time)[1]

    def close(self, begin: int, end: int, span: Span, slot: int, held: Collection[Port]) -> int:
        """Step all components from one row to another until their values agree.

        Parameters
        ----------
        begin, end : int
            Rows of the stage.
        span : Span
            The time of the step.
        slot : int
            Where the states at its beginning are kept.
        held : collection of Port
            Inputs that jump at the beginning, and are held at what they are at the end.

        Returns
        -------
        int
            How often the components were stepped.

        Raises
        ------
        LoopError
            If no values agree.
        SlaveError
            If a component refuses the step whatever it is given.
        """
        first = self._outputs(begin)
        stepped = False

        def sweep(tried: FloatArray) -> None:
            nonlocal stepped
            if stepped:
                self.restore(slot)
            stepped = True
            self._sweep(begin, end, span, held, tried)

        last, sweeps = self._solve(self._solver, sweep, first + span.size * self._slopes, end, span.time)
        self._settle(begin, end, span, last)
        jumped = np.array([port in held for port in self._unknowns])
        self._slopes = np.where(jumped, 0.0, (last - first) / span.size)
        return sweeps

    @property
    def learned(self) -> FloatArray:
        """Return what was learned, shape (1 + 2 k, n): how the torn values move, and the differences of k trials."""
        return np.concatenate([self._slopes[np.newaxis], self._solver.learned])

    @learned.setter
    def learned(self, rows: FloatArray) -> None:
        self._slopes, self._solver.learned = rows[0], rows[1:]

    def step_once(self, begin: int, end: int, span: Span) -> None:
        """Step all components once, what is torn held at its value at the beginning, as Gauss-Seidel does."""
        first = self._outputs(begin)
        held = {channel.target.port for node in self.nodes for channel in node.channels}
        self._sweep(begin, end, span, held, first)
        self._settle(begin, end, span, first)

    def restore(self, slot: int) -> None:
        """Return all components to a state."""
        for node in self.nodes:
            node.slave.restore(slot)

    def _solve(
        self, solver: LoopSolver, step: Callable[[FloatArray], None], start: FloatArray, row: int, time: float
    ) -> tuple[FloatArray, int]:
        """Find the values that come back to a row as they were tried, and return them and the number of trials."""
        refusals: list[SlaveError] = []

        def residual(scaled: FloatArray) -> FloatArray:
            try:
                step(scaled * self._scale)
            except SlaveError as error:
                if not error.discarded:
                    raise _end_of(error.component, refusals) or error from None
                refusals.append(error)
                return np.full(scaled.size, np.nan)
            return self._outputs(row) / self._scale - scaled

        try:
            scaled, trials = solver.solve(residual, start / self._scale)
        except UnsolvedError as failure:
            ends = [error for error in refusals if isinstance(error, EndRequestError)]
            if ends:  # it ends where the others would lead it, whatever else was tried
                raise ends[0] from None
            if refusals and not failure.best.answered:
                raise refusals[0] from None
            raise self._explain(self, failure, row, time) from None
        return scaled * self._scale, trials

    def _sweep(self, begin: int, end: int, span: Span, held: Collection[Port], tried: FloatArray) -> None:
        """Step all components once with tried values."""
        values = dict(zip(self._unknowns, tried.tolist(), strict=True))
        for node in self.nodes:
            node.lead(begin, end, span, held, values)

    def _settle(self, begin: int, end: int, span: Span, last: FloatArray) -> None:
        """Note the values at the end of the step."""
        values = dict(zip(self._unknowns, last.tolist(), strict=True))
        for node in self.nodes:
            node.settle(begin, end, span, values)

    def _exchange(self, tried: FloatArray) -> None:
        """Give all components tried values in initialization mode, and ask for theirs."""
        values = dict(zip(self._unknowns, tried.tolist(), strict=True))
        for node in self.nodes:
            node.gather_initial(values)
            node.slave.write(0)
            node.slave.read(0)

    def _outputs(self, row: int) -> FloatArray:
        """Return what the sources of the torn connections put out."""
        return np.array([channel.output(row) for channel in self.torn])


def _end_of(component: str, refusals: Collection[SlaveError]) -> EndRequestError | None:
    """Return the end that a component has asked for before, if it has: one that stays ended cannot be restored."""
    ends = (error for error in refusals if isinstance(error, EndRequestError) and error.component == component)
    return next(ends, None)


_REMEDY = (
    "Try other parameters, a component with a delay of its own in the loop, or another on_failure: halve for smaller "
    "steps, explicit to go on with values from the beginning of the step"
)
# A jump less than this, relative to the nominal value, may be the accuracy of an FMU and not a property of its model.
_ACCURACY = 1e-4


def reporter(
    loops: Collection[Loop], guards: Callable[[int], Collection[Port]]
) -> Callable[[CoupledLoop, UnsolvedError, int, float], LoopError]:
    """Return what puts failures of loops into words.

    Parameters
    ----------
    loops : collection of Loop
        The algebraic loops of the system.
    guards : callable
        From a row of the stage to the names of the guards and limits that are active there.
    """

    def explain(loop: CoupledLoop, failure: UnsolvedError, row: int, time: float) -> LoopError:
        worst = int(np.argmax(np.abs(failure.best.residual)))
        channel = loop.torn[worst]
        path = _path(loop, channel, loops)
        residual = abs(float(failure.best.residual[worst])) * channel.nominal
        names = [port for port in guards(row) if port.component in {node.name for node in loop.nodes}]
        active = f"; {' and '.join(names)} {'is' if len(names) == 1 else 'are'} on there" if names else ""
        sentence = (
            f"t = {format_time(time)} s: {' -> '.join((*path, path[0]))} {_verdict(failure, channel, worst)}{active}. "
            f"The least residual of {failure.trials} trials is {_quantity(residual, channel)}. {_REMEDY}"
        )
        return LoopError(sentence, time, path, residual, failure.trials)

    return explain


def _path(loop: CoupledLoop, channel: Channel, loops: Collection[Loop]) -> tuple[Port, ...]:
    """Name the loop: the algebraic one that holds the connection, or else the connections that were tried."""
    for known in loops:
        if channel.target.port in known.variables:
            return known.path
    others = [other for other in loop.torn if other is not channel]
    return tuple(port for one in (channel, *others) for port in (one.source, one.target.port))


def _verdict(failure: UnsolvedError, channel: Channel, index: int) -> str:
    """Say why there is no solution, or that none was found."""
    if failure.jump is None:
        tried = _quantity(float(failure.best.values[index]) * channel.nominal, channel)
        return f"does not close: no solution was found, the nearest was {channel.target.port} = {tried}"
    low, high = failure.jump
    place = _quantity(float(low.values[0]) * channel.nominal, channel)
    below, above = (_quantity(_answer(trial, channel), channel) for trial in (low, high))
    if max(low.miss, high.miss) < _ACCURACY:
        return f"closes only as well as its components compute: round {channel.target.port} = {place}"
    return (
        f"has no solution: where {channel.target.port} passes {place}, {channel.source} jumps from {below} to {above}"
    )


def _answer(trial: Trial, channel: Channel) -> float:
    """Return what came back, in the unit of the variable."""
    return float(trial.values[0] + trial.residual[0]) * channel.nominal


def _quantity(value: float, channel: Channel) -> str:
    """Write a value with its unit."""
    unit = channel.target.variable.unit
    return f"{value:.6g} {unit.name}" if unit is not None and unit.name != "1" else f"{value:.6g}"
