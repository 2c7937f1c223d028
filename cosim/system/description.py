"""What an FMU says about itself: variables, units, capabilities, structure. The master knows an FMU by this alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
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


@dataclass(frozen=True)
class Variable:
    """One scalar variable; `minimum`, `maximum` and `start` as in the file, converted to numbers."""

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

    @property
    def settable(self) -> bool:
        """Whether a start value may be given before initialisation."""
        if self.variability == "constant" or self.causality in ("independent", "calculatedParameter"):
            return False
        return self.causality in ("parameter", "input") or self.initial in ("exact", "approx")


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
    start_time: float | None = None
    stop_time: float | None = None
    step_size: float | None = None
    feedthrough: Mapping[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])
    initial_feedthrough: Mapping[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])

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
