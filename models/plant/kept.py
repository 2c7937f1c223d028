"""The contents of a plant, kept while a step is tried, so that one that is refused leaves no trace."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from operator import attrgetter

from .delay_line import DelayLine


class Kept:
    """The contents of the attributes of a plant and its parts.

    They are numbers and tuples, which never change, but for the rings of the lines, which are copied.

    Parameters
    ----------
    plant : object
        Its attributes are put back as a whole.
    lines : iterable of DelayLine
        Its lines.
    parts : iterable of object
        What else it is made of and changes in time, with slots.
    """

    def __init__(self, plant: object, lines: Iterable[DelayLine], parts: Iterable[object]) -> None:
        self._plant = plant
        self._own = vars(plant).copy()
        self._rings = [(line, line.pieces.copy()) for line in lines]
        slotted = [*(line for line, _ in self._rings), *parts]
        self._parts = [(part, attrgetter(*_slots(type(part)))(part)) for part in slotted]

    def put_back(self) -> None:
        """Let the plant be as it was."""
        vars(self._plant).update(self._own)
        for part, contents in self._parts:
            for name, content in zip(_slots(type(part)), contents, strict=True):
                setattr(part, name, content)
        for line, pieces in self._rings:
            line.pieces = pieces


@cache
def _slots(kind: type) -> tuple[str, ...]:
    """Return the names of all slots of a class."""
    return tuple(name for each in kind.__mro__ for name in getattr(each, "__slots__", ()))
