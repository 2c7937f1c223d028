"""Lay out the points of a sweep: the product of axes, each a list of values or samples of several variables at once."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError, require, suggestion
from cosim.sweeps.distributions import Distribution
from cosim.sweeps.reading import SAMPLE
from cosim.system.compatibility import Written
from cosim.system.field_units import quantity
from cosim.system.signals import FloatArray, Value, plain_value

SAMPLES = SAMPLE
"""The dimension of samples."""
METHODS = ("latin-hypercube", "sobol", "saltelli")
MOST_POINTS = 100_000_000

Values = str | Iterable[Any]
"""What is said of an axis: text such as ``2:20:65`` or ``8,10,12``, or values."""


Spread = str | tuple[float, float] | Distribution
"""What is said of what is sampled: ``2:20``, least and greatest value, or a distribution."""


@dataclass(frozen=True)
class Axis:
    """A dimension of a sweep.

    Attributes
    ----------
    name : str
        Of the dimension: what varies along it, or `SAMPLES`.
    values : mapping of str to sequence of value
        By ``component.variable``, or by component where that is what varies; all of one length.
    drawn : mapping of str to value
        Of samples: method, count and seed by which they were drawn, and what from; as JSON can hold it.
    """

    name: str
    values: Mapping[str, Sequence[Value]]
    drawn: Mapping[str, Any] = field(default_factory=dict[str, Any])

    @property
    def size(self) -> int:
        """Return how many points there are along it."""
        return len(next(iter(self.values.values())))


@dataclass(frozen=True)
class Design:
    """The points of a sweep, in lines.

    A line is what is run one point after the other: along an axis where runs are continued, else a single point. Lines
    are numbered as the points of the other axes are, the last axis fastest.

    Attributes
    ----------
    axes : tuple of Axis
        Dimensions, in the order of the store.
    along : str or None
        Name of the axis along which runs are continued.
    down : bool
        From the last value along it to the first.
    """

    axes: tuple[Axis, ...]
    along: str | None = None
    down: bool = False

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Return the size of each axis."""
        return tuple(axis.size for axis in self.axes)

    @property
    def points(self) -> int:
        """Return how many points there are."""
        return math.prod(self.shape)

    @cached_property
    def across(self) -> tuple[int, ...]:
        """Return the numbers of the axes that lines are numbered by."""
        return tuple(number for number, axis in enumerate(self.axes) if axis.name != self.along)

    @cached_property
    def length(self) -> int:
        """Return how many points a line has."""
        return 1 if self.along is None else next(axis.size for axis in self.axes if axis.name == self.along)

    @property
    def lines(self) -> int:
        """Return how many lines there are."""
        return self.points // self.length

    @cached_property
    def lines_per_row(self) -> int:
        """Return how many lines have the same place on the first axis that they are numbered by."""
        return math.prod([self.shape[number] for number in self.across[1:]])

    def place(self, line: int, step: int) -> tuple[int, ...]:
        """Return the indices of a point: of a step, in the order of running, on a line."""
        indices = [0] * len(self.axes)
        for number in reversed(self.across):
            line, indices[number] = divmod(line, self.shape[number])
        for number, axis in enumerate(self.axes):
            if axis.name == self.along:
                indices[number] = axis.size - 1 - step if self.down else step
        return tuple(indices)

    def values(self, line: int, step: int) -> dict[str, Value]:
        """Return what is set at a point."""
        return {
            name: plain_value(values[index])
            for axis, index in zip(self.axes, self.place(line, step), strict=True)
            for name, values in axis.values.items()
        }


def read_values(name: str, said: Values) -> list[Value]:
    """Read the values of an axis: text stays `Written` where it is no range, to be read by the type of its variable.

    Raises
    ------
    InputError
        If there are none, a range is reversed, or a value comes twice.
    """
    if isinstance(said, str):
        parts = said.split(":")
        values = _range(name, said, parts) if len(parts) > 1 else _list(said)
    else:
        values = _given(name, said)
    if not values:
        raise InputError(f"{name}: there are no values; expected some, such as 2:20:65 or 8,10,12")
    for value in values:
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"{name}: a value is {value}; expected finite numbers")
    refuse_twice(name, values)
    return values


