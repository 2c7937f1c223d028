"""Drive inputs and tunable parameters of a system over time by signals: constants, steps, ramps, tables.

A signal is a function of time that is smooth between its breakpoints. At a jump it has two values; `values` gives the
one after it and `left_values` the one before. The master evaluates signals at communication points only, and makes
breakpoints communication points where the FMUs allow it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from cosim.errors import ScenarioError, format_time

if TYPE_CHECKING:
    from cosim.system.description import Variable

Value = float | int | bool | str
Level = Value
FloatArray = NDArray[np.float64]

Change = tuple[float, float, float, float]
"""Initial value, final value, start [s] and duration [s]."""


def plain_value(value: Any) -> Any:
    """Return a number or Boolean of NumPy, or an array of one alone, as what Python has for it; else what is given."""
    single = isinstance(value, np.generic) or (isinstance(value, np.ndarray) and cast(Any, value).ndim == 0)
    return cast(Any, value).item() if single else cast(Any, value)


class Signal(Protocol):
    """A value over time [s].

    A signal of one's own derives from this class and gives its `kind`, breakpoints, values and slopes; the rest follows
    from them, but may be told better.
    """

    kind: ClassVar[str]
    """Name what it is called in scenarios, records and messages."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times of jumps and kinks, s, increasing."""
        ...

    def values(self, times: FloatArray) -> NDArray[np.generic]:
        """Values at `times`, after a jump where there is one; same shape."""
        ...

    def left_values(self, times: FloatArray) -> NDArray[np.generic]:
        """Values at `times`, before a jump where there is one; same shape."""
        ...

    def slopes(self, times: FloatArray) -> FloatArray:
        """Give the derivatives [1/s] just after `times`; same shape."""
        ...

    @property
    def levels(self) -> tuple[Level, ...] | None:
        """All values it ever has, if it only jumps between them; None if it may have any, as only a Real can."""
        return None

    def with_levels(self, read: Callable[[Level], Level]) -> Signal:
        """Return the signal with its levels read anew, each by itself; as it is where it has none."""
        del read
        return self

    @property
    def held(self) -> Level | None:
        """The value, if it never changes."""
        levels = self.levels
        return levels[0] if levels is not None and len(levels) == 1 else None

    @property
    def is_level(self) -> bool:
        """Tell whether it is known to be level between its breakpoints, so that it has no slope anywhere."""
        return self.levels is not None

    @property
    def change(self) -> Change | None:
        """Return it as one change of a number, at once or along a straight line, if it is."""
        return None

    def driving(self, port: str, variable: Variable) -> Signal:
        """Return what it is to the variable that it drives, whose type may say how it is to be read."""
        del port, variable
        return self

    def record(self) -> dict[str, Any]:
        """Return its kind and the numbers it is made from, as JSON can hold them."""
        return {"kind": self.kind, **{name: getattr(self, name) for name in self.parts()}}

    @classmethod
    def parts(cls) -> tuple[str, ...]:
        """Name the numbers that it is made from, as scenarios and records do."""
        return tuple(part.name for part in fields(cls) if part.init) if is_dataclass(cls) else ()


@dataclass(frozen=True)
class Constant(Signal):
    """Hold one value for ever.

    Parameters
    ----------
    value : float, int, bool or str
        In the unit of what it drives; for an enumeration a number or an item's name.
    """

    kind: ClassVar[str] = "constant"

    value: Level

    def __post_init__(self) -> None:
        _take_plain(self, "value")

    @property
    def levels(self) -> tuple[Level, ...]:
        """The value."""
        return (self.value,)

    def with_levels(self, read: Callable[[Level], Level]) -> Constant:
        """Read the value anew."""
        return Constant(read(self.value))

    @property
    def change(self) -> Change | None:
        """No change at time 0, of a number."""
        if isinstance(self.value, bool | str):
            return None
        return float(self.value), float(self.value), 0.0, 0.0

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """No time at all."""
        return ()

    def values(self, times: FloatArray) -> NDArray[np.generic]:
        """Return the value, once for each time."""
        return np.full(times.shape, self.value)

    def left_values(self, times: FloatArray) -> NDArray[np.generic]:
        """Return the value, once for each time."""
        return self.values(times)

    def slopes(self, times: FloatArray) -> FloatArray:
        """Return zeros."""
        return np.zeros(times.shape)


