"""A run, as the master sees it between setting up the components and terminating them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cosim.master.stepping.initialisation import Settling
from cosim.recording.record import Block, Window

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
    """What it takes to go on from between two windows, but for the states of the components.

    Attributes
    ----------
    notes : mapping
        What JSON can hold.
    arrays : mapping of str to ndarray
        By name.
    """

    notes: Mapping[str, Any]
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict[str, NDArray[Any]])


class Run(Protocol):
    """What takes the steps and records them."""

    @property
    def order(self) -> tuple[str, ...]:
        """Names of the components in stepping order."""
        ...

    @property
    def blocks(self) -> Mapping[str, Block]:
        """Where the values of the components are exchanged, by name."""
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
        """Which part of the steps has been taken, from 0 to 1."""
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
