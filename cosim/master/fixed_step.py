"""Runs that only go forward: every step is taken once, straight into the recording.

The explicit steps between known communication points, to be read; `compiled_loop` takes the same in C.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from cosim.master.communication_points import Grid, Points
from cosim.master.compiled_loop import StepLoop, loop_library
from cosim.master.run import Settling, Snapshot, block_arrays, initialise, window_size
from cosim.master.slave import Slave
from cosim.master.wiring import Node, wire
from cosim.recording.record import Window
from cosim.system.compatibility import StartValues
from cosim.system.dependency import stepping_order
from cosim.system.method import EXPLICIT, Method
from cosim.system.structure import System


class ForwardRun:
    """A run of an explicit algorithm with given communication points.

    Parameters
    ----------
    system : System
        Checked by `cosim.system.compatibility.check_system`, which returned the start values.
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
        self._grid = grid
        self._row = self._recorded = 0
        self._size = window_size(grid.steps)
        # Before any clock runs: compiling takes seconds, once.
        self._library, self._why = loop_library(slaves) if method.compiled else (None, "the method asks for it")
        descriptions = {name: slave.description for name, slave in slaves.items()}
        self.order = stepping_order(system, descriptions, method.order)
        lag = EXPLICIT[method.algorithm]
        first = float(grid.points(0, 0).signal_times[0])
        self._nodes = wire(system, slaves, start_values, self._size + 1, first, lag, self.order)
        self.blocks = {node.name: node.block for node in self._nodes}
        self.notes: Mapping[str, np.dtype[Any]] = {}

    def initialise(self) -> Settling:
        """Initialise all components."""
        return initialise(self._nodes)

    def windows(self) -> Iterator[Window]:
        """Take all steps, in C where that can be had."""
        nodes = self._nodes
        take = readable_steps(nodes) if self._library is None else StepLoop(self._library, nodes)
        feeds = [feed for node in self._nodes for feed in node.feeds]
        while self._row < self._grid.steps:
            for block in self.blocks.values():
                block.roll(self._recorded)
            last = min(self._row + self._size, self._grid.steps)
            points = self._grid.points(self._row, last)
            for feed in feeds:
                feed.fill(points)
            take(points)
            for feed in feeds:
                feed.settle(points)
            first, self._row, self._recorded = self._row, last, points.sizes.size
            recorded = {name: block.rows(points.times.size) for name, block in self.blocks.items()}
            yield Window(first, points.times, recorded, {})

    @property
    def done(self) -> float:
        """Which part of the steps has been taken, from 0 to 1."""
        return self._row / self._grid.steps

    def snapshot(self) -> Snapshot:
        """Return which row was recorded last, and the row itself."""
        arrays = block_arrays(self.blocks)
        return Snapshot({"row": self._row}, {name: values[self._recorded].copy() for name, values in arrays.items()})

    def restore(self, snapshot: Snapshot) -> None:
        """Go on after a row."""
        self._row, self._recorded = int(snapshot.notes["row"]), 0
        for name, values in block_arrays(self.blocks).items():
            values[0] = snapshot.arrays[name]

    def record(self) -> dict[str, Any]:
        """Return the number of steps, and by which loop they were taken; if by the one in Python, why."""
        if self._library is not None:
            return {"steps": self._grid.steps, "step_loop": "compiled"}
        return {"steps": self._grid.steps, "step_loop": "python", "step_loop_reason": self._why}


def readable_steps(nodes: tuple[Node, ...]) -> Callable[[Points], None]:
    """Return what takes the steps between communication points, which end in the rows from 1 on."""

    def take(points: Points) -> None:
        for row, (now, size) in enumerate(zip(points.times.tolist(), points.sizes.tolist(), strict=False), 1):
            step_once(nodes, row, now, size)

    return take


def step_once(nodes: tuple[Node, ...], row: int, time: float, size: float) -> None:
    """Take every component from `time` [s] to the communication point that is recorded in `row`."""
    for node in nodes:
        node.gather(row)
        node.slave.write(row)
        node.slave.step(time, size)
        node.slave.read(row)
