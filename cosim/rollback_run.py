"""Runs that can go back: steps are repeated until loops close, or taken back to try smaller ones."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cosim.algorithms import EXPLICIT
from cosim.compatibility import StartValues
from cosim.dependency import feedthrough_loops, feedthrough_reach
from cosim.description import Description
from cosim.error_estimate import ErrorEstimate
from cosim.explicit import Explicit
from cosim.grid import Grid
from cosim.growing_record import GrowingRecord
from cosim.guards import find_guards
from cosim.implicit import Implicit
from cosim.initialisation import Settling
from cosim.loop.coupled import CoupledLoop
from cosim.loop.failure import reporter
from cosim.method import Method
from cosim.record import Trace
from cosim.rollback_plan import RollbackPlan, plan_rollback
from cosim.run import Progress
from cosim.slave import Slave
from cosim.stage import Part, set_stage
from cosim.step_control import StepControl
from cosim.system import System, split_name


class RollbackRun:
    """A run of the implicit algorithm, or of any with a tolerance.

    Parameters
    ----------
    system : System
        Checked by `cosim.compatibility.check_system`, which returned the start values.
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
        self._parts = set_stage(system, slaves, start_values, float(grid.signal_times[0]))
        self.blocks = {name: part.block for name, part in self._parts.items()}
        repeated = [self._parts[name] for group in plan.groups for name in group.components]
        self.order = (*(part.name for part in repeated), *plan.last)
        self._stepper = (
            self._implicit(system, descriptions, plan, method)
            if method.implicit
            else (Explicit(repeated, [self._parts[name] for name in plan.last], EXPLICIT[method.algorithm]))
        )
        self._tape = GrowingRecord(self._parts, _notes(method))
        error = None
        if method.tolerance is not None:
            error = ErrorEstimate(repeated, method.tolerance, leads=method.implicit)
        saved = [self._parts[name] for name in plan.saved]
        halves = method.on_failure == "halve"
        self._control = StepControl(self._stepper, self._parts, saved, self._tape, error, halves=halves)

    def initialise(self) -> Settling:
        """Initialise all components."""
        return self._stepper.initialise(float(self._grid.times[0]))

    def advance(self, progress: Progress | None) -> None:
        """Take all steps."""
        self._control.run(self._grid, progress)

    def trace(self) -> Trace:
        """Return the recording."""
        return self._tape.trace()

    def record(self) -> dict[str, Any]:
        """Return numbers of steps, of those taken back, and how loops and errors came out."""
        tally, method = self._control.tally, self._method
        record: dict[str, Any] = {"steps": tally.steps, "compiled": False, "rejected": tally.rejected}
        if method.implicit:
            record["iteration_tolerance"] = method.iteration_tolerance
            record["on_failure"] = method.on_failure
            record["iterations"] = {"mean": tally.sweeps / max(1, tally.steps), "most": tally.most_sweeps}
            first = None if tally.first_unsolved is None else tally.first_unsolved.time
            record["unsolved"] = {"steps": tally.unsolved, "first": first, "largest_residual": tally.largest_residual}
        if method.tolerance is not None:
            record["tolerance"] = method.tolerance
            record["error_estimate"] = {
                "largest": tally.largest_error * method.tolerance,
                "mean": tally.error_time * method.tolerance / float(self._grid.times[-1] - self._grid.times[0]),
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


def _notes(method: Method) -> dict[str, Any]:
    """Return what to record of each step."""
    notes: dict[str, Any] = {"iterations": np.int32} if method.implicit else {}
    return notes if method.tolerance is None else {**notes, "error_estimate": np.float64}
