"""The recording of steps that are taken on a stage: rows of the stage, copied as steps are kept, a window at a time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cosim.master.stepping.stage import Part
from cosim.recording.record import Window


class WindowRecord:
    """Rows of the stage, in the order in which they were kept.

    Parameters
    ----------
    parts : mapping of str to Part
        All components, by name.
    notes : mapping of str to dtype
        What else to record of each step: numbers without a unit.
    rows : int
        For how many there is room, besides the one before them.
    """

    def __init__(self, parts: Mapping[str, Part], notes: Mapping[str, np.dtype[Any]], rows: int) -> None:
        self._blocks = {name: part.block for name, part in parts.items()}
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
