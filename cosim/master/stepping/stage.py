"""Memory for steps that may be repeated: a few rows for each component, from which a kept step is recorded."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, cast

import numpy as np

from cosim.master.stepping.channel import Channel, Drive, Span, Target
from cosim.recording.record import Block, allocate_block, allocate_slopes, base_type, initial_value
from cosim.recording.slave import Slave
from cosim.system.compatibility import StartValues
from cosim.system.description import Description, Variable
from cosim.system.signals import Signal
from cosim.system.structure import System, split_name

BEGIN, MIDDLE, END, WHOLE = range(4)
"""Rows: where a step begins and ends; the middle, where two halves meet; the end of a whole step beside them."""
_ROWS = 4
_NOTHING: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True)
class Part:
    """A component on the stage: what steps, its rows, and where its inputs come from."""

    name: str
    slave: Slave
    block: Block
    channels: tuple[Channel, ...]
    drives: tuple[Drive, ...]

    def gather_initial(self, tried: Mapping[str, float] = _NOTHING) -> None:
        """Copy the values that connections bring within row 0, but for those that are tried."""
        for channel in self.channels:
            channel.target.settle(0, tried.get(channel.target.name, channel.output(0)))

    def start(self, time: float) -> int:
        """Exchange values in initialization mode, once."""
        del time
        self.gather_initial()
        self.slave.write(0)
        self.slave.read(0)
        return 1

    def lead(
        self, begin: int, end: int, span: Span, held: Collection[str] = (), tried: Mapping[str, float] = _NOTHING
    ) -> None:
        """Step once, every input going to what it is at the end of the step.

        Parameters
        ----------
        begin, end : int
            Rows. What the component depends on has been stepped, but for what is tried.
        span : Span
            The time of the step.
        held : collection of str
            Names of inputs to hold at what they are at the end.
        tried : mapping of str to float
            Names of inputs, and values to take for what they are at the end.
        """
        for channel in self.channels:
            target = channel.target
            if not channel.continuous:
                target.hold(end, channel.output(begin))
            elif target.name in held:
                target.hold(end, tried.get(target.name, channel.last(begin, end, span.size)))
            else:
                last = tried.get(target.name, channel.last(begin, end, span.size))
                target.lead(end, channel.output(begin), last, span)
        for drive in self.drives:
            if not drive.constant:
                drive.lead(end, span)
        self.advance(end, span)

    def settle(self, begin: int, end: int, span: Span, tried: Mapping[str, float] = _NOTHING) -> None:
        """Note what the inputs are at the end of a step taken by `lead`."""
        for channel in self.channels:
            if channel.continuous:
                name = channel.target.name
                channel.target.settle(end, tried.get(name, channel.last(begin, end, span.size)))
        for drive in self.drives:
            if not drive.constant:
                drive.settle(end, span)

    def advance(self, row: int, span: Span) -> None:
        """Set the inputs, step, and get the outputs."""
        self.slave.write(row)
        self.slave.step(span.time, span.size)
        self.slave.read(row)


def set_stage(
    system: System, slaves: Mapping[str, Slave], start_values: StartValues, start_time: float
) -> dict[str, Part]:
    """Lay out the rows and connect the components.

    Parameters
    ----------
    system : System
        Checked by `cosim.system.compatibility.check_system`.
    slaves : mapping of str to Slave
        By name of component.
    start_values : mapping
        What `check_system` returned.
    start_time : float
        s.

    Returns
    -------
    dict of str to Part
        By name of component, in the order of the system.
    """
    targets = [*system.inputs, *(connection.target for connection in system.connections)]
    driven = {name: [split_name(end)[1] for end in targets if split_name(end)[0] == name] for name in slaves}
    blocks = {
        name: _allocate(slave.description, driven[name], start_values[name], slave.description.output_derivative_order)
        for name, slave in slaves.items()
    }
    drives = [_drive(name, signal, slaves, blocks, start_time) for name, signal in system.inputs.items()]
    channels = [_channel(end.source, end.target, slaves, blocks) for end in system.connections]
    return {
        component.name: Part(
            component.name,
            slaves[component.name],
            blocks[component.name],
            tuple(channel for channel in channels if split_name(channel.target.name)[0] == component.name),
            tuple(drive for drive in drives if split_name(drive.target.name)[0] == component.name),
        )
        for component in system.components
    }


def roll(parts: Mapping[str, Part]) -> None:
    """Let the next step begin where this one ended."""
    for part in parts.values():
        part.block.roll(END)


def _allocate(
    description: Description, driven: list[str], start_values: Mapping[Variable, Any], derivative_order: int
) -> Block:
    """Lay out a component: derivatives of inputs if it interpolates, of outputs if nothing it is given changes them."""
    block = allocate_block(description, driven, start_values, _ROWS)
    inputs = [description.by_name[name] for name in driven] if description.can_interpolate_inputs else []
    outputs = description.with_causality("output") if derivative_order and not driven else ()
    return replace(
        block,
        slopes=allocate_slopes([variable.reference for variable in inputs if _moves(variable)], _ROWS),
        output_slopes=allocate_slopes([variable.reference for variable in outputs if _moves(variable)], _ROWS),
    )


def _moves(variable: Variable) -> bool:
    """Whether a variable changes continuously."""
    return variable.type == "Real" and variable.variability == "continuous"


def _channel(source: str, target: str, slaves: Mapping[str, Slave], blocks: Mapping[str, Block]) -> Channel:
    """Resolve a connection."""
    component, name = split_name(source)
    output, block = slaves[component].description.by_name[name], blocks[component]
    driven = _target(target, slaves, blocks)
    section = block.outputs[base_type(output)]
    driven.settle(BEGIN, initial_value(driven.variable, {}))
    column = block.output_slopes.column(output.reference) if block.output_slopes else None
    return Channel(
        source,
        driven,
        max(output.nominal, driven.variable.nominal),
        _moves(output) and _moves(driven.variable),
        memoryview(cast(Any, section.values)),
        section.column(name),
        None if column is None or block.output_slopes is None else memoryview(cast(Any, block.output_slopes.values)),
        column or 0,
    )


def _drive(
    name: str, signal: Signal, slaves: Mapping[str, Slave], blocks: Mapping[str, Block], start_time: float
) -> Drive:
    """Resolve a signal, and let every row hold its first value."""
    drive = Drive(signal, _target(name, slaves, blocks))
    first = signal.values(np.array([start_time]))[0].item()
    for row in range(_ROWS):
        drive.target.hold(row, first)
    return drive


def _target(name: str, slaves: Mapping[str, Slave], blocks: Mapping[str, Block]) -> Target:
    """Resolve an input."""
    component, short = split_name(name)
    variable, block = slaves[component].description.by_name[short], blocks[component]
    section = block.inputs[base_type(variable)]
    column = block.slopes.column(variable.reference) if block.slopes else None
    slopes = None if column is None or block.slopes is None else memoryview(cast(Any, block.slopes.values))
    return Target(name, variable, memoryview(cast(Any, section.values)), section.column(short), slopes, column or 0)
