"""From a checked system to nodes: each component with its memory and the places its inputs come from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from cosim.algorithms import Lag
from cosim.compatibility import StartValues
from cosim.description import Description
from cosim.grid import Grid
from cosim.record import Block, Section, Slopes, allocate_block, base_type
from cosim.signals import FloatArray, Signal
from cosim.slave import Slave
from cosim.system import System, split_name

# Source array and column, target array and column, and how many rows the source lags behind.
Link = tuple[Any, int, Any, int, int]


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
    """

    name: str
    slave: Slave
    block: Block
    links: tuple[Link, ...]

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
    grid: Grid,
    lag: Lag,
    order: Sequence[str],
) -> tuple[Node, ...]:
    """Lay out the recording and connect the components.

    Parameters
    ----------
    system : System
        Checked by `cosim.compatibility.check_system`.
    slaves : mapping of str to Slave
        By name of component.
    start_values : mapping
        What `check_system` returned.
    grid : Grid
        Communication points.
    lag : callable
        An algorithm of `cosim.algorithms`.
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
    rows = grid.times.size
    blocks = {
        name: allocate_block(slave.description, driven[name], start_values[name], rows)
        for name, slave in slaves.items()
    }
    for name in slaves:
        signals = {split_name(key)[1]: value for key, value in system.inputs.items() if split_name(key)[0] == name}
        blocks[name] = _fill_signals(blocks[name], slaves[name].description, signals, grid)
    places = {name: place for place, name in enumerate(order)}
    links: dict[str, list[Link]] = {name: [] for name in slaves}
    for connection in system.connections:
        source, target = split_name(connection.source)[0], split_name(connection.target)[0]
        link = _link(connection.source, connection.target, slaves, blocks, lag(places[source], places[target]))
        links[target].append(link)
    return tuple(Node(name, slaves[name], blocks[name], tuple(links[name])) for name in order)


def record_slopes(nodes: tuple[Node, ...], system: System, grid: Grid) -> None:
    """Once a run is over, record inputs given with a slope as they were at the end of each step, not the beginning."""
    for node in nodes:
        if node.block.slopes is None:
            continue
        section = node.block.inputs["Real"]
        sloped = set(node.block.slopes.references.tolist())
        for column, variable in enumerate(section.variables[: section.driven]):
            signal = system.inputs.get(f"{node.name}.{variable.name}")
            if signal is not None and variable.reference in sloped:
                section.values[1:, column] = signal.left_values(grid.signal_times[1:])


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


def _fill_signals(block: Block, description: Description, signals: Mapping[str, Signal], grid: Grid) -> Block:
    """Evaluate signals for the whole run: row k + 1 is what is set at time k and holds until time k + 1."""
    sloped: dict[int, FloatArray] = {}
    for name, signal in signals.items():
        variable = description.by_name[name]
        section = block.inputs[base_type(variable)]
        at_starts = signal.values(grid.signal_times)
        column = section.column(name)
        section.values[0, column] = at_starts[0]
        section.values[1:, column] = at_starts[:-1]
        slopes = signal.slopes(grid.signal_times)
        if description.can_interpolate_inputs and variable.type == "Real" and slopes.any():
            sloped[variable.reference] = slopes
    if not sloped:
        return block
    values = np.zeros((grid.times.size, len(sloped)))
    for column, slopes in enumerate(sloped.values()):
        values[1:, column] = slopes[:-1]
    references = np.array(list(sloped), dtype=np.uint32)
    return replace(block, slopes=Slopes(references, np.ones(len(sloped), dtype=np.int32), values))
