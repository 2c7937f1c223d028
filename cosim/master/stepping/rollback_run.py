"""Runs that can go back: steps are repeated until loops close, or taken back to try smaller ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from cosim.master.communication_points import Grid
from cosim.master.guards import find_guards
from cosim.master.loop.coupled import CoupledLoop
from cosim.master.loop.failure import reporter
from cosim.master.stepping.error_estimate import ErrorEstimate
from cosim.master.stepping.explicit import Explicit
from cosim.master.stepping.implicit import Implicit
from cosim.master.stepping.initialisation import Settling
from cosim.master.stepping.rollback_plan import RollbackPlan, plan_rollback
from cosim.master.stepping.run import MOST_STEPS, Snapshot, block_arrays
from cosim.master.stepping.stage import Part, set_stage
from cosim.master.stepping.step_control import StepControl
from cosim.master.stepping.window_record import WindowRecord
from cosim.recording.record import Window
from cosim.recording.slave import Slave
from cosim.system.algorithms import EXPLICIT
from cosim.system.compatibility import StartValues
from cosim.system.dependency import feedthrough_loops, feedthrough_reach
from cosim.system.description import Description
from cosim.system.method import Method
from cosim.system.structure import System, split_name


class RollbackRun:
    """A run of the implicit algorithm, or of any with a tolerance.

    Parameters
    ----------
    system : System
        Checked by `cosim.system.compatibility.check_system`, which returned the start values.
    slaves : mapping of str to Slave
        By name of component.
    start_values : mapping
        By component.
    grid : Grid
        Communication points that are met in any case.
    method : Method
        Algorithm and settings.
    """

    def __init__(
        self, system: System, slaves: Mapping[str, Slave], start_values: StartValues, grid: Grid, method: Method
    ) -> None:
        descriptions = {name: slave.description for name, slave in slaves.items()}
        plan = plan_rollback(system, descriptions, method)
        self._grid, self._method = grid, method
        self._guards = find_guards(system, descriptions)
        self._parts = set_stage(system, slaves, start_values, float(grid.points(0, 0).signal_times[0]))
        self.blocks = {name: part.block for name, part in self._parts.items()}
        repeated = [self._parts[name] for group in plan.groups for name in group.components]
        self.order = (*(part.name for part in repeated), *plan.last)
        self._stepper = (
            self._implicit(system, descriptions, plan, method)
            if method.implicit
            else (Explicit(repeated, [self._parts[name] for name in plan.last], EXPLICIT[method.algorithm]))
        )
        self.notes = _notes(method)
        recording = WindowRecord(self._parts, self.notes, MOST_STEPS)
        error = None
        if method.tolerance is not None:
            error = ErrorEstimate(repeated, method.tolerance, leads=method.implicit)
        saved = [self._parts[name] for name in plan.saved]
        halves = method.on_failure == "halve"
        self._control = StepControl(grid, self._stepper, self._parts, saved, recording, error, halves=halves)

    def initialise(self) -> Settling:
        """Initialise all components."""
        return self._stepper.initialise(self._grid.start_time)

    def windows(self) -> Iterator[Window]:
        """Take all steps."""
        return self._control.windows()

    @property
    def done(self) -> float:
        """Which part of the run has been taken, from 0 to 1."""
        return self._control.done

    def snapshot(self) -> Snapshot:
        """Return where the run is, the rows of the stage, and what the algorithm has learned."""
        arrays = {**block_arrays(self.blocks), **self._stepper.learned()}
        return Snapshot(self._control.snapshot(), {name: values.copy() for name, values in arrays.items()})

    def restore(self, snapshot: Snapshot) -> None:
        """Go on from there."""
        self._control.restore(snapshot.notes)
        for name, values in block_arrays(self.blocks).items():
            values[:] = snapshot.arrays[name]
        self._stepper.learn(snapshot.arrays)

    def record(self) -> dict[str, Any]:
        """Return numbers of steps, of those taken back, and how loops and errors came out."""
        tally, method = self._control.tally, self._method
        record: dict[str, Any] = {"steps": tally.steps, "step_loop": "python", "rejected": tally.rejected}
        record["step_loop_reason"] = "steps may be repeated"
        if method.implicit:
            record["iteration_tolerance"] = method.iteration_tolerance
            record["on_failure"] = method.on_failure
            record["iterations"] = {"mean": tally.sweeps / max(1, tally.steps), "most": tally.most_sweeps}
            unsolved = {"steps": tally.unsolved, "first": tally.first_unsolved}
            record["unsolved"] = {**unsolved, "largest_residual": tally.largest_residual}
        if method.tolerance is not None:
            record["tolerance"] = method.tolerance
            record["error_estimate"] = {
                "largest": tally.largest_error * method.tolerance,
                "mean": tally.error_time * method.tolerance / (self._grid.end - self._grid.start_time),
                "beyond_tolerance": tally.missed,
            }
        return record

    def _implicit(
        self, system: System, descriptions: Mapping[str, Description], plan: RollbackPlan, method: Method
    ) -> Implicit:
        """Make the stepper of the implicit algorithm."""
        explain = reporter(feedthrough_loops(system, descriptions), self._active_guards)
        units: list[Part | CoupledLoop] = []
        for group in plan.groups:
            parts = tuple(self._parts[name] for name in group.components)
            units += [CoupledLoop(parts, method.iteration_tolerance, explain)] if group.coupled else parts
        last = [self._parts[name] for name in plan.last]
        reach = feedthrough_reach(system, descriptions)
        return Implicit(units, last, reach, goes_on=method.on_failure == "explicit")

    def _active_guards(self, row: int) -> tuple[str, ...]:
        """Return the names of the guards that are active in a row."""
        values = ((name, split_name(name)) for name in self._guards)
        sections = ((name, self.blocks[component].outputs["Boolean"], short) for name, (component, short) in values)
        return tuple(name for name, section, short in sections if section.values[row, section.column(short)])


def _notes(method: Method) -> dict[str, np.dtype[Any]]:
    """Return what to record of each step."""
    notes: dict[str, np.dtype[Any]] = {"iterations": np.dtype(np.int32)} if method.implicit else {}
    return notes if method.tolerance is None else {**notes, "error_estimate": np.dtype(np.float64)}
