"""Drive what is not Real over time: a table of levels, each held until the next.

A whole number, a Boolean, a string and the item of an enumeration have nothing between them. Which of these a table is
of, only the variable knows that it drives; so a table becomes a staircase when a system is put together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from cosim.errors import ScenarioError, SystemDefinitionError
from cosim.system.signals import FloatArray, Level, Signal, Table, plain_value


@dataclass(frozen=True)
class Staircase(Signal):
    """Hold each level until the next; the first one before, too, and the last one for ever.

    Parameters
    ----------
    times : tuple of float
        Times from which the levels hold, s, not decreasing, none more than twice; of two at one time the later holds.
    points : tuple of float, int, bool or str
        The levels, as many.

    Raises
    ------
    ScenarioError
        If the times are not so.
    """

    kind: ClassVar[str] = "table"

    times: tuple[float, ...]
    points: tuple[Level, ...]
    _times: FloatArray = field(init=False, repr=False, compare=False)
    _points: NDArray[np.generic] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ("times", "points"):
            object.__setattr__(self, name, tuple(map(plain_value, getattr(self, name))))
        object.__setattr__(self, "_times", np.array(Table(self.times, (0.0,) * len(self.points)).times))
        object.__setattr__(self, "_points", np.array(self.points))

    @property
    def levels(self) -> tuple[Level, ...]:
        """The levels, each once, in the order in which they come."""
        return tuple({(type(level), level): level for level in self.points}.values())

    def with_levels(self, read: Callable[[Level], Level]) -> Staircase:
        """Read each level anew."""
        return Staircase(self.times, tuple(map(read, self.points)))

    def as_numbers(self, read: Callable[[Level], float]) -> Table:
        """Return the table with lines between its points that it is to a Real variable."""
        return Table(self.times, tuple(map(read, self.points)))

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The times at which the level changes."""
        pairs = zip(self.times[1:], self.points[1:], self.points[:-1], strict=True)
        return tuple(sorted({time for time, level, last in pairs if level != last}))

    def values(self, times: FloatArray) -> NDArray[np.generic]:
        """Return the level that holds from each time on."""
        return self._held(np.searchsorted(self._times, times, side="right"))

    def left_values(self, times: FloatArray) -> NDArray[np.generic]:
        """Return the level that held until each time."""
        return self._held(np.searchsorted(self._times, times, side="left"))

    def slopes(self, times: FloatArray) -> FloatArray:
        """Return zeros."""
        return np.zeros(times.shape)

    def _held(self, after: NDArray[np.intp]) -> NDArray[np.generic]:
        """Return the level before each place, at the beginning the first."""
        return self._points[np.maximum(after - 1, 0)]


def levels_of_table(port: str, table: Table) -> Staircase:
    """Return a table of numbers as one of whole numbers, where they are, for what is not Real."""
    if table.unit:
        raise SystemDefinitionError(f"{port} is a table in {table.unit}, but is not Real; expected no unit")
    return Staircase(table.times, tuple(int(point) if point.is_integer() else point for point in table.points))


def staircase_of_points(points: Sequence[tuple[float, Level]]) -> Staircase:
    """Build a staircase from pairs of time [s] and level, all of one type."""
    kinds: dict[type[Any], Level] = {}
    for _, level in points:
        kinds.setdefault(type(level), level)
    if len(kinds) > 1:
        first, other = list(kinds.values())[:2]
        raise ScenarioError(f"table: points hold {first!r} and {other!r}; expected values of one type")
    return Staircase(tuple(float(time) for time, _ in points), tuple(level for _, level in points))
