"""The master: couples slaves over communication points and records what they put out.

Time is the start time plus a whole number of steps, or of parts of them, never a sum of steps. In step mode a
component's inputs are set, then it steps, then its outputs are read. FMI 2.0 allows no reading between setting and
stepping, so the master either passes on values that are old, or takes a step again.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cosim.compatibility import check_system
from cosim.dependency import feedthrough_loops
from cosim.energy_residual import energy_residual
from cosim.errors import format_time
from cosim.forward_run import ForwardRun
from cosim.grid import Grid, communication_points
from cosim.guards import active_spans, find_guards
from cosim.method import Method
from cosim.power_bonds import find_bonds
from cosim.result import Result, collect
from cosim.rollback_run import RollbackRun
from cosim.run import Progress, Run
from cosim.slave import Slave
from cosim.system import System

log = logging.getLogger("cosim")


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
    LoopError
        If a loop has no solution, and the method does not go on without one.
    SlaveError
        If a component refuses a value or a step.
    """
    method = method or Method()
    descriptions = {name: slave.description for name, slave in slaves.items()}
    start_values = check_system(system, descriptions)
    guards, bonds = find_guards(system, descriptions), find_bonds(system, descriptions)
    grid = _grid(system, slaves, start_time, stop_time, step_size)
    repeats = method.implicit or method.tolerance is not None
    run: Run = (RollbackRun if repeats else ForwardRun)(system, slaves, start_values, grid, method)
    last_time = max(stop_time, float(grid.times[-1]))
    for name, block in run.blocks.items():
        slaves[name].setup(block, start_values[name], start_time, last_time)
    record: dict[str, Any] = {
        "algorithm": method.algorithm,
        "order": list(run.order),
        "connections": [f"{connection.source} -> {connection.target}" for connection in system.connections],
        "loops": [str(loop) for loop in feedthrough_loops(system, descriptions)],
        "start_time": start_time,
        "stop_time": float(grid.times[-1]),
        "step_size": step_size,
        **_perform(run, slaves, progress),
    }
    trace = run.trace()
    accounts = {bond.input: energy_residual(bond, trace) for bond in bonds}
    record["energy_residual"] = {name: account.summary() for name, account in accounts.items()}
    observables = {**trace.notes, **{f"energy_residual.{name}": (one.residual, "J") for name, one in accounts.items()}}
    result = collect([component.name for component in system.components], trace, observables, record)
    _warn_of_non_finite(result)
    return replace(result, record={**record, "guards": active_spans(guards, result.time, result.columns)})


def _perform(run: Run, slaves: Mapping[str, Slave], progress: Progress | None) -> dict[str, Any]:
    """Initialise, take all steps, terminate, and tell how it went."""
    began = time.perf_counter()
    settling = run.initialise()
    initialised = time.perf_counter()
    run.advance(progress)
    stepped = time.perf_counter()
    for name in run.order:
        slaves[name].terminate()
    return {
        **run.record(),
        "initialisation": {"settled": settling.settled, "rounds": settling.rounds},
        "timings": {"initialise": initialised - began, "step": stepped - initialised},
    }


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
