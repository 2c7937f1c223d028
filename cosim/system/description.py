"""Describe an FMU by what it says of itself: variables, units, capabilities, structure. The master knows no more.

The units at the two ends of a connection are compared here as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from typing import Literal

VariableType = Literal["Real", "Integer", "Boolean", "Enumeration", "String"]


@dataclass(frozen=True)
class Unit:
    """A unit by name and, where the FMU says so, by its powers of the SI base units.

    Parameters
    ----------
    name : str
        Such as ``"rad/s"``.
    powers : tuple of int, optional
        Exponents of kg, m, s, A, K, mol, cd, rad.
    factor, offset : float
        Value in base units = factor times value + offset.
    """

    name: str
    powers: tuple[int, ...] | None = None
    factor: float = 1.0
    offset: float = 0.0

    @property
    def of_differences(self) -> Unit:
        """The unit of the difference of two such quantities, which has no offset."""
        return replace(self, offset=0.0)


@dataclass(frozen=True)
class Variable:
    """One scalar variable; `minimum` and `maximum` as in the file, converted to numbers, `start` as it is there.

    One that is `relative` is the difference of two quantities of its unit, whose offset does not count then.
    """

    name: str
    reference: int
    type: VariableType
    causality: str
    variability: str = "continuous"
    initial: str | None = None
    unit: Unit | None = None
    start: str | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float = 1.0
    items: Mapping[str, int] = field(default_factory=dict[str, int], hash=False)
    description: str = ""
    relative: bool = False

    @property
    def measured_in(self) -> Unit | None:
        """The unit of its values; without offset if they are differences (FMI 2.0, section 2.2.3)."""
        return self.unit.of_differences if self.unit is not None and self.relative else self.unit

    @property
    def start_value(self) -> float | int | bool | str | None:
        """The start value as what its text stands for, an enumeration's item by its number; None if there is none."""
        if self.start is None or self.type == "String":
            return self.start
        if self.type == "Boolean":
            return self.start.strip() in ("true", "1")
        return float(self.start) if self.type == "Real" else int(self.start)

    @property
    def is_continuous(self) -> bool:
        """Tell whether it is a real number that changes continuously, but for a few places."""
        return self.type == "Real" and self.variability == "continuous"

    @property
    def settable(self) -> bool:
        """Tell whether a start value may be given before initialisation."""
        if self.variability == "constant" or self.causality in ("independent", "calculatedParameter"):
            return False
        return self.causality in ("parameter", "input") or self.initial in ("exact", "approx")

    @property
    def tunable(self) -> bool:
        """Tell whether it is a parameter that may be set between steps too."""
        return self.causality == "parameter" and self.variability == "tunable"


@dataclass(frozen=True)
class Description:
    """The variables and capabilities of one FMI 2.0 co-simulation FMU.

    Parameters
    ----------
    feedthrough, initial_feedthrough : mapping of str to frozenset of str
        On which inputs an output depends directly, in a step and in initialization mode, by the name of the output.
        One that is missing here depends on all of them (FMI 2.0, section 2.2.8).
    start_time, stop_time, step_size : float, optional
        Of the default experiment, as far as there is one [s].
    tolerance : float, optional
        Relative, of the default experiment: for what the FMU integrates by itself.
    generation_tool : str
        What wrote the FMU, as far as it says.
    flaws : tuple of str
        What the file breaks of the standard that does not keep the FMU from running.
    archive_flaws : tuple of str
        What the archive around it has that would keep the FMU from being unpacked on another system.
    """

    model_name: str
    model_identifier: str
    guid: str
    variables: tuple[Variable, ...]
    can_vary_step: bool = True
    can_interpolate_inputs: bool = False
    once_per_process: bool = False
    can_save_state: bool = False
    can_serialize_state: bool = False
    output_derivative_order: int = 0
    provides_directional_derivative: bool = False
    log_categories: tuple[str, ...] = ()
    generation_tool: str = ""
    start_time: float | None = None
    stop_time: float | None = None
    step_size: float | None = None
    tolerance: float | None = None
    feedthrough: Mapping[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])
    initial_feedthrough: Mapping[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])
    flaws: tuple[str, ...] = ()
    archive_flaws: tuple[str, ...] = ()

    @cached_property
    def by_name(self) -> Mapping[str, Variable]:
        """The variables by name."""
        return {variable.name: variable for variable in self.variables}

    def with_causality(self, causality: str) -> tuple[Variable, ...]:
        """Return the inputs, outputs or parameters, in the order of the file."""
        return tuple(variable for variable in self.variables if variable.causality == causality)

    def fed_through(self, output: str, *, initially: bool = False) -> frozenset[str]:
        """Return the names of the inputs that an output depends on directly."""
        known = self.initial_feedthrough if initially else self.feedthrough
        if output in known:
            return known[output]
        given = initially and self.by_name[output].initial == "exact"
        return frozenset() if given else self._all_inputs

    @cached_property
    def _all_inputs(self) -> frozenset[str]:
        """Names of the inputs."""
        return frozenset(variable.name for variable in self.with_causality("input"))


BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


class Match(Enum):
    """Tell how two units compare."""

    SAME = "same"
    ASSUMED = "assumed"
    UNKNOWN = "unknown"
    SCALED = "scaled"
    DIFFERENT = "different"


def compare(source: Unit | None, target: Unit | None) -> Match:
    """Compare two units by their powers of the base units and, failing those, by name.

    This is the one rule for connections, parameters and whatever else comes with a unit. `SAME` is taken as it is, and
    so are `ASSUMED` and `UNKNOWN`, with a warning; a value that comes with a unit is refused where that is `UNKNOWN` to
    a variable which has one. `SCALED` can be converted, `DIFFERENT` cannot.

    Returns
    -------
    Match
        `ASSUMED` if the names are the same and one side only is defined in base units; `UNKNOWN` if one unit is
        missing, or if the names differ and one of them is not defined; `SCALED` if only factor or offset differ.
    """
    if source is None or target is None:
        return Match.SAME if source is target else Match.UNKNOWN
    if source.powers is None or target.powers is None:
        if source.name != target.name:
            return Match.UNKNOWN
        return Match.SAME if source.powers is target.powers else Match.ASSUMED
    if source.powers != target.powers:
        return Match.DIFFERENT
    same = source.factor == target.factor and source.offset == target.offset
    return Match.SAME if same else Match.SCALED


def converted(value: float, source: Unit | None, target: Unit | None) -> float:
    """Return a value in another unit; as it is, unless `compare` finds that there is something to convert."""
    if source is None or target is None or compare(source, target) is not Match.SCALED:
        return value
    return (value * source.factor + source.offset - target.offset) / target.factor


def describe(unit: Unit | None) -> str:
    """Write a unit with what it is in base units, for a message."""
    if unit is None:
        return "no unit"
    if unit.powers is None:
        return unit.name
    names = zip(BASE_UNITS, unit.powers, strict=True)
    base = " ".join(name if power == 1 else f"{name}^{power}" for name, power in names if power) or "1"
    factor = "" if unit.factor == 1.0 else f"{unit.factor:.15g} "
    offset = "" if unit.offset == 0.0 else f" + {unit.offset:.15g}"
    return f"{unit.name} (= {factor}{base}{offset})"
