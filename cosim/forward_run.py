"""Runs that only go forward: every step is taken once, straight into a recording that is laid out for all of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cosim.algorithms import EXPLICIT
from cosim.compatibility import StartValues
from cosim.dependency import stepping_order
from cosim.grid import Grid
from cosim.initialisation import Settling, initialise
from cosim.method import Method
from cosim.readable_loop import readable_steps
from cosim.record import Trace
from cosim.run import REPORTS, Progress
from cosim.slave import Slave
from cosim.step_loop import compiled_steps
from cosim.system import System
from cosim.wiring import record_slopes, wire


class ForwardRun:
    """A run of an explicit algorithm with given communication points.

    Parameters
    ----------
    system : System
        Checked by `cosim.compatibility.check_system`, which returned the start values.
    slaves : mapping of str to Slave
        By name of component.
    start_values : mapping
        By component.
    grid : Grid
        Communication points.
    method : Method
        An explicit algorithm.
    """

    def __init__(
        self, system: System, slaves: Mapping[str, Slave], start_values: StartValues, grid: Grid, method: Method
    ) -> None:
        self._system, self._grid, self._method = system, grid, method
        self._compiled = False
        descriptions = {name: slave.description for name, slave in slaves.items()}
        self.order = stepping_order(system, descriptions, method.order)
        self._nodes = wire(system, slaves, start_values, grid, EXPLICIT[method.algorithm], self.order)
        self.blocks = {node.name: node.block for node in self._nodes}

    def initialise(self) -> Settling:
        """Initialise all components."""
        return initialise(self._nodes)

    def advance(self, progress: Progress | None) -> None:
        """Take all steps, a chunk at a time, in C where that can be had."""
        loop = compiled_steps(self._nodes, self._grid) if self._method.compiled else None
        self._compiled = loop is not None
        take = loop or readable_steps(self._nodes, self._grid)
        steps = self._grid.sizes.size
        chunk = max(1, steps // REPORTS)
        for first in range(1, steps + 1, chunk):
            last = min(first + chunk - 1, steps)
            take(first, last)
            if progress is not None:
                progress(last / steps)

    def trace(self) -> Trace:
        """Return the recording."""
        record_slopes(self._nodes, self._system, self._grid)
        return Trace(self._grid.times, self.blocks, {})

    def record(self) -> dict[str, Any]:
        """Return the number of steps, and whether they were taken in C."""
        return {"steps": self._grid.sizes.size, "compiled": self._compiled}
