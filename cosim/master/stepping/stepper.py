"""What the master asks of an algorithm that takes steps on a stage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from numpy.typing import NDArray

from cosim.errors import LoopError
from cosim.master.stepping.channel import Span
from cosim.master.stepping.initialisation import Settling


@dataclass(frozen=True)
class Taken:
    """A step that was taken.

    Attributes
    ----------
    sweeps : int
        How often components were stepped at most.
    unsolved : LoopError, optional
        A loop that was not closed, where the run is to go on all the same.
    """

    sweeps: int
    unsolved: LoopError | None = None


class Stepper(Protocol):
    """Takes all components from one row of the stage to another."""

    def initialise(self, time: float) -> Settling:
        """Initialise all components at a time [s], and leave row 0 consistent."""
        ...

    def step(self, begin: int, end: int, span: Span, slot: int) -> Taken:
        """Step every component but those that `finish` steps.

        Parameters
        ----------
        begin, end : int
            Rows of the stage.
        span : Span
            The time of the step.
        slot : int
            Where the states at its beginning are kept, if the algorithm needs them.

        Raises
        ------
        LoopError
            If a loop has no solution.
        SlaveError
            If a component refuses the step.
        """
        ...

    def finish(self, begin: int, end: int, span: Span) -> None:
        """Step the components that could not be taken back, once the step is kept; nothing depends on them."""
        ...

    def learned(self) -> dict[str, NDArray[Any]]:
        """Return by name what was learned from steps for those that follow."""
        ...

    def learn(self, learned: Mapping[str, NDArray[Any]]) -> None:
        """Know what another of its kind has learned; names of other things may be among them."""
        ...
