"""Run forward only: take every step once, straight into the recording.

`readable_steps` is the loop to be read; `compiled_loop` takes the same steps in C.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cosim.errors import EndRequestError
from cosim.master.communication_points import Grid, Points
from cosim.master.compiled_loop import StepLoop, loop_library
from cosim.master.run import Settling, Snapshot, block_arrays, initialise, refill, window_size
from cosim.master.slave import Slave
from cosim.master.wiring import Node, driven_inputs, wire
from cosim.recording.record import Block, Window, allocate_block, allocate_slopes
from cosim.system.compatibility import StartValues
from cosim.system.dependency import stepping_order
from cosim.system.description import Description, Variable
from cosim.system.method import Method
from cosim.system.signals import Value
from cosim.system.structure import Port, System


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
        self._end: EndRequestError | None = None
        self._size = window_size(grid.steps)
        # Before any clock runs: compiling takes seconds, once.
        descriptions = {name: slave.description for name, slave in slaves.items()}
        text = next(exchanged_texts(system, descriptions), None)
        if not method.compiled:
            self._library, self._why = None, "the method asks for it"
        elif text is not None:
            self._library, self._why = None, f"{text} is a String"
        else:
            self._library, self._why = loop_library(slaves)
        self.order = stepping_order(system, descriptions, method.order)
        first = float(grid.points(0, 0).signal_times[0])
        self.blocks = {
            name: window_block(system, name, descriptions[name], start_values[name], self._size + 1)
            for name in self.order
        }
        self._nodes = wire(system, slaves, self.blocks, first, self.order, method.lag)
        self.notes: Mapping[str, np.dtype[Any]] = {}

    def initialise(self) -> Settling:
        """Initialise all components."""
        return initialise(self._nodes)

    def windows(self) -> Iterator[Window]:
        """Take all steps, in C where that can be had, or those before a component asks to end."""
        nodes = self._nodes
        take = readable_steps(nodes) if self._library is None else StepLoop(self._library, nodes)
        drives = [drive for node in nodes for drive in node.drives if not drive.constant]
        views: dict[int, dict[str, Block]] = {}  # by how many rows there are: of all windows but the last as many
        while self._row < self._grid.steps and self._end is None:
            for block in self.blocks.values():
                block.roll(self._recorded)
            last = min(self._row + self._size, self._grid.steps)
            points = self._grid.points(self._row, last)
            for drive in drives:
                drive.fill(points)
            self._end = take(points)
            if self._end is not None:
                last = self._row + int(np.searchsorted(points.times, self._end.time))
                points = self._grid.points(self._row, last)
            for drive in drives:
                drive.settle_filled(points)
            first, self._row, self._recorded = self._row, last, points.sizes.size
            if first and not self._recorded:
                return
            count = points.times.size
            if count not in views:
                views[count] = {name: block.rows(count) for name, block in self.blocks.items()}
            yield Window(first, points.times, views[count], {})

    @property
    def done(self) -> float:
        """Return the part of the steps that has been taken, from 0 to 1."""
        return self._row / self._grid.steps

    def snapshot(self) -> Snapshot:
        """Return which row was recorded last, and the row itself."""
        arrays = block_arrays(self.blocks)
        return Snapshot({"row": self._row}, {name: values[self._recorded].copy() for name, values in arrays.items()})

    def restore(self, snapshot: Snapshot) -> None:
        """Go on after a row."""
        self._row, self._recorded = int(snapshot.notes["row"]), 0
        if not 0 <= self._row <= self._grid.steps:
            raise ValueError(f"{self._row} steps were taken; expected at most {self._grid.steps}")
        for name, values in block_arrays(self.blocks).items():
            refill(values[0], snapshot.arrays[name])

    def record(self) -> dict[str, Any]:
        """Return how many steps were taken, by which loop, why if by the one in Python, and what ended them early."""
        record: dict[str, Any] = {"steps": self._grid.steps if self._end is None else self._row}
        if self._library is not None:
            record["step_loop"] = "compiled"
        else:
            record |= {"step_loop": "python", "step_loop_reason": self._why}
        return record if self._end is None else {**record, "ended": self._end.record()}


def window_block(
    system: System, component: str, description: Description, start_values: Mapping[Variable, Value], rows: int
) -> Block:
    """Lay out a component for steps taken once: with derivatives of the signals that have any, if it can use them."""
    signals = {port.variable: signal for port, signal in system.inputs.items() if port.component == component}
    moving = [description.by_name[name] for name, signal in signals.items() if not signal.is_level]
    references = [variable.reference for variable in moving if variable.type == "Real" and not variable.tunable]
    slopes = allocate_slopes(references, rows) if description.can_interpolate_inputs else None
    block = allocate_block(description, driven_inputs(system, component), start_values, rows)
    return replace(block, slopes=slopes)


def exchanged_texts(system: System, descriptions: Mapping[str, Description]) -> Iterator[Port]:
    """Go through the strings that are read or set in every step."""
    driven = {*system.inputs, *(connection.target for connection in system.connections)}
    for name, description in descriptions.items():
        for variable in description.variables:
            port = Port(name, variable.name)
            if variable.type == "String" and (variable.causality == "output" or port in driven):
                yield port


def readable_steps(nodes: tuple[Node, ...]) -> Callable[[Points], EndRequestError | None]:
    """Return what takes the steps between communication points, which end in the rows from 1 on.

    It returns what a component has asked for in the step that begins at its `time`; that step does not count.
    """

    def take(points: Points) -> EndRequestError | None:
        for row, (now, size) in enumerate(zip(points.times.tolist(), points.sizes.tolist(), strict=False), 1):
            try:
                step_once(nodes, row, now, size)
            except EndRequestError as end:
                return end
        return None

    return take


def step_once(nodes: tuple[Node, ...], row: int, time: float, size: float) -> None:
    """Take every component from `time` [s] to the communication point that is recorded in `row`."""
    for node in nodes:
        node.gather(row)
        node.slave.write(row)
        node.slave.step(time, size)
        node.slave.read(row)
