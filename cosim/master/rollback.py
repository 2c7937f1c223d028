"""Run with a way back: repeat steps until loops close, or reject them and try smaller ones.

A component that has to return to an earlier state for that, and cannot, is refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cosim.errors import SystemDefinitionError
from cosim.master.communication_points import Grid
from cosim.master.coupled_loop import CoupledLoop, reporter
from cosim.master.observation import find_guards
from cosim.master.run import MOST_STEPS, Settling, Snapshot, WindowRecord, block_arrays, refill
from cosim.master.slave import Slave
from cosim.master.state_trial import try_states
from cosim.master.step_control import BEGIN, ROWS, ErrorEstimate, StepControl
from cosim.master.stepper import Explicit, Implicit
from cosim.master.wiring import Node, driven_inputs, wire
from cosim.recording.record import Block, Window, allocate_block, allocate_slopes, initial_value
from cosim.system.compatibility import StartValues
from cosim.system.dependency import (
    SteppingGroup,
    feedthrough_loops,
    feedthrough_reach,
    moves,
    stepping_groups,
    stepping_order,
)
from cosim.system.description import Description, Variable
from cosim.system.method import Method
from cosim.system.signals import Value
from cosim.system.structure import Port, System


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
        self.order = (*(name for group in plan.groups for name in group.components), *plan.last)
        self.blocks = {
            part.name: stage_block(system, part.name, descriptions[part.name], start_values[part.name])
            for part in system.components
        }
        first = float(grid.points(0, 0).signal_times[0])
        nodes = wire(system, slaves, self.blocks, first, self.order, method.lag)
        _start_from_own_values(nodes)
        repeated, last = nodes[: len(nodes) - len(plan.last)], nodes[len(nodes) - len(plan.last) :]
        self._stepper = (
            self._implicit(system, descriptions, plan, {node.name: node for node in nodes})
            if method.implicit
            else Explicit(repeated, last)
        )
        error = None
        if method.tolerance is not None:
            error = ErrorEstimate(repeated, method.tolerance, leads=method.implicit)
            self._not_estimated = error.not_estimated(nodes)
        self._compares = error is not None and (error.compares or not system.connections)
        self.notes = _notes(method, self._compares)
        recording = WindowRecord(self.blocks, self.notes, MOST_STEPS)
        self._saved = [node for node in nodes if node.name in plan.saved]
        halves = method.on_failure == "halve"
        self._control = StepControl(grid, self._stepper, nodes, self._saved, recording, error, halves=halves)

    def initialise(self) -> Settling:
        """Initialise all components, and try whether they can return to an earlier state.

        Raises
        ------
        SystemDefinitionError
            If one cannot that will have to.
        """
        settling = self._stepper.initialise(self._grid.start_time)
        points = self._grid.points(0, 1)
        try_states(self._saved, float(points.times[0]), float(points.sizes[0]))
        return settling

    def windows(self) -> Iterator[Window]:
        """Take all steps."""
        return self._control.windows()

    @property
    def done(self) -> float:
        """Return the part of the run that has been taken, from 0 to 1."""
        return self._control.done

    def snapshot(self) -> Snapshot:
        """Return where the run is, the rows of the stage, and what the algorithm has learned."""
        arrays = {**block_arrays(self.blocks), **self._stepper.learned()}
        return Snapshot(self._control.snapshot(), {name: values.copy() for name, values in arrays.items()})

    def restore(self, snapshot: Snapshot) -> None:
        """Go on from there."""
        self._control.restore(snapshot.notes)
        for name, values in block_arrays(self.blocks).items():
            refill(values, snapshot.arrays[name])
        self._stepper.learn(snapshot.arrays)

    def record(self) -> dict[str, Any]:
        """Return numbers of steps, of those taken back, and how loops and errors came out."""
        tally, method = self._control.tally, self._method
        record: dict[str, Any] = {"steps": tally.steps, "step_loop": "python", "rejected": tally.rejected}
        record["step_loop_reason"] = "steps may be repeated"
        end = self._grid.end
        if self._control.end is not None:
            record["ended"], end = self._control.end.record(), self._control.reached
        if method.implicit:
            record["iteration_tolerance"] = method.iteration_tolerance
            record["on_failure"] = method.on_failure
            record["iterations"] = {"mean": tally.sweeps / max(1, tally.steps), "most": tally.most_sweeps}
            unsolved = {"steps": tally.unsolved, "first": tally.first_unsolved}
            record["unsolved"] = {**unsolved, "largest_residual": tally.largest_residual}
        if method.tolerance is not None:
            record["tolerance"] = method.tolerance
            mean = tally.error_time * method.tolerance / ((end - self._grid.start_time) or 1.0)
            record["error_estimate"] = {
                "largest": tally.largest_error * method.tolerance if self._compares else None,
                "mean": mean if self._compares else None,
                "beyond_tolerance": tally.missed,
                "not_estimated": self._not_estimated,
            }
        return record

    def _implicit(
        self,
        system: System,
        descriptions: Mapping[str, Description],
        plan: RollbackPlan,
        nodes: Mapping[str, Node],
    ) -> Implicit:
        """Make the stepper of the implicit algorithm."""
        explain = reporter(feedthrough_loops(system, descriptions), self._active_guards)
        units: list[Node | CoupledLoop] = []
        for group in plan.groups:
            members = tuple(nodes[name] for name in group.components)
            units += [CoupledLoop(members, self._method.iteration_tolerance, explain)] if group.coupled else members
        last = [nodes[name] for name in plan.last]
        reach = feedthrough_reach(system, descriptions)
        return Implicit(units, last, reach, goes_on=self._method.on_failure == "explicit")

    def _active_guards(self, row: int) -> tuple[Port, ...]:
        """Return the guards that are active in a row."""
        sections = ((port, self.blocks[port.component].outputs["Boolean"]) for port in self._guards)
        return tuple(port for port, section in sections if section.values[row, section.column(port.variable)])


def stage_block(
    system: System, component: str, description: Description, start_values: Mapping[Variable, Value]
) -> Block:
    """Lay out a component for steps that may be repeated, on a few rows.

    There are derivatives of the inputs if it interpolates, and of the outputs if nothing that it is given changes them.
    """
    driven = driven_inputs(system, component)
    inputs = [description.by_name[name] for name in driven] if description.can_interpolate_inputs else []
    outputs = () if driven or not description.output_derivative_order else description.with_causality("output")
    block = allocate_block(description, driven, start_values, ROWS)
    return replace(
        block,
        slopes=allocate_slopes([variable.reference for variable in inputs if variable.is_continuous], ROWS),
        output_slopes=allocate_slopes([variable.reference for variable in outputs if variable.is_continuous], ROWS),
    )


def _start_from_own_values(nodes: Iterable[Node]) -> None:
    """Let connected inputs begin at the start values of their FMUs, which a loop is closed from."""
    for node in nodes:
        for channel in node.channels:
            channel.target.settle(BEGIN, initial_value(channel.target.variable, {}))


def _notes(method: Method, compares: bool) -> dict[str, np.dtype[Any]]:
    """Return what to record of each step; no error where nothing is compared that would tell one."""
    notes: dict[str, np.dtype[Any]] = {"iterations": np.dtype(np.int32)} if method.implicit else {}
    return {**notes, "error_estimate": np.dtype(np.float64)} if compares else notes


@dataclass(frozen=True)
class RollbackPlan:
    """A plan for steps that may be repeated.

    Attributes
    ----------
    groups : tuple of SteppingGroup
        Components in stepping order; those of a coupled group are repeated until their values agree.
    last : tuple of str
        Components stepped when a step is kept, as they cannot be taken back.
    saved : tuple of str
        Components whose states are kept at the beginning of a step.
    """

    groups: tuple[SteppingGroup, ...]
    last: tuple[str, ...]
    saved: tuple[str, ...]


def plan_rollback(system: System, descriptions: Mapping[str, Description], method: Method) -> RollbackPlan:
    """Decide which components are repeated, and refuse those that have to be and cannot.

    An FMU that cannot return to an earlier state can still take part outside of loops: with steps that are never taken
    back as any other, and otherwise if nothing depends on it.

    Raises
    ------
    SystemDefinitionError
        Naming the components that lack a capability, and what they lack it for.
    """
    if method.implicit:
        continuous = [connection for connection in system.connections if moves(connection, descriptions)]
        groups = stepping_groups(system, descriptions, continuous)
    else:
        groups = tuple(SteppingGroup((name,), False) for name in stepping_order(system, descriptions, method.order))
    for group in groups:
        if group.coupled:
            what = f"the {method.algorithm} algorithm repeats the steps of {_list(group.components)}"
            _require_state(what, group.components, descriptions)
    coupled = tuple(name for group in groups if group.coupled for name in group.components)
    if not method.takes_back:
        return RollbackPlan(groups, (), coupled)
    why = "with a tolerance" if method.tolerance is not None else "to halve steps"
    _require_variable_step(why, descriptions)
    needed = {connection.source.component for connection in system.connections}
    last = tuple(
        name for name, description in descriptions.items() if not (description.can_save_state or name in needed)
    )
    saved = tuple(name for group in groups for name in group.components if name not in last)
    _require_state(f"{why}, steps are taken back", saved, descriptions)
    return RollbackPlan(tuple(group for group in groups if group.components[0] not in last), last, saved)


def _require_state(what: str, names: Iterable[str], descriptions: Mapping[str, Description]) -> None:
    """Refuse FMUs that cannot return to an earlier state."""
    unable = [name for name in names if not descriptions[name].can_save_state]
    if unable:
        models = _list(f"{name} ({descriptions[name].model_name})" for name in unable)
        raise SystemDefinitionError(
            f"{what}, but {models} cannot return to an earlier state (canGetAndSetFMUstate is false)"
        )


def _require_variable_step(why: str, descriptions: Mapping[str, Description]) -> None:
    """Refuse FMUs of fixed step."""
    unable = [name for name, description in descriptions.items() if not description.can_vary_step]
    if unable:
        models = _list(f"{name} ({descriptions[name].model_name})" for name in unable)
        raise SystemDefinitionError(
            f"{why}, steps vary in size, but {models} cannot do that (canHandleVariableCommunicationStepSize is false)"
        )


def _list(names: Iterable[str]) -> str:
    """Join names as in a sentence."""
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last
