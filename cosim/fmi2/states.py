"""States of an FMU instance that a master may return to, kept by number."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import byref, c_char, c_size_t, c_void_p
from typing import Any, Protocol

_GET, _SET, _FREE = "fmi2GetFMUstate", "fmi2SetFMUstate", "fmi2FreeFMUstate"
_SIZE, _WRITE, _READ = "fmi2SerializedFMUstateSize", "fmi2SerializeFMUstate", "fmi2DeSerializeFMUstate"


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
        self._bind, self._judge = bind, judge
        self._get, self._set, self._free = (bind(name, (c_void_p, c_void_p)) for name in (_GET, _SET, _FREE))
        self._states: dict[int, c_void_p] = {}

    def save(self, slot: int) -> None:
        """Keep the present state; one kept there before is freed first, as not every FMU overwrites it."""
        self._release(slot)
        state = self._states[slot] = c_void_p()
        if status := self._get(self._instance, byref(state)):
            self._judge(_GET, status)

    def restore(self, slot: int) -> None:
        """Return to a state."""
        if status := self._set(self._instance, self._states[slot]):
            self._judge(_SET, status)

    def to_bytes(self, slot: int) -> bytes:
        """Write a state as bytes (FMI 2.0, section 2.1.8)."""
        state, size = self._states[slot], c_size_t()
        ask = self._bind(_SIZE, (c_void_p, c_void_p, c_void_p))
        if status := ask(self._instance, state, byref(size)):
            self._judge(_SIZE, status)
        content = (c_char * size.value)()
        write = self._bind(_WRITE, (c_void_p, c_void_p, c_void_p, c_size_t))
        if status := write(self._instance, state, content, size):
            self._judge(_WRITE, status)
        return bytes(content)

    def from_bytes(self, slot: int, content: bytes) -> None:
        """Keep a state that was written as bytes, by this instance or another of the same FMU."""
        self._release(slot)
        state, buffer = c_void_p(), (c_char * len(content)).from_buffer_copy(content)
        read = self._bind(_READ, (c_void_p, c_void_p, c_size_t, c_void_p))
        if status := read(self._instance, buffer, c_size_t(len(content)), byref(state)):
            self._judge(_READ, status)
        self._states[slot] = state

    def free(self) -> None:
        """Free them all; nothing can be done about a failure any more."""
        for state in self._states.values():
            self._free(self._instance, byref(state))
        self._states.clear()

    def _release(self, slot: int) -> None:
        state = self._states.pop(slot, None)
        if state is not None:
            self._free(self._instance, byref(state))
