"""What a run leaves: every input and output of every component over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError, suggestion
from cosim.record import BASE_TYPES, Trace
from cosim.signals import FloatArray
from cosim.system import COUPLING


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
            file.write(",".join(["time", *self.columns]) + "\n")
            file.writelines(",".join(row) + "\n" for row in self._rows())

    def _rows(self) -> Iterator[tuple[str, ...]]:
        """Write each row's numbers; `repr` of a float is the shortest text that reads back the same."""
        numbers = (
            column.astype(np.int32).tolist() if column.dtype == np.bool_ else column.tolist()
            for column in (self.time, *self.columns.values())
        )
        return zip(*(map(repr, column) for column in numbers), strict=True)


def collect(
    names: Sequence[str], trace: Trace, observables: Mapping[str, tuple[NDArray[Any], str]], record: Mapping[str, Any]
) -> Result:
    """Name the columns of a recording; they can be read but not changed.

    Parameters
    ----------
    names : sequence of str
        Components, in the order of the columns.
    trace : Trace
        What has been recorded.
    observables : mapping of str to tuple of ndarray and str
        Columns about the coupling, with their units.
    record : mapping
        How the run was made.
    """
    columns: dict[str, NDArray[Any]] = {}
    units: dict[str, str] = {}
    for name in names:
        block = trace.blocks[name]
        for sections in (block.outputs, block.inputs):
            for kind in BASE_TYPES:
                section = sections[kind]
                for index, variable in enumerate(section.variables):
                    values: NDArray[Any] = np.ascontiguousarray(section.values[:, index])
                    columns[f"{name}.{variable.name}"] = values != 0 if kind == "Boolean" else values
                    units[f"{name}.{variable.name}"] = variable.unit.name if variable.unit else ""
    for name, (values, unit) in observables.items():
        columns[f"{COUPLING}.{name}"] = values
        units[f"{COUPLING}.{name}"] = unit
    for values in columns.values():
        values.flags.writeable = False
    return Result(trace.times, MappingProxyType(columns), MappingProxyType(units), MappingProxyType(dict(record)))