def _given(name: str, said: object) -> list[Value]:
    """Read values that are no text, and need not be what they are expected to be."""
    if not isinstance(said, Iterable) or isinstance(said, bytes):
        raise InputError(f"{name} is {said!r}; expected several values, such as [8, 10, 12], or text such as 2:20:65")
    values = [plain_value(value) for value in cast(Iterable[Any], said)]
    for value in values:
        if not isinstance(value, Hashable):
            raise InputError(f"{name}: a value is {value}; expected a number or a text")
    return values


def refuse_twice(name: str, values: Sequence[Value]) -> None:
    """Refuse values of an axis of which one comes twice."""
    seen: set[Value] = set()
    for value in values:
        if value in seen:
            raise InputError(f"{name}: {value} is given twice; expected each value once")
        seen.add(value)


def _list(text: str) -> list[Value]:
    """Read values with commas between them."""
    return [Written(part.strip()) for part in text.split(",") if part.strip()]


def _range(name: str, text: str, parts: Sequence[str]) -> list[Value]:
    """Read ``first:last:count``, whose ends may have a unit."""
    try:
        first, last, count = _end(parts[0]), _end(parts[1]), int(parts[2])
    except (ValueError, IndexError):
        raise InputError(f"{name}={text}: expected first:last:count, such as 2:20:65") from None
    if len(parts) > 3:
        raise InputError(f"{name}={text}: expected first:last:count, such as 2:20:65")
    if count < 1:
        raise InputError(f"{name}={text}: the range is empty; expected a count of 2 or more")
    if first[1] != last[1]:
        raise InputError(f"{name}={text}: the ends are in different units; expected one")
    if not (math.isfinite(first[0]) and math.isfinite(last[0])):
        raise InputError(f"{name}={text}: expected finite numbers")
    if last[0] < first[0]:
        raise InputError(f"{name}={text}: the range is reversed; expected {parts[1]}:{parts[0]}:{parts[2]}")
    if count == 1 or first == last:
        raise InputError(f"{name}={text}: the range is a single value; expected {name}={parts[0]}")
    if count > MOST_POINTS:
        raise InputError(f"{name}={text}: expected at most {MOST_POINTS} values")
    return _with_unit(np.linspace(first[0], last[0], count), first[1])


def _end(text: str) -> tuple[float, str]:
    """Read a number, and its unit if it has one; ValueError if it is none."""
    return quantity(text) or (float(text), "")


def _with_unit(values: FloatArray, unit: str) -> list[Value]:
    """Return numbers as they are, or with a unit as texts, which are read by the unit of their variable."""
    numbers: list[float] = values.tolist()
    return [Written(f"{number!r} {unit}") for number in numbers] if unit else list(numbers)


def sampled(bounds: Mapping[str, Spread], count: int, method: str, seed: int) -> Axis:
    """Draw samples of several variables at once, each uniform between its bounds, or of a distribution.

    Parameters
    ----------
    bounds : mapping of str to str, (float, float) or Distribution
        By ``component.variable``: ``2:20``, or least and greatest value, or how it is distributed.
    count : int
        How many samples; by Saltelli's method, of whose samples Sobol indices are estimated, for each of them as many
        as there are variables, and two.
    method : str
        One of `METHODS`.
    seed : int
        Draws the same samples again.

    Raises
    ------
    InputError
        If bounds, count or method make no sense.
    """
    if method not in METHODS:
        raise InputError(f"there is no way of sampling '{method}'{suggestion(method, METHODS)}")
    read = [said if isinstance(said, Distribution) else _bounds(name, said) for name, said in bounds.items()]
    if seed < 0:
        raise InputError(f"the seed is {seed}; expected a whole number >= 0")
    if not 1 <= count <= MOST_POINTS:
        raise InputError(f"{count} samples were asked for; expected 1 to {MOST_POINTS}")
    if method != METHODS[0] and count & (count - 1):
        below = 1 << (count.bit_length() - 1)
        raise InputError(f"{count} Sobol samples are not balanced; expected a power of two: {below} or {2 * below}")
    unit = _saltelli(len(bounds), count, seed) if method == "saltelli" else _spread(method, len(bounds), count, seed)
    columns = zip(bounds, read, unit.T, strict=True)
    drawn = {
        "method": method,
        "count": count,
        "seed": seed,
        "from": {name: _said(each) for name, each in bounds.items()},
    }
    return Axis(SAMPLES, {name: _drawn(each, parts) for name, each, parts in columns}, drawn)


