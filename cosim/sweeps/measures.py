"""Say what is kept of each point of a sweep: numbers taken from the end of its run.

The sweep knows nothing of what they mean. Whoever measures says which outputs it takes, over how many seconds at the
end of a run, and whether long steps will do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cosim.system.description import Description
from cosim.system.signals import FloatArray, Value


class Quantity(Protocol):
    """A number kept of each point: its name in the store, its unit, and what it is."""

    @property
    def name(self) -> str:
        """Name it in the store."""
        ...

    @property
    def unit(self) -> str:
        """Give its unit."""
        ...

    @property
    def text(self) -> str:
        """Say what it is."""
        ...


@dataclass(frozen=True)
class Output:
    """The value of an output as such a number."""

    name: str
    unit: str
    text: str


class MeasureSet(Protocol):
    """Take numbers from the end of a run; it goes to the workers, and so can be pickled."""

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Name what comes of it."""
        ...

    @property
    def columns(self) -> tuple[str, ...]:
        """Outputs it is taken from, as ``component.variable``."""
        ...

    @property
    def window(self) -> float:
        """Over how much of the end of a run it measures, s; 0 for the end alone."""
        ...

    @property
    def sampling(self) -> float | None:
        """Give the distance of communication points in the window that will do, s, where all inputs are constant.

        Until the window one long step is taken then. None: the scenario's own steps are needed.
        """
        ...

    @property
    def identity(self) -> str:
        """Tell it apart from others in the record of a sweep."""
        ...

    def of(self, time: FloatArray, columns: Mapping[str, FloatArray]) -> Sequence[float]:
        """Return the numbers, from communication points of the window [s] and the outputs there."""
        ...


class Beginning(Protocol):
    """Say how runs begin that are continued along an axis."""

    @property
    def identity(self) -> str:
        """Tell it apart from others in the record of a sweep."""
        ...

    def __call__(self, values: Mapping[str, Value]) -> Mapping[str, Value]:
        """Return what else is set for the first point of a line, whose values are given."""
        ...


@dataclass(frozen=True)
class FinalValues:
    """Keep the values of outputs at the end of the run.

    Parameters
    ----------
    quantities : tuple of Output
        By the names of their columns.
    """

    quantities: tuple[Output, ...]
    window: float = 0.0
    sampling: float | None = None
    identity: str = "final values"

    @property
    def columns(self) -> tuple[str, ...]:
        """Outputs it is taken from."""
        return tuple(each.name for each in self.quantities)

    def of(self, time: FloatArray, columns: Mapping[str, FloatArray]) -> Sequence[float]:
        """Return the last values."""
        del time
        return [float(columns[name][-1]) for name in self.columns]


def final_values(descriptions: Mapping[str, Description]) -> FinalValues:
    """Keep all outputs that are numbers, of all components."""
    return FinalValues(
        tuple(
            Output(f"{component}.{each.name}", each.unit.name if each.unit else "", each.description)
            for component, description in descriptions.items()
            for each in description.with_causality("output")
            if each.type != "String"
        )
    )


def last_window(time: FloatArray, seconds: float) -> slice:
    """Return the communication points [s] of so many seconds at the end, up to rounding; at least the last one."""
    first = int(np.searchsorted(time, float(time[-1]) - seconds * (1.0 + 1e-9)))
    return slice(min(first, time.size - 1), None)
