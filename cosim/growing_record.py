"""A recording that grows: rows of the stage, copied as steps are kept, for runs whose length is not known before."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cosim.record import Trace
from cosim.stage import Part

_FIRST_ROWS = 1024


class GrowingRecord:
    """Rows of the stage, in the order in which they were kept.

    Parameters
    ----------
    parts : mapping of str to Part
        All components, by name.
    notes : mapping of str to dtype
        What else to record of each step: numbers without a unit.
    """

    def __init__(self, parts: Mapping[str, Part], notes: Mapping[str, Any]) -> None:
        self._blocks = {name: part.block for name, part in parts.items()}
        self._sources = [values for block in self._blocks.values() for values in block.arrays()]
        self._copies = [np.zeros((_FIRST_ROWS, values.shape[1]), dtype=values.dtype) for values in self._sources]
        self._times = np.zeros(_FIRST_ROWS)
        self._notes = {name: np.zeros(_FIRST_ROWS, dtype=dtype) for name, dtype in notes.items()}
        self._rows = 0

    def append(self, row: int, time: float, **notes: float) -> None:
        """Record a row of the stage at a time [s], with what is known of the step that led to it."""
        if self._rows == self._times.size:
            self._grow()
        for copy, values in zip(self._copies, self._sources, strict=True):
            copy[self._rows] = values[row]
        self._times[self._rows] = time
        for name, values in self._notes.items():
            values[self._rows] = notes.get(name, 0)
        self._rows += 1

    def trace(self) -> Trace:
        """Return what has been recorded."""
        copies = iter(self._copies)
        blocks = {
            name: block.with_arrays(next(copies)[: self._rows] for _ in block.arrays())
            for name, block in self._blocks.items()
        }
        notes = {name: (values[: self._rows], "1") for name, values in self._notes.items()}
        return Trace(self._times[: self._rows], blocks, notes)

    def _grow(self) -> None:
        """Make room for as many rows again."""
        self._copies = [np.concatenate([copy, np.zeros_like(copy)]) for copy in self._copies]
        self._times = np.concatenate([self._times, np.zeros_like(self._times)])
        self._notes = {name: np.concatenate([values, np.zeros_like(values)]) for name, values in self._notes.items()}
