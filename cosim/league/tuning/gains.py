"""Say which gains are free, from where to where: by name, by what a league says of a law, or of its FMU."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cosim.errors import InputError, ScenarioError, suggestion
from cosim.league.entries import USUAL, Law, League, Range, checked_range, load_league
from cosim.system.description import Description, Variable
from cosim.system.signals import Value

DIGITS = 4
"""Of the values that are tried: gains to be written down, and the same ones on every machine."""


@dataclass(frozen=True)
class Gain:
    """A parameter that is free.

    Attributes
    ----------
    name, unit : str
        Of the parameter.
    start : float
        What the law has of itself.
    low, high : float
        Least and greatest value. Where both are above zero their logarithm is searched.
    """

    name: str
    unit: str
    start: float
    low: float
    high: float

    @property
    def title(self) -> str:
        """Name and unit."""
        return f"{self.name} [{self.unit}]" if self.unit not in ("", "1") else self.name

    def at(self, place: float) -> float:
        """Return the value at a place between 0, the least, and 1, the greatest."""
        if self.low > 0.0:
            value = self.low * math.exp(place * math.log(self.high / self.low))
        else:
            value = self.low + place * (self.high - self.low)
        return min(self.high, max(self.low, float(f"{value:.{DIGITS}g}")))

    def place_of(self, value: float) -> float:
        """Return where a value is, 0 or 1 if it is beyond."""
        value = min(self.high, max(self.low, value))
        if self.low > 0.0:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


def free_gains(
    league: League, law: Law, described: Description, found: Mapping[str, Value], asked: Sequence[str]
) -> tuple[Gain, ...]:
    """Return the gains that are free.

    Parameters
    ----------
    league : League
        Says which are free where nothing is asked for; what it leaves out is as in the league of the package.
    law : Law
        The law.
    described : Description
        Of its FMU.
    found : mapping of str to value
        What the law has of itself, by parameter.
    asked : sequence of str
        Each ``name=low:high``, or ``name`` where its range is known.

    Raises
    ------
    InputError
        If there is no such parameter, it is no number, or its range is not understood or beyond its limits.
    """
    known = {**load_league(USUAL).tunes, **league.tunes}
    usual = known.get(law.name, known.get(described.model_name, {}))
    chosen: dict[str, tuple[Range, str]] = {name: (bounds, f"tunes.{name}") for name, bounds in usual.items()}
    if asked:
        read = [_read(text, usual) for text in asked]
        chosen = {name: (bounds, f"--gain {text}") for (name, bounds), text in zip(read, asked, strict=True)}
        if len(chosen) < len(asked):
            raise InputError(f"--gain: {', '.join(asked)} name a parameter twice; expected each once")
    if not chosen:
        raise InputError(f"nothing is known of what to tune of {described.model_name}; expected --gain name=low:high")
    return tuple(_gain(name, *bounds, described, found) for name, bounds in chosen.items())


def _read(text: str, usual: Mapping[str, Range]) -> tuple[str, Range]:
    """Read what was asked for."""
    name, equals, written = (part.strip() for part in text.partition("="))
    if not equals:
        if name not in usual:
            raise InputError(f"--gain {text}: its range is not known; expected the form name=low:high")
        return name, usual[name]
    low, _, high = written.partition(":")
    try:
        bounds = Range(float(low), float(high))
    except ValueError:
        raise InputError(f"--gain {text}: expected the form name=low:high, with two numbers") from None
    return name, checked_range(bounds, f"--gain {text}")


def _gain(name: str, bounds: Range, where: str, described: Description, found: Mapping[str, Value]) -> Gain:
    """Return a gain, whose range is that of a number that can be set."""
    variable = _parameter(name, where, described)
    start = found[name]
    if not isinstance(start, float | int):
        raise InputError(f"{where}: {described.model_name}.{name} is {start!r}; expected a number to tune")
    if bounds.times:
        bounds = _range_of(start, bounds)
        if not bounds.low < bounds.high:
            raise ScenarioError(f"{where}: {name} is {start:g} of itself; expected a range, not multiples of it")
    least = -math.inf if variable.minimum is None else variable.minimum
    most = math.inf if variable.maximum is None else variable.maximum
    if not least <= bounds.low < bounds.high <= most:
        limits = f"{described.model_name}.{name} is between {least:g} and {most:g}"
        raise InputError(f"{where} goes from {bounds.low:g} to {bounds.high:g}; {limits}")
    return Gain(name, variable.unit.name if variable.unit else "", float(start), bounds.low, bounds.high)


def _range_of(start: float, bounds: Range) -> Range:
    """Return a range of multiples of a value in its unit."""
    ends = bounds.low * start, bounds.high * start
    return Range(min(ends), max(ends))


def _parameter(name: str, where: str, described: Description) -> Variable:
    """Return the parameter of a name."""
    known = [each.name for each in described.variables if each.causality == "parameter" and each.type == "Real"]
    variable = described.by_name.get(name)
    if variable is None or variable.causality != "parameter":
        hint = suggestion(name, known)
        raise InputError(f"{where}: {described.model_name} has no parameter '{name}'{hint}")
    if variable.type != "Real":
        kind = f"{described.model_name}.{name} is of type {variable.type}"
        raise InputError(f"{where}: {kind}; expected a Real parameter")
    return variable
