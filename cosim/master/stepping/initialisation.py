"""Consistent values at the start: in initialization mode, components exchange values until nothing changes."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cosim.recording.record import Block
from cosim.recording.slave import Slave
from cosim.system.signals import FloatArray

log = logging.getLogger("cosim")

# Feedthrough with a loop gain of 0.99 still settles within this many rounds.
MAXIMUM_ROUNDS = 5000
# Rounding may keep the last bits of a settled loop moving.
_ROUNDING = 1e-13


@dataclass(frozen=True)
class Settling:
    """How the exchange ended: whether it settled, after how many rounds, and the input that changed last."""

    settled: bool
    rounds: int
    moving: str = ""


class Exchanging(Protocol):
    """A component as far as its initialisation goes."""

    @property
    def name(self) -> str:
        """Of the component."""
        ...

    @property
    def slave(self) -> Slave:
        """What is initialised."""
        ...

    @property
    def block(self) -> Block:
        """Where its values are."""
        ...

    def gather_initial(self) -> None:
        """Copy the values that connections bring within row 0."""
        ...


def initialise(nodes: Sequence[Exchanging], settle: Callable[[], Settling] | None = None) -> Settling:
    """Initialise all components and leave row 0 consistent.

    Parameters
    ----------
    nodes : sequence of Exchanging
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


def exchange(nodes: Sequence[Exchanging], maximum_rounds: int = MAXIMUM_ROUNDS) -> Settling:
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
def _exchange(nodes: Sequence[Exchanging], maximum_rounds: int) -> Settling:
    """Exchange values until no input changes, or give up."""
    for node in nodes:
        node.slave.write(0)
        node.slave.read(0)
    moving = ""
    for rounds in range(1, maximum_rounds + 1):
        moving, rounding_only = "", True
        for node in nodes:
            before = _inputs(node)
            node.gather_initial()
            after = _inputs(node)
            if before.tobytes() == after.tobytes():
                continue
            moving = _name(node, int(np.argmax(np.abs(after - before)))) or moving
            rounding_only = rounding_only and _only_rounding(before, after)
            node.slave.write(0)
            node.slave.read(0)
        if not moving:
            return Settling(True, rounds)
        if rounding_only and rounds > 100:
            return Settling(True, rounds)
    return Settling(False, maximum_rounds, moving)


def _inputs(node: Exchanging) -> FloatArray:
    """Return row 0 of the driven inputs, all types together."""
    rows = [section.values[0, : section.driven].astype(np.float64) for section in node.block.inputs.values()]
    return np.concatenate(rows)


def _only_rounding(before: FloatArray, after: FloatArray) -> bool:
    """Compare up to rounding; what has grown beyond all numbers has not settled."""
    near = np.abs(after - before) <= _ROUNDING * np.maximum(np.abs(after), np.abs(before))
    return bool((near & np.isfinite(after)).all())


def _name(node: Exchanging, index: int) -> str:
    """Name a driven input by its place in `_inputs`."""
    names = [v.name for section in node.block.inputs.values() for v in section.variables[: section.driven]]
    return f"{node.name}.{names[index]}"
