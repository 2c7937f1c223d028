"""Say how uncertain something is: distributions, from a file or from Python, that samples are drawn from.

A sample is a number between 0 and 1, spread evenly by Latin hypercube or Sobol; a distribution makes a value of it, its
quantile.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from cosim.errors import InputError, require, suggestion
from cosim.scenario.file import read_toml
from cosim.system.signals import FloatArray


@dataclass(frozen=True)
class Distribution:
    """Tell how a number is distributed.

    Parameters
    ----------
    kind : str
        ``"uniform"`` (`low`, `high`), ``"triangular"`` (`low`, `mode`, `high`), ``"normal"`` (`mean`, `deviation`), or
        ``"lognormal"`` (`median`, `factor`: two thirds lie between median / factor and median x factor).
    numbers : mapping of str to float
        Its parameters by name.

    Raises
    ------
    InputError
        If there is no such kind, or its parameters are not these, or make no sense.
    """

    kind: str
    numbers: Mapping[str, float]

    def __post_init__(self) -> None:
        if self.kind not in _KINDS:
            raise InputError(f"there is no distribution '{self.kind}'{suggestion(self.kind, _KINDS)}")
        names = _KINDS[self.kind].names
        if set(self.numbers) != set(names):
            given = ", ".join(self.numbers) or "nothing"
            raise InputError(f"a {self.kind} distribution is given {given}; expected {', '.join(names)}")
        if not all(map(math.isfinite, self.numbers.values())) or not _KINDS[self.kind].fits(self.numbers):
            said = ", ".join(f"{name} = {self.numbers[name]:g}" for name in names)
            raise InputError(f"a {self.kind} distribution has {said}; expected {_KINDS[self.kind].expected}")

    def quantiles(self, parts: FloatArray) -> FloatArray:
        """Return the values below which these parts of all lie."""
        stats = require("scipy.stats", extra="theory", purpose="sampling")
        return np.asarray(_KINDS[self.kind].of(stats, self.numbers).ppf(parts), dtype=np.float64)


@dataclass(frozen=True)
class _Kind:
    """A kind of distribution: the names of its parameters, when they make sense, and what SciPy calls it."""

    names: tuple[str, ...]
    fits: Callable[[Mapping[str, float]], bool]
    expected: str
    of: Callable[[Any, Mapping[str, float]], Any]


_KINDS: Mapping[str, _Kind] = {
    "uniform": _Kind(
        ("low", "high"), lambda n: n["low"] < n["high"], "low < high",
        lambda stats, n: stats.uniform(n["low"], n["high"] - n["low"]),
    ),
    "triangular": _Kind(
        ("low", "mode", "high"), lambda n: n["low"] <= n["mode"] <= n["high"] > n["low"], "low <= mode <= high",
        lambda stats, n: stats.triang((n["mode"] - n["low"]) / (n["high"] - n["low"]), n["low"], n["high"] - n["low"]),
    ),
    "normal": _Kind(
        ("mean", "deviation"), lambda n: n["deviation"] > 0.0, "a deviation > 0",
        lambda stats, n: stats.norm(n["mean"], n["deviation"]),
    ),
    "lognormal": _Kind(
        ("median", "factor"), lambda n: n["median"] > 0.0 and n["factor"] > 1.0, "a median > 0 and a factor > 1",
        lambda stats, n: stats.lognorm(math.log(n["factor"]), 0.0, n["median"]),
    ),
}  # fmt: skip


def read_distributions(path: Path) -> dict[str, Distribution]:
    """Read distributions from a file: by ``component.variable``, a table of `kind` and its parameters.

    Raises
    ------
    InputError
        If it cannot be read, or holds something else.
    """
    found: dict[str, Distribution] = {}
    for name, table in _tables(read_toml(path), ""):
        kind = table.get("kind")
        if not isinstance(kind, str):
            such = '{ kind = "normal", mean = 1, deviation = 0.1 }'
            raise InputError(f"{path.name}: {name}: expected a table such as {such}")
        numbers = {key: value for key, value in table.items() if key != "kind"}
        for key, value in numbers.items():
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise InputError(f"{path.name}: {name}.{key} is {value!r}; expected a number")
        try:
            found[name] = Distribution(kind, numbers)
        except InputError as error:
            raise InputError(f"{path.name}: {name}: {error}") from None
    return found


def _tables(content: Mapping[str, Any], where: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Go through tables by their names, whether ``"plant.L"`` is written with quotation marks or without."""
    for key, value in content.items():
        inside: Mapping[str, Any] = cast(Mapping[str, Any], value) if isinstance(value, Mapping) else {}
        if inside and all(isinstance(each, Mapping) for each in inside.values()):
            yield from _tables(inside, f"{where}{key}.")
        else:
            yield f"{where}{key}", inside
