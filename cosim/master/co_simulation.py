"""Couple slaves over communication points, and record what they put out.

Time is the start time plus a whole number of steps, or of parts of them, never a sum of steps. In step mode a
component's inputs are set, then it steps, then its outputs are read. FMI 2.0 allows no reading between setting and
stepping, so the master either passes on values that are old, or takes a step again.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict
from typing import Any

import numpy as np

from cosim.errors import SlaveError, format_time
from cosim.master.communication_points import Grid, communication_points
from cosim.master.observation import Observation
from cosim.master.run import Progress, Run, Snapshot
from cosim.master.slave import Slave
from cosim.recording.result import Result, RowMemory, Rows
from cosim.system.compatibility import StartValues, check_course, check_system, with_numbers
from cosim.system.conversion import conversion_of
from cosim.system.dependency import feedthrough_loops
from cosim.system.description import Description
from cosim.system.field_units import in_declared_units
from cosim.system.method import Method
from cosim.system.structure import System

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
        Values after initialisation and at the end of each step. Where a component has asked to end the simulation,
        they go up to the last communication point that all have reached, and the record's ``ended`` tells of it.

    Raises
    ------
    InputError
        If the system does not fit the slaves, or the times make no sense.
    LoopError
        If a loop has no solution, and the method does not go on without one.
    SlaveError
        If a component refuses a value or a step.
    """
    master = Master(system, slaves, stop_time=stop_time, step_size=step_size, start_time=start_time, method=method)
    return collect_rows(master, progress)


class Master:
    """A run in its parts, for those who keep its rows as they come; `co_simulate` keeps them all.

    Parameters
    ----------
    system, slaves, stop_time, step_size, start_time, method
        As of `co_simulate`.
    turn : callable, optional
        Gives the context in which the slaves have their turn, from a communication point [s] on: each window of steps,
        and whatever else they are asked for.

    Raises
    ------
    InputError
        If the system does not fit the slaves, or the times make no sense.

    Attributes
    ----------
    columns : tuple of Column
        What the rows consist of.
    steps : int
        Communication steps; where their size varies, the least there can be.
    time : float
        Communication point that has been reached, s.
    """

    def __init__(
        self,
        system: System,
        slaves: Mapping[str, Slave],
        *,
        stop_time: float,
        step_size: float,
        start_time: float = 0.0,
        method: Method | None = None,
        turn: Callable[[float], AbstractContextManager[object]] = nullcontext,
    ) -> None:
        method = method or Method()
        self._turn = turn
        descriptions = {name: slave.description for name, slave in slaves.items()}
        system = in_declared_units(system, descriptions)
        start_values = check_system(system, descriptions)
        system = with_numbers(system, descriptions)
        step_size = _within_run(slaves, start_time, stop_time, step_size)
        grid = _grid(system, slaves, start_time, stop_time, step_size)
        check_course(system, descriptions, start_time, stop_time)
        repeats = method.implicit or method.tolerance is not None
        self._slaves = slaves
        self._run = _run(repeats)(system, slaves, start_values, grid, method)
        self._observation = Observation(
            system, descriptions, self._run.blocks, self._run.notes, iterates=method.implicit
        )
        self.columns = self._observation.columns
        self.steps = grid.steps
        self._record: dict[str, Any] = {
            "algorithm": method.algorithm,
            "order": list(self._run.order),
            "connections": [f"{connection.source} -> {connection.target}" for connection in system.connections],
            **_converted(system, descriptions),
            "loops": [str(loop) for loop in feedthrough_loops(system, descriptions)],
            "start_time": start_time,
            "stop_time": grid.end,
            "step_size": step_size,
            "method": asdict(method),
        }
        self._timings = {"initialise": 0.0, "step": 0.0}
        self.time = start_time
        with turn(start_time):
            for name, block in self._run.blocks.items():
                slaves[name].setup(block, start_values[name], start_time, max(stop_time, grid.end))

    @property
    def done(self) -> float:
        """Return the part of the run that has been taken, from 0 to 1."""
        return self._run.done

    @property
    def plan(self) -> Mapping[str, Any]:
        """Return what is known of the run before it is begun: algorithm, order, connections, loops, times."""
        return self._record

    def begin(self) -> None:
        """Initialise all components.

        Raises
        ------
        LoopError
            If a loop has no solution at the start, and the method does not go on without one.
        SlaveError
            If a component refuses a value.
        """
        began = time.perf_counter()
        with self._turn(self.time):
            settling = self._run.initialise()
        self._record["initialisation"] = {"settled": settling.settled, "rounds": settling.rounds}
        self._timings["initialise"] += time.perf_counter() - began

    def rows(self, progress: Progress | None = None) -> Iterator[Rows]:
        """Take all steps that are left, and give the rows as they come; they are valid until the next are asked for.

        Raises
        ------
        LoopError
            If a loop has no solution, and the method does not go on without one.
        SlaveError
            If a component refuses a value or a step.
        """
        windows = self._run.windows()
        while True:
            began = time.perf_counter()
            with self._turn(self.time):
                window = next(windows, None)
            self._timings["step"] += time.perf_counter() - began
            if window is None:
                return
            self.time = float(window.times[-1])
            yield self._observation.rows(window)
            if progress is not None:
                progress(self.done)

    def snapshot(self) -> Snapshot:
        """Return what it takes to go on from here, the states of all components among it.

        Raises
        ------
        SlaveError
            If a component cannot give its state; all must be able to, as `check_serialisable` tells.
        """
        run = self._run.snapshot()
        with self._turn(self.time):
            states = {_state(name): np.frombuffer(slave.serialise(), np.uint8) for name, slave in self._slaves.items()}
        notes: dict[str, Any] = {
            "run": run.notes,
            "account": self._observation.snapshot(),
            "timings": dict(self._timings),
        }
        notes["time"] = self.time
        return Snapshot(notes, {**run.arrays, **states})

    def resume(self, snapshot: Snapshot) -> None:
        """Once begun, go on from where another run of the same system was."""
        notes = snapshot.notes
        self._run.restore(Snapshot(notes["run"], snapshot.arrays))
        self._observation.restore(notes["account"])
        self._timings, self.time = dict(notes["timings"]), float(notes["time"])
        with self._turn(self.time):
            for name, slave in self._slaves.items():
                slave.deserialise(snapshot.arrays[_state(name)].tobytes(), self.time)

    def end(self) -> dict[str, Any]:
        """Terminate all components, and return what is to be told of the run."""
        account = self.account()
        with self._turn(self.time):
            for name in self._run.order:
                try:
                    self._slaves[name].terminate()
                except SlaveError as error:
                    if account.get("ended", {}).get("component") != name:
                        raise
                    log.warning("%s", error)  # it has ended itself before
        return account

    def account(self) -> dict[str, Any]:
        """Return what is to be told of the run so far."""
        return {**self._record, **self._run.record(), **self._observation.record(), "timings": dict(self._timings)}


