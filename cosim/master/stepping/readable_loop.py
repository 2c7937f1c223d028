"""The explicit steps between known communication points, to be read; `compiled_loop` takes the same in C."""

from __future__ import annotations

from collections.abc import Callable

from cosim.master.communication_points import Points
from cosim.master.stepping.wiring import Node


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
