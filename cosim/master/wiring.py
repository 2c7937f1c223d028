"""From a checked system to nodes: each component with its memory and the places its inputs come from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from cosim.master.communication_points import Points
from cosim.master.slave import Slave
from cosim.recording.record import Block, Section, Slopes, allocate_block, allocate_slopes, base_type
from cosim.system.compatibility import StartValues
from cosim.system.description import Description
from cosim.system.method import Lag
from cosim.system.signals import FloatArray, Signal
from cosim.system.structure import System, split_name

# Source array and column, target array and column, and how many rows the source lags behind.
Link = tuple[Any, int, Any, int, int]


@dataclass(frozen=True)
class Feed:
    """A signal, and the column of inputs that it fills.

    Attributes
    ----------
    signal : Signal
        What drives the input.
    values, column : ndarray, int
        Where its values go.
    slopes, slope_column : ndarray, int
        Where its derivatives [1/s] go; None where they are all zero or not wanted.
    """

    signal: Signal
    values: NDArray[Any]
    column: int
    slopes: FloatArray | None = None
    slope_column: int = 0

    def fill(self, points: Points) -> None:
        """Fill rows 1, 2, and so on: a row has what is set at the beginning of the step that leads to it."""
        begins = points.signal_times[:-1]
        rows = slice(1, points.signal_times.size)
        self.values[rows, self.column] = self.signal.values(begins)
        if self.slopes is not None:
            self.slopes[rows, self.slope_column] = self.signal.slopes(begins)

    def settle(self, points: Points) -> None:
        """Once the steps are taken, record an input given with a slope as it was at their ends."""
        if self.slopes is not None:
            rows = slice(1, points.signal_times.size)
            self.values[rows, self.column] = self.signal.left_values(points.signal_times[1:])


@dataclass(frozen=True)
class Node:
    """A component in a run.

    Attributes
    ----------
    name : str
        Of the component.
    slave : Slave
        What steps.
    block : Block
        What is recorded.
    links : tuple
        Where the inputs come from: source array and column, target array and column, lag in rows. The arrays are
        memory views, on which copying one number costs a tenth of what it costs on NumPy arrays.
    feeds : tuple of Feed
        Signals that drive inputs.
    """

    name: str
    slave: Slave
    block: Block
    links: tuple[Link, ...]
    feeds: tuple[Feed, ...] = field(default=())

    def gather(self, row: int) -> None:
        """Copy the values that connections bring into the input row `row`."""
        for source, source_column, target, target_column, lag in self.links:
            target[row, target_column] = source[row - lag, source_column]

    def gather_initial(self) -> None:
        """Copy the values that connections bring within row 0."""
        for source, source_column, target, target_column, _ in self.links:
            target[0, target_column] = source[0, source_column]


def wire(
    system: System,
    slaves: Mapping[str, Slave],
    start_values: StartValues,
    rows: int,
    start_time: float,
    lag: Lag,
    order: Sequence[str],
) -> tuple[Node, ...]:
    """Lay out the recording and connect the components.

    Parameters
    ----------
    system : System
        Checked by `cosim.system.compatibility.check_system`.
    slaves : mapping of str to Slave
        By name of component.
    start_values : mapping
        What `check_system` returned.
    rows : int
        For how many communication points there is room.
    start_time : float
        s.
    lag : callable
        An algorithm of `cosim.system.method`.
    order : sequence of str
        Names of the components in stepping order.

    Returns
    -------
    tuple of Node
        In stepping order.
    """
    driven: dict[str, list[str]] = {name: [] for name in slaves}
    for target in [*system.inputs, *(connection.target for connection in system.connections)]:
        component, variable = split_name(target)
        driven[component].append(variable)
    blocks: dict[str, Block] = {}
    feeds: dict[str, tuple[Feed, ...]] = {}
    for name, slave in slaves.items():
        signals = {split_name(key)[1]: value for key, value in system.inputs.items() if split_name(key)[0] == name}
        block = allocate_block(slave.description, driven[name], start_values[name], rows)
        blocks[name] = replace(block, slopes=_slopes(slave.description, signals, rows))
        feeds[name] = _feeds(blocks[name], slave.description, signals, start_time)
    places = {name: place for place, name in enumerate(order)}
    links: dict[str, list[Link]] = {name: [] for name in slaves}
    for connection in system.connections:
        source, target = split_name(connection.source)[0], split_name(connection.target)[0]
        link = _link(connection.source, connection.target, slaves, blocks, lag(places[source], places[target]))
        links[target].append(link)
    return tuple(Node(name, slaves[name], blocks[name], tuple(links[name]), feeds[name]) for name in order)


def _link(source: str, target: str, slaves: Mapping[str, Slave], blocks: Mapping[str, Block], lag: int) -> Link:
    """Resolve a connection to arrays and columns."""
    source_section = _section(source, slaves, blocks, "outputs")
    target_section = _section(target, slaves, blocks, "inputs")
    return (
        memoryview(cast(Any, source_section.values)),
        source_section.column(split_name(source)[1]),
        memoryview(cast(Any, target_section.values)),
        target_section.column(split_name(target)[1]),
        lag,
    )


def _section(name: str, slaves: Mapping[str, Slave], blocks: Mapping[str, Block], side: str) -> Section:
    """Find the section that holds ``component.variable``."""
    component, variable = split_name(name)
    kind = base_type(slaves[component].description.by_name[variable])
    return cast(Mapping[str, Section], getattr(blocks[component], side))[kind]


def _slopes(description: Description, signals: Mapping[str, Signal], rows: int) -> Slopes | None:
    """Make room for the derivatives of signals that have any, where the component can use them."""
    variables = [description.by_name[name] for name, signal in signals.items() if not signal.is_level]
    references = [variable.reference for variable in variables if variable.type == "Real"]
    return allocate_slopes(references, rows) if description.can_interpolate_inputs else None


def _feeds(
    block: Block, description: Description, signals: Mapping[str, Signal], start_time: float
) -> tuple[Feed, ...]:
    """Resolve the signals of a component, and put what they start from into row 0."""
    feeds: list[Feed] = []
    for name, signal in signals.items():
        variable = description.by_name[name]
        section = block.inputs[base_type(variable)]
        column = section.column(name)
        section.values[0, column] = signal.values(np.array([start_time]))[0]
        place = None if block.slopes is None or variable.type != "Real" else block.slopes.column(variable.reference)
        slopes = None if block.slopes is None or place is None else block.slopes.values
        feeds.append(Feed(signal, section.values, column, slopes, place or 0))
    return tuple(feeds)
