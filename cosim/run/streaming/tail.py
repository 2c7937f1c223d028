"""The end of a run in memory: its last minute of a few columns, from which a long run is measured and drawn."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.recording.result import Result
from cosim.recording.row_memory import RowMemory
from cosim.recording.rows import Column, Rows

SECONDS = 60.0
"""How much is kept at least, s; measures look at the last 20 s, or at a period if that is longer."""
_TIMES = "time"


class Tail:
    """Takes rows, and forgets those that are older than a minute.

    Parameters
    ----------
    columns : sequence of Column
        What to keep of them.
    """

    def __init__(self, columns: Sequence[Column]) -> None:
        self._columns = tuple(columns)
        self._parts: deque[Rows] = deque()

    def take(self, rows: Rows) -> None:
        """Keep some more rows."""
        kept = {column.name: rows.columns[column.name].copy() for column in self._columns}
        self._parts.append(Rows(rows.first, rows.times.copy(), kept))
        oldest = rows.times[-1] - SECONDS
        while len(self._parts) > 1 and self._parts[1].times[0] <= oldest:
            self._parts.popleft()

    def result(self, record: Mapping[str, Any]) -> Result:
        """Return what is kept, with what is to be told of the run."""
        memory = RowMemory(self._columns, sum(part.times.size for part in self._parts))
        for part in self._parts:
            memory.take(part)
        return memory.result(record)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return what is kept by name, for a checkpoint."""
        whole = self.result({})
        return {_name(_TIMES): whole.time, **{_name(name): values for name, values in whole.columns.items()}}

    def restore(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Keep what another kept."""
        times = np.asarray(arrays[_name(_TIMES)], dtype=np.float64)
        values = {column.name: arrays[_name(column.name)] for column in self._columns}
        self._parts = deque([Rows(0, times, values)])


def _name(column: str) -> str:
    """Return the name of a column in a checkpoint."""
    return f"tail {column}"
