"""Wire a checked system: give each component its memory, and the places its inputs come from.

There is one model of the wiring for steps that are taken once and for steps that may be repeated. What differs is the
memory: a row for each step of a window, or a stage of a few rows on which a step is tried and, if kept, recorded.

A row holds what is true at the end of the step that leads to it. While the step is under way, it holds what is set
before it: the value at its beginning, and the slope. When it is over, it holds the value in force at its end, which is
what a record holds.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, cast

import numpy as np

from cosim.master.communication_points import Points
from cosim.master.slave import Slave
from cosim.recording.record import TEXT, Block, Section, Slopes, base_type
from cosim.system.conversion import Conversion, conversion_of
from cosim.system.description import Variable
from cosim.system.method import Lag
from cosim.system.signals import Signal, Value
from cosim.system.structure import Connection, Port, System

Link = tuple[Any, int, Any, int, int]
"""Source array and column, target array and column, and how many rows the source lags behind."""

ConvertedLink = tuple[Link, Conversion]
"""A link, and what becomes of the value on the way."""

_NOTHING: Mapping[Port, float] = MappingProxyType({})


@dataclass(frozen=True)
class Node:
    """A component in a run: what steps, its memory, and where its inputs come from.

    Attributes
    ----------
    name : str
        Of the component.
    slave : Slave
        What steps.
    block : Block
        Its rows.
    channels : tuple of Channel
        Connections that lead to its inputs.
    drives : tuple of Drive
        Signals that drive its inputs.
    links : tuple
        The channels as plain tuples on memory views. The loop to read walks them, since looking up an attribute costs
        as much as copying a number, and copying one between NumPy arrays ten times that.
    converted : tuple
        Links of the channels that pass values on in another form, apart from the others.
    """

    name: str
    slave: Slave
    block: Block
    channels: tuple[Channel, ...]
    drives: tuple[Drive, ...]
    links: tuple[Link, ...] = field(init=False)
    converted: tuple[ConvertedLink, ...] = field(init=False)

    def __post_init__(self) -> None:
        plain = tuple(channel.link() for channel in self.channels if channel.conversion is None)
        object.__setattr__(self, "links", plain)
        converted = tuple((each.link(), each.conversion) for each in self.channels if each.conversion is not None)
        object.__setattr__(self, "converted", converted)

    def gather(self, row: int) -> None:
        """Copy the values that connections bring into the input row `row`, each as old as the algorithm has it."""
        for source, source_column, target, target_column, lag in self.links:
            target[row, target_column] = source[row - lag, source_column]
        for (source, source_column, target, target_column, lag), conversion in self.converted:
            target[row, target_column] = conversion.of(source[row - lag, source_column])

    def gather_initial(self, tried: Mapping[Port, float] = _NOTHING) -> None:
        """Copy the values that connections bring within row 0, but for those that are tried."""
        for channel in self.channels:
            channel.target.settle(0, tried.get(channel.target.port, channel.output(0)))

    def start(self, time: float) -> int:
        """Exchange values in initialization mode, once."""
        del time
        self.gather_initial()
        self.slave.write(0)
        self.slave.read(0)
        return 1

    def lead(
        self, begin: int, end: int, span: Span, held: Collection[Port] = (), tried: Mapping[Port, float] = _NOTHING
    ) -> None:
        """Step once, every input going to what it is at the end of the step.

        Parameters
        ----------
        begin, end : int
            Rows. What the component depends on has been stepped, but for what is tried.
        span : Span
            The time of the step.
        held : collection of Port
            Inputs to hold at what they are at the end.
        tried : mapping of Port to float
            Inputs, and values to take for what they are at the end.
        """
        for channel in self.channels:
            target = channel.target
            if not channel.continuous:
                target.hold(end, channel.output(begin))
            elif target.port in held:
                target.hold(end, tried.get(target.port, channel.last(begin, end, span.size)))
            else:
                last = tried.get(target.port, channel.last(begin, end, span.size))
                target.lead(end, channel.output(begin), last, span)
        for drive in self.drives:
            if not drive.constant:
                drive.lead(end, span)
        self.advance(end, span)

    def settle(self, begin: int, end: int, span: Span, tried: Mapping[Port, float] = _NOTHING) -> None:
        """Note what the inputs are at the end of a step taken by `lead`."""
        for channel in self.channels:
            if channel.continuous:
                last = tried.get(channel.target.port, channel.last(begin, end, span.size))
                channel.target.settle(end, last)
        for drive in self.drives:
            if not drive.constant:
                drive.settle(end, span)

    def advance(self, row: int, span: Span) -> None:
        """Set the inputs, step, and get the outputs."""
        self.slave.write(row)
        self.slave.step(span.time, span.size)
        self.slave.read(row)


def driven_inputs(system: System, component: str) -> list[str]:
    """Return the names of the inputs and parameters of a component that signals or connections drive."""
    targets = [*system.inputs, *(connection.target for connection in system.connections)]
    return [port.variable for port in targets if port.component == component]


def wire(
    system: System,
    slaves: Mapping[str, Slave],
    blocks: Mapping[str, Block],
    start_time: float,
    order: Sequence[str],
    lag: Lag | None = None,
) -> tuple[Node, ...]:
    """Connect the components.

    Parameters
    ----------
    system : System
        Checked by `cosim.system.compatibility.check_system`.
    slaves : mapping of str to Slave
        By name of component.
    blocks : mapping of str to Block
        Memory of each; signals that drive inputs put their first value into every row.
    start_time : float
        s.
    order : sequence of str
        Names of the components in stepping order.
    lag : callable, optional
        An algorithm of `cosim.system.method`; by default no value is old.

    Returns
    -------
    tuple of Node
        In stepping order.
    """
    places = {name: place for place, name in enumerate(order)}
    channels: dict[str, list[Channel]] = {name: [] for name in order}
    for connection in system.connections:
        source, target = connection.source.component, connection.target.component
        late = 0 if lag is None else lag(places[source], places[target])
        channels[target].append(_channel(connection, slaves, blocks, late))
    drives: dict[str, list[Drive]] = {name: [] for name in order}
    for port, signal in system.inputs.items():
        drive = Drive(signal, _target(port, slaves, blocks))
        drive.start(start_time)
        drives[port.component].append(drive)
    return tuple(Node(name, slaves[name], blocks[name], tuple(channels[name]), tuple(drives[name])) for name in order)


def _channel(connection: Connection, slaves: Mapping[str, Slave], blocks: Mapping[str, Block], lag: int) -> Channel:
    """Resolve a connection."""
    source, target = connection.source, _target(connection.target, slaves, blocks)
    output, block = slaves[source.component].description.by_name[source.variable], blocks[source.component]
    section = block.outputs[base_type(output)]
    derivatives, column = _slopes(block.output_slopes, output)
    conversion = conversion_of(connection, {name: slave.description for name, slave in slaves.items()})
    scale = 1.0 if conversion is None else abs(conversion.factor)
    return Channel(
        source,
        target,
        max(scale * output.nominal, target.variable.nominal),
        output.is_continuous and target.variable.is_continuous,
        _cells(section),
        section.column(source.variable),
        lag,
        derivatives,
        column,
        conversion,
    )


def _target(port: Port, slaves: Mapping[str, Slave], blocks: Mapping[str, Block]) -> Target:
    """Resolve an input."""
    variable, block = slaves[port.component].description.by_name[port.variable], blocks[port.component]
    section = block.inputs[base_type(variable)]
    slopes, column = _slopes(block.slopes, variable)
    return Target(port, variable, _cells(section), section.column(port.variable), slopes, column)


def _cells(section: Section) -> Any:
    """Return the values of a section as what is quickest to index; there are no memory views of strings."""
    return section.values if section.values.dtype == TEXT else memoryview(cast(Any, section.values))


def _slopes(slopes: Slopes | None, variable: Variable) -> tuple[Any, int]:
    """Find the derivatives of a variable, if there are any; others than Real may have the reference of one that has."""
    column = slopes.column(variable.reference) if slopes is not None and variable.type == "Real" else None
    return (None, 0) if slopes is None or column is None else (memoryview(cast(Any, slopes.values)), column)


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
    """A driven input, or tunable parameter.

    Attributes
    ----------
    port : Port
        Its address.
    variable : Variable
        The input.
    values : memoryview
        Rows and columns that hold it; of strings, an array.
    column : int
        In `values`.
    slopes : memoryview, optional
        Rows and columns of derivatives; None if the FMU holds what it is given.
    slope_column : int
        In `slopes`.
    """

    port: Port
    variable: Variable
    values: Any
    column: int
    slopes: Any
    slope_column: int

    def hold(self, row: int, value: Value) -> None:
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

    def settle(self, row: int, last: Value) -> None:
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
    source : Port
        The output.
    target : Target
        The input.
    nominal : float
        A usual size of the value, in the unit of the input.
    continuous : bool
        Whether the value changes continuously but for a few places; if not, it is passed on as it is and held.
    outputs : memoryview
        Rows and columns that hold the output.
    column : int
        In `outputs`.
    lag : int
        How many steps old the value is that an explicit algorithm passes on.
    derivatives : memoryview, optional
        Rows and columns of output derivatives, where the output goes on along its derivative whatever the others do.
    derivative_column : int
        In `derivatives`.
    conversion : Conversion, optional
        What becomes of the value on the way; what `output` and `last` return has been converted.
    """

    source: Port
    target: Target
    nominal: float
    continuous: bool
    outputs: Any
    column: int
    lag: int = 0
    derivatives: Any = None
    derivative_column: int = 0
    conversion: Conversion | None = None

    def link(self) -> Link:
        """Return it as a plain tuple."""
        return self.outputs, self.column, self.target.values, self.target.column, self.lag

    def output(self, row: int) -> float:
        """Return what the source put out at the end of the step that led to a row, as the input gets it."""
        value = self.outputs[row, self.column]
        return value if self.conversion is None else self.conversion.of(value)

    def last(self, begin: int, end: int, size: float) -> float:
        """Return the output at the end of a step, before a jump: what came back, or what its derivative promised."""
        if self.derivatives is None:
            return self.output(end)
        change = size * self.derivatives[begin, self.derivative_column]
        return self.output(begin) + (change if self.conversion is None else self.conversion.factor * change)


