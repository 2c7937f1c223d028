"""A run, as the master sees it between setting up the components and terminating them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from cosim.initialisation import Settling
from cosim.record import Block, Trace

Progress = Callable[[float], None]
"""Told now and then which part of the run is done, from 0 to 1."""

REPORTS = 200
"""How often progress is told."""


class Run(Protocol):
    """What takes the steps and keeps the recording."""

    @property
    def order(self) -> tuple[str, ...]:
        """Names of the components in stepping order."""
        ...

    @property
    def blocks(self) -> Mapping[str, Block]:
        """Where the values of the components are exchanged, by name."""
        ...

    def initialise(self) -> Settling:
        """Initialise all components."""
        ...

    def advance(self, progress: Progress | None) -> None:
        """Take all steps."""
        ...

    def trace(self) -> Trace:
        """Return what has been recorded."""
        ...

    def record(self) -> dict[str, Any]:
        """Return what is to be told of the steps."""
        ...
