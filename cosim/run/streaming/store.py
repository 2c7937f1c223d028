"""What a run is streamed to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from cosim.recording.rows import Rows

Position = Mapping[str, int]
"""How far a store has got, by what it counts."""


class Store(Protocol):
    """Keeps rows on disk; raises `cosim.errors.OutputError` where it cannot."""

    def take(self, rows: Rows) -> None:
        """Take the rows that follow those taken before."""
        ...

    def commit(self) -> Position:
        """Bring everything taken so far to disk; a store opened at what is returned goes on from here."""
        ...

    def close(self, attributes: Mapping[str, Any]) -> None:
        """Bring everything to disk and note what is to be said of the run."""
        ...