@dataclass(frozen=True)
class Drive:
    """A signal and the input, or tunable parameter, that it drives.

    Every row holds the value of a constant from the start on, so that nothing is to be done for it. A parameter is held
    over each step at what the signal is at its beginning.

    Attributes
    ----------
    signal : Signal
        What drives the input.
    target : Target
        The input; its slopes are those that are not known to be zero.
    constant : bool
        Whether it never changes.
    """

    signal: Signal
    target: Target
    constant: bool = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "constant", self.signal.held is not None)

    def start(self, time: float) -> None:
        """Let every row hold the value at a time [s]."""
        np.asarray(self.target.values)[:, self.target.column] = self.signal.values(np.array([time]))[0].item()

    def fill(self, points: Points) -> None:
        """Fill rows 1, 2, and so on: a row has what is set at the beginning of the step that leads to it."""
        begins = points.signal_times[:-1]
        rows = slice(1, points.signal_times.size)
        np.asarray(self.target.values)[rows, self.target.column] = self.signal.values(begins)
        if self.target.slopes is not None:
            np.asarray(self.target.slopes)[rows, self.target.slope_column] = self.signal.slopes(begins)

    def settle_filled(self, points: Points) -> None:
        """Once the steps are taken, record an input given with a slope as it was at their ends."""
        if self.target.slopes is not None:
            rows = slice(1, points.signal_times.size)
            ends = self.signal.left_values(points.signal_times[1:])
            np.asarray(self.target.values)[rows, self.target.column] = ends

    def hold(self, row: int, span: Span) -> None:
        """Hold the value at the beginning of the step; an FMU that interpolates follows the slope there."""
        self.target.hold(row, self.first(span))
        if self.target.slopes is not None:
            self.target.slopes[row, self.target.slope_column] = self.signal.slopes(np.array([span.first]))[0]

    def lead(self, row: int, span: Span) -> None:
        """Go from the value at the beginning of the step to that at its end; what is no Real input is held."""
        if self._moves:
            self.target.lead(row, self.first(span), self.last(span), span)
        else:
            self.target.hold(row, self.first(span))

    def settle(self, row: int, span: Span) -> None:
        """Note the value at the end of a step in which the input was not held."""
        if self._moves:
            self.target.settle(row, self.last(span))

    @property
    def _moves(self) -> bool:
        """Tell whether it may change within a step."""
        return self.target.variable.type == "Real" and not self.target.variable.tunable

    def first(self, span: Span) -> float:
        """Return the value at the beginning of a step, after a jump."""
        return self.signal.values(np.array([span.first]))[0].item()

    def last(self, span: Span) -> float:
        """Return the value at the end of a step, before a jump."""
        return self.signal.left_values(np.array([span.last]))[0].item()
