"""Do what the slaves of laws have in common: answer, and keep what they remember."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

from .slave import TableSlave


class MemorylessLaw(TableSlave):
    """A law whose outputs at an instant follow from its inputs and parameters at that instant."""

    @abstractmethod
    def answer(self, values: list[Any], time: float) -> None:
        """Write the outputs that go with the inputs and parameters, and log what has changed at a time [s]."""

    def start(self, values: list[Any], time: float) -> None:
        """Answer the inputs as they are."""
        self.answer(values, time)

    def step(self, values: list[Any], time: float, end: float) -> None:
        """Answer the inputs as they are."""
        self.answer(values, end)

    def state(self) -> object:
        """Return None: the law has no memory."""
        return None

    def restore(self, state: Any) -> None:
        """Take nothing over."""


LONGEST_STEP = 1e6
"""Of laws that add up [s]."""


def require_short(elapsed: float) -> None:
    """Refuse a step so long that what is added up in it leaves the range of numbers."""
    if elapsed > LONGEST_STEP:
        raise ValueError(f"a step of {elapsed!r} s cannot be followed; expected at most 1e+06 s")


class Law(TableSlave):
    """A law with a memory, an array of numbers: filters, integrators, what it has seen. native/ds_law.h follows it.

    Attributes
    ----------
    memory : tuple of float
        What the law remembers, in the order of its C model.
    """

    memory: tuple[float, ...]

    @abstractmethod
    def begin(self, values: list[Any]) -> tuple[float, ...]:
        """Return the memory at the start from inputs and parameters."""

    @abstractmethod
    def advance(self, values: list[Any], elapsed: float) -> tuple[float, ...]:
        """Return the memory after `elapsed` seconds in which the inputs are held; ValueError refuses the step."""

    @abstractmethod
    def answer(self, memory: tuple[float, ...], values: list[Any]) -> None:
        """Write the outputs that go with memory, inputs and parameters."""

    def tell_changes(self, before: list[Any], values: list[Any], time: float) -> None:
        """Log what has changed in the outputs that the user should know; nothing if it is not overridden."""

    def start(self, values: list[Any], time: float) -> None:
        """Begin to remember, and answer."""
        self._respond(self.begin(values), values, time)

    def step(self, values: list[Any], time: float, end: float) -> None:
        """Advance the memory, and answer the inputs as they are."""
        self._respond(self.advance(values, end - time), values, end)

    def _respond(self, memory: tuple[float, ...], values: list[Any], time: float) -> None:
        before = values[:]
        self.answer(memory, values)
        self.memory = memory
        self.tell_changes(before, values, time)

    def state(self) -> object:
        """Return the memory."""
        return list(self.memory)

    def restore(self, state: Any) -> None:
        """Take a memory over."""
        self.memory = tuple(state)