def collect_rows(master: Master, progress: Progress | None = None) -> Result:
    """Run from the beginning to the end, and keep all rows; raises what `Master.begin` and `Master.rows` do."""
    memory = RowMemory(master.columns, master.steps + 1)
    master.begin()
    for rows in master.rows(progress):
        memory.take(rows)
    return memory.result(master.end())


def _converted(system: System, descriptions: Mapping[str, Description]) -> dict[str, Any]:
    """Return what is to be told of connections that convert values, if there are any."""
    found = ((connection, conversion_of(connection, descriptions)) for connection in system.connections)
    told = {f"{one.source} -> {one.target}": each.record() for one, each in found if each is not None}
    return {"conversions": told} if told else {}


def _state(component: str) -> str:
    """Return the name of a component's state in a snapshot."""
    return f"state {component}"


def _within_run(slaves: Mapping[str, Slave], start_time: float, stop_time: float, step_size: float) -> float:
    """Return a step size that is not longer than the run, and say so where it was; FMUs of fixed step get theirs."""
    duration = stop_time - start_time
    if not 0.0 < duration < step_size < math.inf or not all(s.description.can_vary_step for s in slaves.values()):
        return step_size
    log.warning("step size is %g s, which is longer than the run; it is run in one step of %g s", step_size, duration)
    return duration


def _grid(system: System, slaves: Mapping[str, Slave], start_time: float, stop_time: float, step_size: float) -> Grid:
    """Lay out the communication points, and say which breakpoints cannot be met."""
    fixed = [name for name, slave in slaves.items() if not slave.description.can_vary_step]
    breakpoints = {name: signal.breakpoints for name, signal in system.inputs.items()}
    everything = [point for points in breakpoints.values() for point in points]
    grid = communication_points(start_time, stop_time, step_size, everything, not fixed)
    for missed in grid.missed:
        names = ", ".join(name for name, points in breakpoints.items() if missed in points)
        takes_effect = grid.after(missed)
        log.warning(
            "%s changes at t = %s s, which %s, of fixed step, cannot meet; the change takes effect at t = %s s",
            names,
            format_time(missed),
            fixed[0],
            format_time(takes_effect),
        )
    return grid


def _run(repeats: bool) -> Callable[[System, Mapping[str, Slave], StartValues, Grid, Method], Run]:
    """Return the kind of run that repeats steps, or the one that only goes forward."""
    # imported when there is a run, so that it costs little to import this module for its names
    if repeats:
        from cosim.master.rollback import RollbackRun

        return RollbackRun
    from cosim.master.fixed_step import ForwardRun

    return ForwardRun
