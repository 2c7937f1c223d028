"""States of an FMU instance that a master may return to, kept by number."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import byref, c_void_p
from typing import Any, Protocol

_GET, _SET, _FREE = "fmi2GetFMUstate", "fmi2SetFMUstate", "fmi2FreeFMUstate"


class Bind(Protocol):
    """Finds a function of the library by its name and the types of its arguments."""

    def __call__(self, name: str, argument_types: tuple[Any, ...]) -> Callable[..., int]:
        """Return the function."""
        ...


class KeptStates:
    """What fmi2GetFMUstate returned.

    Parameters
    ----------
    instance : c_void_p
        The instance.
    bind : callable
        Finds the functions.
    judge : callable
        Takes the name of a function and a status other than fmi2OK, and raises unless it is a warning.
    """

    def __init__(self, instance: c_void_p, bind: Bind, judge: Callable[[str, int], None]) -> None:
        self._instance = instance
        self._judge = judge
        self._get, self._set, self._free = (bind(name, (c_void_p, c_void_p)) for name in (_GET, _SET, _FREE))
        self._states: dict[int, c_void_p] = {}

    def save(self, slot: int) -> None:
        """Keep the present state; one kept there before is freed first, as not every FMU overwrites it."""
        state = self._states.get(slot)
        if state is not None:
            self._free(self._instance, byref(state))
        state = self._states[slot] = c_void_p()
        if status := self._get(self._instance, byref(state)):
            self._judge(_GET, status)

    def restore(self, slot: int) -> None:
        """Return to a state."""
        if status := self._set(self._instance, self._states[slot]):
            self._judge(_SET, status)

    def free(self) -> None:
        """Free them all; nothing can be done about a failure any more."""
        for state in self._states.values():
            self._free(self._instance, byref(state))
        self._states.clear()
