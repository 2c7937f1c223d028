"""The explicit steps of a run with known communication points, to be read; `cosim.step_loop` takes the same in C."""

from __future__ import annotations

from collections.abc import Callable

from cosim.grid import Grid
from cosim.wiring import Node


def readable_steps(nodes: tuple[Node, ...], grid: Grid) -> Callable[[int, int], None]:
    """Return what takes the steps that end in the rows from a first to a last."""
    steps = list(zip(grid.times.tolist(), grid.sizes.tolist(), strict=False))

    def take(first: int, last: int) -> None:
        for row, (now, size) in enumerate(steps[first - 1 : last], first):
            step_once(nodes, row, now, size)

    return take


def step_once(nodes: tuple[Node, ...], row: int, time: float, size: float) -> None:
    """Take every component from `time` [s] to the communication point that is recorded in `row`."""
    for node in nodes:
        node.gather(row)
        node.slave.write(row)
        node.slave.step(time, size)
        node.slave.read(row)
