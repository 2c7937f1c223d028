"""The master: couples slaves over communication points and records what they put out.

Time is the start time plus a whole number of steps, never a sum of steps. In step mode a component's inputs are set,
then it steps, then its outputs are read. FMI 2.0 allows no reading between setting and stepping, so a value passes
through one component a step, and how old it is there is the algorithm's choice.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from cosim.algorithms import EXPLICIT
from cosim.compatibility import check_system
from cosim.dependency import feedthrough_loops, stepping_order
from cosim.errors import format_time
from cosim.grid import Grid, communication_points
from cosim.initialisation import initialise
from cosim.method import Method
from cosim.result import Result, collect
from cosim.slave import Slave
from cosim.step_loop import compiled_steps
from cosim.system import System
from cosim.wiring import Node, record_slopes, wire

log = logging.getLogger("cosim")

Progress = Callable[[float], None]
"""Told now and then which part of the run is done, from 0 to 1."""

_REPORTS = 200


def co_simulate(
    system: System,
    slaves: Mapping[str, Slave],
    *,
    stop_time: float,
    step_size: float,
    start_time: float = 0.0,
    method: Method | None = None,
    progress: Progress | None = None,
) -> Result:
    """Run a system of slaves from start to stop.

    Parameters
    ----------
    system : System
        What is coupled with what.
    slaves : mapping of str to Slave
        One for each component, by name; instantiated, not initialised.
    stop_time, step_size, start_time : float
        In s.
    method : Method, optional
        Algorithm and settings; by default Jacobi.
    progress : callable, optional
        Called now and then with the part of the run that is done.

    Returns
    -------
    Result
        Values after initialisation and at the end of each step.

    Raises
    ------
    InputError
        If the system does not fit the slaves, or the times make no sense.
    SlaveError
        If a component refuses a value or a step.
    """
    method = method or Method()
    descriptions = {name: slave.description for name, slave in slaves.items()}
    start_values = check_system(system, descriptions)
    order = stepping_order(system, descriptions, method.order)
    grid = _grid(system, slaves, start_time, stop_time, step_size)
    nodes = wire(system, slaves, start_values, grid, EXPLICIT[method.algorithm], order)
    began = time.perf_counter()
    last_time = max(stop_time, float(grid.times[-1]))
    for node in nodes:
        node.slave.setup(node.block, start_values[node.name], start_time, last_time)
    settling = initialise(nodes)
    initialised = time.perf_counter()
    loop = compiled_steps(nodes, grid) if method.compiled else None
    _advance(grid, loop or readable_steps(nodes, grid), progress)
    stepped = time.perf_counter()
    for node in nodes:
        node.slave.terminate()
    record_slopes(nodes, system, grid)
    record = {
        "algorithm": method.algorithm,
        "compiled": loop is not None,
        "order": list(order),
        "loops": [str(loop) for loop in feedthrough_loops(system, descriptions)],
        "start_time": start_time,
        "stop_time": float(grid.times[-1]),
        "step_size": step_size,
        "steps": grid.sizes.size,
        "initialisation": {"settled": settling.settled, "rounds": settling.rounds},
        "timings": {"initialise": initialised - began, "step": stepped - initialised},
    }
    blocks = {node.name: node.block for node in nodes}
    result = collect({part.name: blocks[part.name] for part in system.components}, grid.times, record)
    _warn_of_non_finite(result)
    return result


def step_once(nodes: tuple[Node, ...], row: int, time: float, size: float) -> None:
    """Take every component from `time` [s] to the communication point that is recorded in `row`."""
    for node in nodes:
        node.gather(row)
        node.slave.write(row)
        node.slave.step(time, size)
        node.slave.read(row)


def readable_steps(nodes: tuple[Node, ...], grid: Grid) -> Callable[[int, int], None]:
    """Return what takes the steps that end in the rows from a first to a last; `StepLoop` does the same in C."""
    steps = list(zip(grid.times.tolist(), grid.sizes.tolist(), strict=False))

    def take(first: int, last: int) -> None:
        for row, (now, size) in enumerate(steps[first - 1 : last], first):
            step_once(nodes, row, now, size)

    return take


def _advance(grid: Grid, take: Callable[[int, int], None], progress: Progress | None) -> None:
    """Take all steps, a chunk at a time."""
    steps = grid.sizes.size
    chunk = max(1, steps // _REPORTS)
    for first in range(1, steps + 1, chunk):
        last = min(first + chunk - 1, steps)
        take(first, last)
        if progress is not None:
            progress(last / steps)


def _grid(system: System, slaves: Mapping[str, Slave], start_time: float, stop_time: float, step_size: float) -> Grid:
    """Lay out the communication points, and say which breakpoints cannot be met."""
    fixed = [name for name, slave in slaves.items() if not slave.description.can_vary_step]
    breakpoints = {name: signal.breakpoints for name, signal in system.inputs.items()}
    everything = [point for points in breakpoints.values() for point in points]
    grid = communication_points(start_time, stop_time, step_size, everything, not fixed)
    for missed in grid.missed:
        names = ", ".join(name for name, points in breakpoints.items() if missed in points)
        takes_effect = float(grid.times[np.searchsorted(grid.times, missed)])
        log.warning(
            "%s changes at t = %s s, which %s, of fixed step, cannot meet; the change takes effect at t = %s s",
            names,
            format_time(missed),
            fixed[0],
            format_time(takes_effect),
        )
    return grid


def _warn_of_non_finite(result: Result) -> None:
    """Name the first output that ceases to be a finite number, if one does."""
    bad: list[tuple[float, str, Any]] = []
    for name, values in result.columns.items():
        if values.dtype == np.float64 and not np.isfinite(values).all():
            row = int(np.argmin(np.isfinite(values)))
            bad.append((float(result.time[row]), name, values[row]))
    if bad:
        when, name, value = min(bad)
        log.warning("%s is %s from t = %s s on", name, value, format_time(when))
