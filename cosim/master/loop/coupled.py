"""Components that depend on each other, stepped again and again from the same state until their values agree.

The components are stepped in order. Connections that lead forward pass on what has just been computed. Those that lead
back are torn: what they bring is tried, and compared with what comes back. An input of an FMU that interpolates goes on
a straight line from the value at the beginning of the step to that at its end; one of an FMU that does not is held at
the value at the end.
"""

from __future__ import annotations

from collections.abc import Callable, Collection

import numpy as np

from cosim.errors import LoopError, SlaveError
from cosim.master.loop.solver import LoopSolver
from cosim.master.loop.trials import UnsolvedError
from cosim.master.stepping.channel import Span
from cosim.master.stepping.stage import Part
from cosim.system.signals import FloatArray
from cosim.system.structure import split_name

_DISCARD = "fmi2Discard"

Explain = Callable[["CoupledLoop", UnsolvedError, int, float], LoopError]
"""From what was not solved, the row of the last trial and the time [s] to the error that says so."""


class CoupledLoop:
    """A group of components that depend on each other.

    Parameters
    ----------
    parts : tuple of Part
        In stepping order.
    tolerance : float
        How well tried and returned values agree in the end, relative to the greater of value and nominal value.
    explain : callable
        Puts failures into words.

    Attributes
    ----------
    parts : tuple of Part
        As given.
    torn : tuple of Channel
        The connections whose values are the unknowns.
    """

    def __init__(self, parts: tuple[Part, ...], tolerance: float, explain: Explain) -> None:
        self.parts = parts
        place = {part.name: index for index, part in enumerate(parts)}
        self.torn = tuple(
            channel
            for index, part in enumerate(parts)
            for channel in part.channels
            if channel.continuous and place.get(split_name(channel.source)[0], -1) >= index
        )
        self._explain = explain
        self._names = tuple(channel.target.name for channel in self.torn)
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

    def close(self, begin: int, end: int, span: Span, slot: int, held: Collection[str]) -> int:
        """Step all components from one row to another until their values agree.

        Parameters
        ----------
        begin, end : int
            Rows of the stage.
        span : Span
            The time of the step.
        slot : int
            Where the states at its beginning are kept.
        held : collection of str
            Names of inputs that jump at the beginning, and are held at what they are at the end.

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
        jumped = np.array([name in held for name in self._names])
        self._slopes = np.where(jumped, 0.0, (last - first) / span.size)
        return sweeps

    @property
    def learned(self) -> FloatArray:
        """What steps have taught, shape (1 + 2 k, n): how the torn values move, and the differences of k trials."""
        return np.concatenate([self._slopes[np.newaxis], self._solver.learned])

    @learned.setter
    def learned(self, rows: FloatArray) -> None:
        self._slopes, self._solver.learned = rows[0], rows[1:]

    def step_once(self, begin: int, end: int, span: Span) -> None:
        """Step all components once, what is torn held at its value at the beginning, as Gauss-Seidel does."""
        first = self._outputs(begin)
        held = {channel.target.name for part in self.parts for channel in part.channels}
        self._sweep(begin, end, span, held, first)
        self._settle(begin, end, span, first)

    def restore(self, slot: int) -> None:
        """Return all components to a state."""
        for part in self.parts:
            part.slave.restore(slot)

    def _solve(
        self, solver: LoopSolver, step: Callable[[FloatArray], None], start: FloatArray, row: int, time: float
    ) -> tuple[FloatArray, int]:
        """Find the values that come back to a row as they were tried, and return them and the number of trials."""
        refusals: list[SlaveError] = []

        def residual(scaled: FloatArray) -> FloatArray:
            try:
                step(scaled * self._scale)
            except SlaveError as error:
                if error.status != _DISCARD:
                    raise
                refusals.append(error)
                return np.full(scaled.size, np.nan)
            return self._outputs(row) / self._scale - scaled

        try:
            scaled, trials = solver.solve(residual, start / self._scale)
        except UnsolvedError as failure:
            if refusals and not failure.best.answered:
                raise refusals[0] from None
            raise self._explain(self, failure, row, time) from None
        return scaled * self._scale, trials

    def _sweep(self, begin: int, end: int, span: Span, held: Collection[str], tried: FloatArray) -> None:
        """Step all components once with tried values."""
        values = dict(zip(self._names, tried.tolist(), strict=True))
        for part in self.parts:
            part.lead(begin, end, span, held, values)

    def _settle(self, begin: int, end: int, span: Span, last: FloatArray) -> None:
        """Note the values at the end of the step."""
        values = dict(zip(self._names, last.tolist(), strict=True))
        for part in self.parts:
            part.settle(begin, end, span, values)

    def _exchange(self, tried: FloatArray) -> None:
        """Give all components tried values in initialization mode, and ask for theirs."""
        values = dict(zip(self._names, tried.tolist(), strict=True))
        for part in self.parts:
            part.gather_initial(values)
            part.slave.write(0)
            part.slave.read(0)

    def _outputs(self, row: int) -> FloatArray:
        """Return what the sources of the torn connections put out."""
        return np.array([channel.output(row) for channel in self.torn])
