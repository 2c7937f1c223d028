"""Lay out the memory of a run once, so that FMUs write their outputs straight into it.

A run is recorded a window at a time, in the same memory: what is to be kept of a window is copied from it.

Each component has a block; a block has a section for each base type of its inputs and of its outputs; a section is an
array with one row for each communication point. Row k holds what is true at the end of the step that leads to it: the
outputs then, and the inputs in force then. Row 0 holds the values after initialisation.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from cosim.errors import RunError
from cosim.system.description import Description, Variable
from cosim.system.signals import FloatArray, Value

BaseType = Literal["Real", "Integer", "Boolean", "String"]
BASE_TYPES: tuple[BaseType, ...] = ("Real", "Integer", "Boolean", "String")
TEXT = np.dtype(object)
"""The type of an array of strings, each of its own length."""
DTYPES: Mapping[BaseType, np.dtype[Any]] = {
    "Real": np.dtype(np.float64),
    "Integer": np.dtype(np.int32),
    "Boolean": np.dtype(np.int32),
    "String": TEXT,
}


@dataclass(frozen=True)
class Section:
    """The variables of one base type and their values.

    Attributes
    ----------
    variables : tuple of Variable
        One for each column.
    references : ndarray of uint32, shape (columns,)
        Their value references.
    values : ndarray, shape (rows, columns)
        float64 or int32, as the FMI setters and getters take them, contiguous; of strings, Python's own.
    driven : int
        How many columns, the first ones, are set before each step. Outputs have none.
    """

    variables: tuple[Variable, ...]
    references: NDArray[np.uint32]
    values: NDArray[np.generic]
    driven: int

    def column(self, name: str) -> int:
        """Return the index of a variable's column."""
        return next(index for index, variable in enumerate(self.variables) if variable.name == name)


@dataclass(frozen=True)
class Slopes:
    """First derivatives of inputs or outputs; `values` is [unit/s], of shape (rows, variables)."""

    references: NDArray[np.uint32]
    orders: NDArray[np.int32]
    values: FloatArray

    def column(self, reference: int) -> int | None:
        """Return the index of the column of a value reference, if it has one."""
        found = np.flatnonzero(self.references == reference)
        return int(found[0]) if found.size else None


@dataclass(frozen=True)
class Block:
    """One component's share of the recording.

    Attributes
    ----------
    inputs, outputs : mapping of str to Section
        By base type.
    slopes : Slopes, optional
        Derivatives of inputs, passed before each step.
    output_slopes : Slopes, optional
        Derivatives of outputs, read after each step.
    """

    inputs: Mapping[BaseType, Section]
    outputs: Mapping[BaseType, Section]
    slopes: Slopes | None = None
    output_slopes: Slopes | None = None

    def arrays(self) -> list[NDArray[Any]]:
        """Return all its memory, in a fixed order."""
        slopes = [part for part in (self.slopes, self.output_slopes) if part is not None]
        sections = [sections[kind] for sections in (self.inputs, self.outputs) for kind in BASE_TYPES]
        return [part.values for part in (*sections, *slopes)]

    def rows(self, count: int) -> Block:
        """Return the same block with its first rows only."""
        return self.with_arrays(values[:count] for values in self.arrays())

    def roll(self, row: int) -> None:
        """Let the next window, or step, begin where this one ended."""
        for values in self.arrays():
            values[0] = values[row]

    def with_arrays(self, arrays: Iterable[NDArray[Any]]) -> Block:
        """Return the same block with other memory, in the order of `arrays`."""
        ahead = iter(arrays)
        inputs: dict[BaseType, Section] = {kind: replace(self.inputs[kind], values=next(ahead)) for kind in BASE_TYPES}
        outputs: dict[BaseType, Section] = {
            kind: replace(self.outputs[kind], values=next(ahead)) for kind in BASE_TYPES
        }
        slopes = self.slopes and replace(self.slopes, values=next(ahead))
        return Block(inputs, outputs, slopes, self.output_slopes and replace(self.output_slopes, values=next(ahead)))


@dataclass(frozen=True)
class Window:
    """Successive communication points of a run; valid until the run goes on.

    Attributes
    ----------
    first : int
        Number of the first row within the run. But for row 0, it is the last row of the window before.
    times : ndarray, shape (rows,)
        Communication points, s.
    blocks : mapping of str to Block
        By component, with one row each.
    notes : mapping of str to ndarray, shape (rows,)
        Numbers without a unit about the steps that led to the rows.
    """

    first: int
    times: FloatArray
    blocks: Mapping[str, Block]
    notes: Mapping[str, NDArray[Any]]


_NOTHING: Mapping[BaseType, Value] = {"Real": 0.0, "Integer": 0, "Boolean": False, "String": ""}
"""Values of variables for which nobody has said any."""


def base_type(variable: Variable) -> BaseType:
    """Return the type by which FMI sets and gets a variable."""
    return "Integer" if variable.type == "Enumeration" else variable.type


def allocate_block(
    description: Description, driven: Sequence[str], start_values: Mapping[Variable, Value], rows: int
) -> Block:
    """Lay out the recording of one component, with the start values of its inputs.

    An input that nothing drives has its start value in every row; one that is driven, in row 0, until its source is
    known. Tunable parameters that are driven count among the inputs.

    Parameters
    ----------
    description : Description
        Of the component's FMU.
    driven : sequence of str
        Names of the inputs that connections or signals drive, and of the parameters that signals do.
    start_values : mapping of Variable to value
        What is set before initialisation.
    rows : int
        Number of communication points.

    Raises
    ------
    RunError
        If there is not enough memory.
    """
    tuned = [variable for variable in description.variables if variable.tunable and variable.name in driven]
    given = (*description.with_causality("input"), *tuned)
    inputs = sorted(given, key=lambda variable: variable.name not in driven)
    outputs = description.with_causality("output")
    try:
        block = Block(
            {kind: _allocate(inputs, kind, driven, rows) for kind in BASE_TYPES},
            {kind: _allocate(outputs, kind, (), rows) for kind in BASE_TYPES},
        )
    except (MemoryError, ValueError) as error:
        raise RunError(f"not enough memory to record {rows} communication points: {error}") from error
    for section in block.inputs.values():
        for index, variable in enumerate(section.variables):
            rows_given = slice(0, 1) if index < section.driven else slice(None)
            section.values[rows_given, index] = initial_value(variable, start_values)
    return block


def allocate_slopes(references: Sequence[int], rows: int) -> Slopes | None:
    """Lay out first derivatives, all zero, of the variables with these value references; nothing if there are none."""
    if not references:
        return None
    count = len(references)
    return Slopes(np.array(references, dtype=np.uint32), np.ones(count, dtype=np.int32), np.zeros((rows, count)))


def _allocate(variables: Sequence[Variable], kind: BaseType, driven: Sequence[str], rows: int) -> Section:
    """Lay out one section."""
    chosen = tuple(variable for variable in variables if base_type(variable) == kind)
    return Section(
        variables=chosen,
        references=np.array([variable.reference for variable in chosen], dtype=np.uint32),
        values=np.full((rows, len(chosen)), "" if kind == "String" else 0, dtype=DTYPES[kind]),
        driven=sum(variable.name in driven for variable in chosen),
    )


def initial_value(variable: Variable, start_values: Mapping[Variable, Value]) -> Value:
    """Return the value that a variable has when nothing has driven it yet."""
    given = start_values.get(variable, variable.start_value)
    return _NOTHING[base_type(variable)] if given is None else given