def _spread(method: str, variables: int, count: int, seed: int) -> FloatArray:
    """Draw numbers from 0 to 1 evenly, a row for each sample."""
    qmc = require("scipy.stats.qmc", extra="theory", purpose="sampling")
    draw = qmc.Sobol if method == "sobol" else qmc.LatinHypercube
    return cast(NDArray[np.float64], draw(variables, rng=seed).random(count))


def _saltelli(variables: int, count: int, seed: int) -> FloatArray:
    """Draw pairs of Sobol samples, and those in which one variable is of the other of the pair: Saltelli (2010)."""
    salib = require("SALib.sample.sobol", extra="sensitivity", purpose="sampling for Sobol indices")
    problem = {"num_vars": variables, "names": list(map(str, range(variables))), "bounds": [[0.0, 1.0]] * variables}
    return np.asarray(salib.sample(problem, count, calc_second_order=False, seed=seed), dtype=np.float64)


def _said(spread: Spread) -> Any:
    """Return what samples are drawn from as JSON can hold it."""
    if isinstance(spread, Distribution):
        return {"kind": spread.kind, **spread.numbers}
    return spread if isinstance(spread, str) else list(spread)


def _drawn(spread: Distribution | tuple[float, float, str], parts: FloatArray) -> list[Value]:
    """Make values of parts from 0 to 1."""
    if isinstance(spread, Distribution):
        return list(spread.quantiles(parts).tolist())
    low, high, unit = spread
    return _with_unit(low + parts * (high - low), unit)


def _bounds(name: str, said: str | tuple[float, float]) -> tuple[float, float, str]:
    """Read least and greatest value, and their unit."""
    try:
        ends = [_end(text) for text in said.split(":")] if isinstance(said, str) else [(float(end), "") for end in said]
        (low, unit), (high, other) = ends
    except (TypeError, ValueError):
        raise InputError(f"{name}={said}: expected least:greatest, such as 2:20") from None
    if unit != other:
        raise InputError(f"{name}={said}: the ends are in different units; expected one")
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise InputError(f"{name}={low:g}:{high:g}: the range is empty or reversed; expected least:greatest")
    return low, high, unit


def product(axes: Sequence[Axis], along: str | None, branch: str) -> Design:
    """Return the points of all combinations.

    Parameters
    ----------
    axes : sequence of Axis
        Dimensions.
    along : str, optional
        The axis along which runs are continued; by default the first.
    branch : str
        ``"rest"``: each point begins anew; ``"up"`` or ``"down"``: runs are continued along an axis.

    Raises
    ------
    InputError
        If there is nothing to vary, something varies twice, or it cannot be continued so.
    """
    if not axes:
        raise InputError("there is nothing to vary; expected a grid or samples")
    names = [name for axis in axes for name in axis.values]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{name} is varied twice; expected each name once")
    if branch not in BRANCHES:
        raise InputError(f"there is no branch '{branch}'{suggestion(branch, BRANCHES)}")
    design = Design(tuple(axes), None if branch == "rest" else along or axes[0].name, branch == "down")
    if design.points > MOST_POINTS:
        raise InputError(f"there are {design.points} points; expected at most {MOST_POINTS}")
    if design.along is None:
        if along is not None:
            raise InputError(f"runs from rest are not continued along {along}; expected the branch up or down")
        return design
    continued = next((axis for axis in axes if axis.name == design.along), None)
    if continued is None or continued.name == SAMPLES:
        known = [axis.name for axis in axes if axis.name != SAMPLES]
        raise InputError(f"runs cannot be continued along '{design.along}'{suggestion(design.along, known)}")
    values = [value for each in continued.values.values() for value in each]
    if any(isinstance(value, bool | str) for value in values) or values != sorted(cast(list[float], values)):
        raise InputError(f"runs cannot be continued along {continued.name}; expected increasing numbers")
    return design


BRANCHES = ("rest", "up", "down")
