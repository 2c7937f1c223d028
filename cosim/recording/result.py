"""What a run leaves: every input and output of every component over time.

Trajectories as CSV text: numbers with as many digits as read back to the same bits, Booleans as 0 and 1.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError, suggestion
from cosim.system.signals import FloatArray


@dataclass(frozen=True)
class Result:
    """Trajectories on the communication points.

    Row k is what holds at the end of the step that leads to ``time[k]``: outputs there, and inputs in force until then.
    Row 0 is the state after initialisation.

    Attributes
    ----------
    time : ndarray of float, shape (n,)
        Communication points, s.
    columns : mapping of str to ndarray, shape (n,)
        By ``component.variable``: float64, int32, or bool.
    units : mapping of str to str
        Unit of each column, empty where there is none.
    record : mapping
        How the run was made: scenario, packaging, algorithm, step size, files and their hashes, timings, remarks.
    """

    time: FloatArray
    columns: Mapping[str, NDArray[Any]]
    units: Mapping[str, str]
    record: Mapping[str, Any] = field(default_factory=dict[str, Any])

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns, component by component."""
        return tuple(self.columns)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return one trajectory, or ``time``, shape (n,).

        Raises
        ------
        InputError
            If nothing of that name was recorded.
        """
        if name == "time":
            return self.time
        if name not in self.columns:
            raise InputError(f"'{name}' was not recorded{suggestion(name, self.columns)}")
        return self.columns[name]

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def to_csv(self, path: str | Path) -> None:
        """Write all trajectories: first column ``time``, then ``component.variable``.

        Numbers are written with as many digits as read back to the same bits, Booleans as 0 and 1.
        """
        with Path(path).open("w", encoding="utf-8", newline="\n") as file:
            file.write(header(self.columns))
            file.writelines(lines(self.time, *self.columns.values()))


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