@dataclass(frozen=True)
class Step(Signal):
    """Jump from one value to another.

    Parameters
    ----------
    before, after : float, int, bool or str
        The values until the jump and from it on, of one type, as those of `Constant`.
    at : float
        Time of the jump, s.

    Raises
    ------
    ScenarioError
        If the time is not finite, or the values are of two types.
    """

    kind: ClassVar[str] = "step"

    before: Level
    after: Level
    at: float

    def __post_init__(self) -> None:
        _take_plain(self, "before", "after", "at")
        _require_finite("step", at=self.at)
        if any(isinstance(self.before, kind) is not isinstance(self.after, kind) for kind in (bool, str)):
            raise ScenarioError(f"step: before is {self.before!r} and after is {self.after!r}; expected the same type")

    @property
    def levels(self) -> tuple[Level, ...]:
        """The values before and after."""
        return self.before, self.after

    def with_levels(self, read: Callable[[Level], Level]) -> Step:
        """Read the values before and after anew."""
        return Step(read(self.before), read(self.after), self.at)

    @property
    def change(self) -> Change | None:
        """A jump of a number."""
        if isinstance(self.before, bool | str) or isinstance(self.after, bool | str):
            return None
        return float(self.before), float(self.after), self.at, 0.0

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The time of the jump."""
        return (self.at,)

    def values(self, times: FloatArray) -> NDArray[np.generic]:
        """Return `after` from the jump on."""
        return np.where(times >= self.at, self.after, self.before)

    def left_values(self, times: FloatArray) -> NDArray[np.generic]:
        """Return `after` past the jump."""
        return np.where(times > self.at, self.after, self.before)

    def slopes(self, times: FloatArray) -> FloatArray:
        """Return zeros."""
        return np.zeros(times.shape)


@dataclass(frozen=True)
class Table(Signal):
    """Straight lines through points; a time given twice is a jump; held before the first and after the last.

    Parameters
    ----------
    times : tuple of float
        Times of the points, s, not decreasing, none more than twice.
    points : tuple of float
        Values there, as many.
    unit : str
        What they are in, if not in the unit of the input; see `cosim.system.field_units.in_declared_units`.
    origin : Signal, optional
        The column of a file that they were read from, which is read anew for what is not Real.
    """

    kind: ClassVar[str] = "table"

    times: tuple[float, ...]
    points: tuple[float, ...]
    unit: str = ""
    origin: Signal | None = field(default=None, repr=False, compare=False)
    _times: FloatArray = field(init=False, repr=False, compare=False)
    _points: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ("times", "points"):
            object.__setattr__(self, name, tuple(map(plain_value, getattr(self, name))))
        times, points = np.array(self.times, dtype=float), np.array(self.points, dtype=float)
        if times.shape != points.shape or times.size == 0:
            raise ScenarioError(f"table: {points.size} values at {times.size} times; expected as many and at least one")
        if not (np.isfinite(times).all() and np.isfinite(points).all()):
            raise ScenarioError("table: a time or value is not finite")
        if (np.diff(times) < 0).any() or (times[2:] == times[:-2]).any():
            raise ScenarioError("table: times must not decrease, and none may be given more than twice")
        width = np.diff(times)
        with np.errstate(over="ignore", invalid="ignore"):
            steep = ~np.isfinite(np.diff(points)) | ~np.isfinite(np.diff(points) / np.where(width > 0, width, np.inf))
        if steep.any():
            at = times[int(np.argmax(steep))]
            raise ScenarioError(f"table: the line that begins at {format_time(at)} s is steeper than numbers can hold")
        object.__setattr__(self, "_times", times)
        object.__setattr__(self, "_points", points)

    def driving(self, port: str, variable: Variable) -> Signal:
        """Return itself, or to what is not Real what the file that it is from is to that."""
        return self if variable.type == "Real" or self.origin is None else self.origin.driving(port, variable)

    def record(self) -> dict[str, Any]:
        """Return its kind, its points, and their unit if it is not that of the input."""
        told: dict[str, Any] = {"kind": self.kind, "times": self.times, "points": self.points}
        return {**told, "unit": self.unit} if self.unit else told

    @property
    def is_level(self) -> bool:
        """Tell whether all points between jumps are equal."""
        return not self.slopes(np.array(self.breakpoints)).any()

    @property
    def change(self) -> Change | None:
        """A ramp, where two points make one, in the unit of the input."""
        if self.unit:
            return None
        match self:
            case Table((begin, end), (initial, final)) if end > begin:
                return initial, final, begin, _duration(begin, end)
            case _:
                return None

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The time of every point."""
        return tuple(sorted(set(self.times)))

    def values(self, times: FloatArray) -> NDArray[np.generic]:
        """Interpolate; at a jump, return the value after it."""
        return self._interpolate(times, np.searchsorted(self._times, times, side="right"))

    def left_values(self, times: FloatArray) -> NDArray[np.generic]:
        """Interpolate; at a jump, return the value before it."""
        return self._interpolate(times, np.searchsorted(self._times, times, side="left"))

    def slopes(self, times: FloatArray) -> FloatArray:
        """Return the slope of the line that starts at or before each time; zero outside the table."""
        upper = np.searchsorted(self._times, times, side="right")
        inside = (upper > 0) & (upper < self._times.size)
        slopes = np.zeros(times.shape)
        above = upper[inside]
        rise = self._points[above] - self._points[above - 1]
        slopes[inside] = rise / (self._times[above] - self._times[above - 1])
        return slopes

    def _interpolate(self, times: FloatArray, upper: NDArray[np.intp]) -> FloatArray:
        """Evaluate between the points `upper` - 1 and `upper`, of which one may not exist."""
        high = np.minimum(upper, self._times.size - 1)
        low = np.maximum(upper - 1, 0)
        width = self._times[high] - self._times[low]
        part = np.divide(times - self._times[low], width, out=np.zeros(times.shape), where=width > 0)
        return self._points[low] + part * (self._points[high] - self._points[low])


