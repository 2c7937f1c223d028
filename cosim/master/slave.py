"""State what the master asks of a component in a run.

`cosim.fmi2.fmu_slave.FmuSlave` answers for an FMU. Anything else with these methods can take part as well, which is how
the master is tested.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from cosim.recording.record import Block
from cosim.system.description import Description, Variable
from cosim.system.signals import Value


class Slave(Protocol):
    """A component as the master sees it; every method raises `cosim.errors.SlaveError` when it fails."""

    @property
    def description(self) -> Description:
        """Variables and capabilities."""
        ...

    def setup(self, block: Block, start_values: Mapping[Variable, Value], start_time: float, stop_time: float) -> None:
        """Remember where values are exchanged, and set what must be set before initialisation; times in s."""
        ...

    def enter_initialization(self) -> None:
        """Begin to exchange values at the start time."""
        ...

    def exit_initialization(self) -> None:
        """Be ready to step."""
        ...

    def write(self, row: int) -> None:
        """Take the driven inputs from a row of the block, and from row 1 on their slopes."""
        ...

    def step(self, time: float, size: float) -> None:
        """Compute from the communication point `time` [s] to `time` + `size`."""
        ...

    def read(self, row: int) -> None:
        """Put the outputs into a row of the block and, once initialised, their derivatives where there is room."""
        ...

    def save(self, slot: int) -> None:
        """Keep the present state under a number, in place of what was kept there.

        Only a slave whose description says `can_save_state` is asked for it.
        """
        ...

    def restore(self, slot: int) -> None:
        """Return to the state that was kept under a number; inputs and their slopes are then to be written again."""
        ...

    def serialise(self) -> bytes:
        """Return the present state as bytes, for another process to go on from.

        Only a slave whose description says `can_serialize_state` is asked for it.
        """
        ...

    def deserialise(self, content: bytes, time: float) -> None:
        """Once initialised, go on from a state at the communication point `time` [s] that was written as bytes."""
        ...

    def terminate(self) -> None:
        """End the run."""
        ...
