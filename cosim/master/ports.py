"""Memory for steps that may be repeated: a few rows for each component, from which a kept step is recorded.

How an input is given its value for one step: held, or on a straight line from the beginning of the step to its end.

While a step is under way, the row it leads to holds what is set before it: the value at its beginning, and the slope.
When it is over, the row holds the value in force at its end, which is what a record holds.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, cast

import numpy as np

from cosim.master.slave import Slave
from cosim.recording.record import Block, allocate_block, allocate_slopes, base_type, initial_value
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
        slopes=allocate_slopes([variable.reference for variable in inputs if variable.is_continuous], _ROWS),
        output_slopes=allocate_slopes([variable.reference for variable in outputs if variable.is_continuous], _ROWS),
    )


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
        output.is_continuous and driven.variable.is_continuous,
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


@dataclass(frozen=True)
class Span:
    """The time of a step.

    Attributes
    ----------
    time, size, end : float
        Communication point, communication step size and the next communication point, s.
    first, last : float
        When signals are evaluated for its beginning and its end, s: the same times but for rounding.
    """

    time: float
    size: float
    end: float
    first: float
    last: float

    @property
    def rounding(self) -> float:
        """By which part the step may be longer or shorter to an FMU that keeps a time of its own."""
        return 8.0 * math.ulp(max(abs(self.time), abs(self.end), self.size)) / self.size


@dataclass(frozen=True)
class Target:
    """A driven input.

    Attributes
    ----------
    name : str
        ``component.variable``.
    variable : Variable
        The input.
    values : memoryview
        Rows and columns that hold it.
    column : int
        In `values`.
    slopes : memoryview, optional
        Rows and columns of derivatives; None if the FMU holds what it is given.
    slope_column : int
        In `slopes`.
    """

    name: str
    variable: Variable
    values: Any
    column: int
    slopes: Any
    slope_column: int

    def hold(self, row: int, value: float) -> None:
        """Let the input be constant over the step."""
        self.values[row, self.column] = value
        if self.slopes is not None:
            self.slopes[row, self.slope_column] = 0.0

    def lead(self, row: int, first: float, last: float, span: Span) -> None:
        """Let the input go from one value to another; an FMU that holds what it is given is given the last."""
        if self.slopes is None:
            self.values[row, self.column] = last
        else:
            self.values[row, self.column] = first
            self.slopes[row, self.slope_column] = self._slope_within_bounds(first, last, span)

    def settle(self, row: int, last: float) -> None:
        """Note the value at the end of the step, which is over."""
        self.values[row, self.column] = last

    def _slope_within_bounds(self, first: float, last: float, span: Span) -> float:
        """Return the slope; where the value ends at a bound, so little less that rounding does not lead past it."""
        slope = (last - first) / span.size
        uncertain = abs(last - first) * span.rounding
        low, high = self.variable.minimum, self.variable.maximum
        if (low is not None and low <= last < low + uncertain) or (
            high is not None and high >= last > high - uncertain
        ):
            slope *= 1.0 - span.rounding
        return slope

    def value(self, row: int) -> float:
        """Return the value in force at the end of the step that led to a row."""
        return self.values[row, self.column]

    def slope(self, row: int) -> float:
        """Return the derivative in the step that led to a row."""
        return 0.0 if self.slopes is None else self.slopes[row, self.slope_column]


@dataclass(frozen=True)
class Channel:
    """A connection: an output and the input it drives.

    Attributes
    ----------
    source : str
        ``component.variable`` of the output.
    target : Target
        The input.
    nominal : float
        A usual size of the value, in its unit.
    continuous : bool
        Whether the value changes continuously but for a few places; if not, it is passed on as it is and held.
    outputs : memoryview
        Rows and columns that hold the output.
    column : int
        In `outputs`.
    derivatives : memoryview, optional
        Rows and columns of output derivatives, where the output goes on along its derivative whatever the others do.
    derivative_column : int
        In `derivatives`.
    """

    source: str
    target: Target
    nominal: float
    continuous: bool
    outputs: Any
    column: int
    derivatives: Any = None
    derivative_column: int = 0

    def output(self, row: int) -> float:
        """Return what the source put out at the end of the step that led to a row."""
        return self.outputs[row, self.column]

    def last(self, begin: int, end: int, size: float) -> float:
        """Return the output at the end of a step, before a jump: what came back, or what its derivative promised."""
        if self.derivatives is None:
            return self.output(end)
        return self.output(begin) + size * self.derivatives[begin, self.derivative_column]


@dataclass(frozen=True)
class Drive:
    """A signal and the input it drives.

    Every row holds the value of a constant from the start on, so that nothing is to be done for it.
    """

    signal: Signal
    target: Target

    @property
    def constant(self) -> bool:
        """Whether it never changes."""
        return self.signal.held is not None

    def hold(self, row: int, span: Span) -> None:
        """Hold the value at the beginning of the step; an FMU that interpolates follows the slope there."""
        self.target.hold(row, self.first(span))
        if self.target.slopes is not None:
            self.target.slopes[row, self.target.slope_column] = self.signal.slopes(np.array([span.first]))[0]

    def lead(self, row: int, span: Span) -> None:
        """Go from the value at the beginning of the step to that at its end; what is not Real is held."""
        if self.target.variable.type == "Real":
            self.target.lead(row, self.first(span), self.last(span), span)
        else:
            self.target.hold(row, self.first(span))

    def settle(self, row: int, span: Span) -> None:
        """Note the value at the end of a step in which the input was not held."""
        if self.target.variable.type == "Real":
            self.target.settle(row, self.last(span))

    def first(self, span: Span) -> float:
        """Return the value at the beginning of a step, after a jump."""
        return self.signal.values(np.array([span.first]))[0].item()

    def last(self, span: Span) -> float:
        """Return the value at the end of a step, before a jump."""
        return self.signal.left_values(np.array([span.last]))[0].item()