@dataclass(frozen=True)
class Ramp(Signal):
    """Go from one value to another on a straight line.

    Parameters
    ----------
    initial, final : float
        The values before the change and after it, in the unit of what it drives.
    start, duration : float
        When the change begins, and how long it takes, s.
    unit : str
        What the values are in, if not in the unit of the input; see `cosim.system.field_units.in_declared_units`.

    Raises
    ------
    ScenarioError
        If a number is not finite, or the duration is negative.
    """

    kind: ClassVar[str] = "ramp"

    initial: float
    final: float
    start: float
    duration: float
    unit: str = ""
    _line: Table = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        _take_plain(self, "initial", "final", "start", "duration")
        _require_finite("ramp", initial=self.initial, final=self.final, start=self.start, duration=self.duration)
        if self.duration < 0:
            raise ScenarioError(f"ramp: duration is {self.duration:g} s; expected a number >= 0")
        line = Table((self.start, self.start + self.duration), (self.initial, self.final))
        object.__setattr__(self, "_line", line)

    def record(self) -> dict[str, Any]:
        """Return its kind, its numbers, and their unit if it is not that of the input."""
        told = super().record()
        return told if self.unit else {name: value for name, value in told.items() if name != "unit"}

    @property
    def is_level(self) -> bool:
        """Tell whether it leads nowhere."""
        return self._line.is_level

    @property
    def change(self) -> Change:
        """Itself."""
        return self.initial, self.final, self.start, self.duration

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Return where it starts and ends."""
        return self._line.breakpoints

    def values(self, times: FloatArray) -> NDArray[np.generic]:
        """Interpolate."""
        return self._line.values(times)

    def left_values(self, times: FloatArray) -> NDArray[np.generic]:
        """Interpolate."""
        return self._line.left_values(times)

    def slopes(self, times: FloatArray) -> FloatArray:
        """Return the slope from the start on, and zero from the end on."""
        return self._line.slopes(times)


def signal_of_change(change: Change) -> Constant | Step | Ramp:
    """Return the signal that makes a change: where nothing changes at time 0, a constant."""
    initial, final, start, duration = change
    if (initial, start, duration) == (final, 0.0, 0.0):
        return Constant(initial)
    return ramp(initial, final, start, duration)


def _duration(begin: float, end: float) -> float:
    """Return the duration that leads to the very number of the end, where the difference is a last bit off."""
    duration = end - begin
    near = (duration, math.nextafter(duration, 0.0), math.nextafter(duration, math.inf))
    return next((number for number in near if begin + number == end), duration)


def ramp(initial: float, final: float, start: float, duration: float) -> Step | Ramp:
    """Build the signal that goes from one value to another on a straight line.

    Parameters
    ----------
    initial, final : float
        The values before the change and after it, in the unit of what it drives.
    start, duration : float
        When the change begins, and how long it takes, s.

    Returns
    -------
    Ramp or Step
        A step if the duration is zero.

    Raises
    ------
    ScenarioError
        If a number is not finite, or the duration is negative.
    """
    if duration == 0:
        _require_finite("ramp", initial=initial, final=final)
        return Step(initial, final, start)
    return Ramp(initial, final, start, duration)


def table_of_points(points: Sequence[Sequence[float]], unit: str = "", factor: float = 1.0) -> Table:
    """Build a table from pairs of time [s] and value, which is multiplied by a factor, and then is in a unit."""
    if any(len(point) != 2 for point in points):
        raise ScenarioError("table: every point must be a pair of time and value")
    return Table(tuple(float(point[0]) for point in points), tuple(factor * float(point[1]) for point in points), unit)


def _take_plain(signal: Signal, *names: str) -> None:
    """Let attributes be numbers of Python."""
    for name in names:
        object.__setattr__(signal, name, plain_value(getattr(signal, name)))


def _require_finite(what: str, **numbers: float) -> None:
    """Refuse a number that is NaN or infinite."""
    for name, number in numbers.items():
        if not math.isfinite(number):
            raise ScenarioError(f"{what}: {name} is {number}; expected a finite number")
