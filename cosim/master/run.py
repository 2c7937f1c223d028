"""Begin, record and resume a run, between setting up the components and terminating them.

In initialization mode, components exchange values until nothing changes, so that the values at the start are
consistent. Steps that are taken on a stage are recorded by copying rows of the stage, as steps are kept, a window at a
time.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cosim.master.wiring import Node
from cosim.recording.record import Block, Window
from cosim.system.signals import FloatArray

Progress = Callable[[float], None]
"""Told now and then which part of the run is done, from 0 to 1."""

_USUAL_WINDOWS, _LEAST_STEPS = 100, 32
MOST_STEPS = 4096
"""In a window."""


def window_size(steps: int) -> int:
    """Return how many of the steps of a run make a window: so few that there is little to wait for and to hold."""
    return min(MOST_STEPS, max(_LEAST_STEPS, steps // _USUAL_WINDOWS))


@dataclass(frozen=True)
class Snapshot:
    """Hold what it takes to go on from between two windows; kept in a file, it is a checkpoint.

    Attributes
    ----------
    notes : mapping
        What JSON can hold.
    arrays : mapping of str to ndarray
        By name; states of FMUs are of uint8.
    """

    notes: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict[str, NDArray[Any]])


class Run(Protocol):
    """Take the steps and record them."""

    @property
    def order(self) -> tuple[str, ...]:
        """Names of the components in stepping order."""
        ...

    @property
    def blocks(self) -> Mapping[str, Block]:
        """Return the blocks in which the values of the components are exchanged, by name."""
        ...

    @property
    def notes(self) -> Mapping[str, np.dtype[Any]]:
        """Names and types of what is recorded about each step, all numbers without a unit."""
        ...

    def initialise(self) -> Settling:
        """Initialise all components."""
        ...

    def windows(self) -> Iterator[Window]:
        """Take all steps, and give each window when it is complete; at least one."""
        ...

    @property
    def done(self) -> float:
        """Return the part of the steps that has been taken, from 0 to 1."""
        ...

    def snapshot(self) -> Snapshot:
        """Return what it takes to go on from between two windows."""
        ...

    def restore(self, snapshot: Snapshot) -> None:
        """Once initialised, be as a run of the same kind was when it gave a snapshot."""
        ...

    def record(self) -> dict[str, Any]:
        """Return what is to be told of the steps."""
        ...


def block_arrays(blocks: Mapping[str, Block]) -> dict[str, NDArray[Any]]:
    """Name all memory of blocks, for a snapshot."""
    return {
        f"block {component} {number}": values
        for component, block in blocks.items()
        for number, values in enumerate(block.arrays())
    }


def refill(values: NDArray[Any], saved: NDArray[Any]) -> None:
    """Put saved values back into memory; ValueError if they are not from memory like it."""
    kind = "U" if values.dtype == object else values.dtype.kind
    if saved.shape != values.shape or saved.dtype.kind != kind:
        raise ValueError(
            f"values of shape {saved.shape} and type {saved.dtype}; expected {values.shape}, {values.dtype}"
        )
    values[...] = saved


log = logging.getLogger("cosim")

# Feedthrough with a loop gain of 0.99 still settles within this many rounds.
MAXIMUM_ROUNDS = 5000
# Rounding may keep the last bits of a settled loop moving.
_ROUNDING = 1e-13


@dataclass(frozen=True)
class Settling:
    """Tell how the exchange ended: whether it settled, after how many rounds, and the input that changed last."""

    settled: bool
    rounds: int
    moving: str = ""


def initialise(nodes: Sequence[Node], settle: Callable[[], Settling] | None = None) -> Settling:
    """Initialise all components and leave row 0 consistent.

    Parameters
    ----------
    nodes : sequence of Node
        All components.
    settle : callable, optional
        Exchanges values in initialization mode; by default `exchange`.

    Raises
    ------
    SlaveError
        If a component refuses a value or a call.
    """
    for node in nodes:
        node.slave.enter_initialization()
    settling = settle() if settle is not None else exchange(nodes)
    for node in nodes:
        node.slave.exit_initialization()
    for node in nodes:
        node.slave.read(0)
    return settling


def exchange(nodes: Sequence[Node], maximum_rounds: int = MAXIMUM_ROUNDS) -> Settling:
    """Exchange values until no input changes.

    In each round every component, in order, is given the newest outputs of the others and asked for its own. A loop
    through direct feedthrough that does not settle, for instance because it has no solution, is logged as a warning,
    and the values of the last round remain.

    Raises
    ------
    SlaveError
        If a component refuses a value.
    """
    settling = _exchange(nodes, maximum_rounds)
    if not settling.settled:
        log.warning(
            "values at the start do not settle: %s still changes after %d rounds; going on with the last ones",
            settling.moving,
            settling.rounds,
        )
    return settling


@np.errstate(invalid="ignore")
def _exchange(nodes: Sequence[Node], maximum_rounds: int) -> Settling:
    """Exchange values until no input changes, or give up."""
    for node in nodes:
        node.slave.write(0)
        node.slave.read(0)
    fed = [node for node in nodes if node.channels]
    moving = ""
    for rounds in range(1, maximum_rounds + 1):
        moving, rounding_only = "", True
        for node in fed:
            before, texts = _inputs(node), _texts(node)
            node.gather_initial()
            after = _inputs(node)
            changed = [place for place, pair in enumerate(zip(texts, _texts(node), strict=True)) if pair[0] != pair[1]]
            if before.tobytes() == after.tobytes() and not changed:
                continue
            place = after.size + changed[0] if changed else int(np.argmax(np.abs(after - before)))
            moving = _name(node, place) or moving
            rounding_only = rounding_only and not changed and _only_rounding(before, after)
            node.slave.write(0)
            node.slave.read(0)
        if not moving:
            return Settling(True, rounds)
        if rounding_only and rounds > 100:
            return Settling(True, rounds)
    return Settling(False, maximum_rounds, moving)


def _inputs(node: Node) -> FloatArray:
    """Return row 0 of the driven inputs, all types but strings together."""
    sections = [section for kind, section in node.block.inputs.items() if kind != "String"]
    return np.concatenate([section.values[0, : section.driven].astype(np.float64) for section in sections])


def _texts(node: Node) -> list[str]:
    """Return row 0 of the driven inputs that are strings."""
    section = node.block.inputs["String"]
    return section.values[0, : section.driven].tolist()


def _only_rounding(before: FloatArray, after: FloatArray) -> bool:
    """Compare up to rounding; what has grown beyond all numbers has not settled."""
    near = np.abs(after - before) <= _ROUNDING * np.maximum(np.abs(after), np.abs(before))
    return bool((near & np.isfinite(after)).all())


def _name(node: Node, index: int) -> str:
    """Name a driven input by its place in `_inputs`, after which come those of `_texts`."""
    names = [v.name for section in node.block.inputs.values() for v in section.variables[: section.driven]]
    return f"{node.name}.{names[index]}"


class WindowRecord:
    """Rows of the stage, in the order in which they were kept.

    Parameters
    ----------
    blocks : mapping of str to Block
        Those of all components, by name.
    notes : mapping of str to dtype
        What else to record of each step: numbers without a unit.
    rows : int
        For how many there is room, besides the one before them.
    """

    def __init__(self, blocks: Mapping[str, Block], notes: Mapping[str, np.dtype[Any]], rows: int) -> None:
        self._blocks = blocks
        self._sources = [values for block in self._blocks.values() for values in block.arrays()]
        self._copies = [np.zeros((rows + 1, values.shape[1]), dtype=values.dtype) for values in self._sources]
        self._times = np.zeros(rows + 1)
        self._notes = {name: np.zeros(rows + 1, dtype=dtype) for name, dtype in notes.items()}
        self._first = self._filled = 0

    @property
    def room(self) -> int:
        """For how many more rows there is room."""
        return self._times.size - self._filled

    def begin(self, number: int, row: int, time: float) -> None:
        """Begin a window with a row of the stage at a time [s], whose number within the run is `number`."""
        self._first, self._filled = number, 0
        self.append(row, time)

    def append(self, row: int, time: float, **notes: float) -> None:
        """Record a row of the stage at a time [s], with what is known of the step that led to it."""
        for copy, values in zip(self._copies, self._sources, strict=True):
            copy[self._filled] = values[row]
        self._times[self._filled] = time
        for name, values in self._notes.items():
            values[self._filled] = notes.get(name, 0)
        self._filled += 1

    def window(self) -> Window:
        """Return what has been recorded since the window was begun."""
        copies = iter(self._copies)
        blocks = {
            name: block.with_arrays(next(copies)[: self._filled] for _ in block.arrays())
            for name, block in self._blocks.items()
        }
        notes = {name: values[: self._filled] for name, values in self._notes.items()}
        return Window(self._first, self._times[: self._filled], blocks, notes)
