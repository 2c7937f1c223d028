"""What is to be said of a run when it is over, in sentences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def statement(record: Mapping[str, Any]) -> tuple[str, ...]:
    """Say how the coupling was computed, from the record of a run."""
    return tuple(
        f"algebraic loop {loop}: {record['algorithm']} passes on values of the step before" for loop in record["loops"]
    )
