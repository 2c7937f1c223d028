"""Rows of a run by name: what a window of communication points recorded, as those who keep it take it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.system.signals import FloatArray


@dataclass(frozen=True)
class Column:
    """What one value of each row is.

    Attributes
    ----------
    name : str
        As ``component.variable``.
    unit : str
        Empty where there is none.
    dtype : dtype
        float64, int32 or bool.
    description : str
        For people; may be empty.
    """

    name: str
    unit: str
    dtype: np.dtype[Any]
    description: str = ""


@dataclass(frozen=True)
class Rows:
    """Successive rows; they are valid until the run goes on.

    Attributes
    ----------
    first : int
        Number of the first row within the run; the values after initialisation are row 0.
    times : ndarray, shape (rows,)
        Communication points, s.
    columns : mapping of str to ndarray, shape (rows,)
        By name of column.
    """

    first: int
    times: FloatArray
    columns: Mapping[str, NDArray[Any]]
