"""Trajectories as CSV text: numbers with as many digits as read back to the same bits, Booleans as 0 and 1."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray


def header(names: Iterable[str]) -> str:
    """Write the first line: ``time``, then the names of the columns."""
    return ",".join(["time", *names]) + "\n"


def lines(times: NDArray[Any], *columns: NDArray[Any]) -> Iterator[str]:
    """Write a line for each row; `repr` of a float is the shortest text that reads back the same."""
    numbers = (
        column.astype(np.int32).tolist() if column.dtype == np.bool_ else column.tolist()
        for column in (times, *columns)
    )
    return (",".join(row) + "\n" for row in zip(*(map(repr, column) for column in numbers), strict=True))
