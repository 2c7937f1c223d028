"""The values of one instance: which may be read, which may be set, when, and to what."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from math import nan
from typing import Any

from ..schema import Kind, Model, Value
from .table import first_value, misfit


class Phase(StrEnum):
    """Name the place in its life at which an instance is (FMI 2.0, section 4.2.4)."""

    INSTANTIATED = "instantiated"
    INITIALIZATION = "initialization mode"
    STEPPING = "stepping"
    TERMINATED = "terminated"


class IllegalCall(Exception):  # noqa: N818
    """A call the standard does not allow; the message says which and what was expected."""


class Values:
    """The values of the variables of a table, by value reference.

    Attributes
    ----------
    current : list
        One value per variable; the list itself is never replaced.
    """

    def __init__(self, model: Model) -> None:
        self.variables = model.variables
        self.current: list[Any] = [first_value(variable) for variable in model.variables]
        self._references: dict[Kind, set[int]] = {kind: set() for kind in ("Real", "Integer", "Boolean", "String")}
        for reference, variable in enumerate(model.variables):
            kind = "Integer" if variable.kind == "Enumeration" else variable.kind
            self._references[kind].add(reference)

    def read(self, kind: Kind, references: Sequence[int]) -> list[Any]:
        """Return the values of variables of one kind; IllegalCall if one is of another, or there is none."""
        known = self._references[kind]
        for reference in references:
            if reference not in known:  # -1, which is what a very large reference arrives as, must not be the last
                raise IllegalCall(self._unknown(kind, reference))
        return [self.current[reference] for reference in references]

    def misfits(self, kind: Kind, references: Sequence[int], given: Sequence[Value], phase: Phase) -> dict[str, str]:
        """Return by name why variables cannot take the values given; IllegalCall if they cannot be set at all."""
        found: dict[str, str] = {}
        for reference, value in zip(references, given, strict=True):
            if reference not in self._references[kind]:
                raise IllegalCall(self._unknown(kind, reference))
            self._require_settable(reference, phase)
            problem = misfit(self.variables[reference], value)
            if problem is not None:
                found[self.variables[reference].name] = problem
        return found

    def invalidate(self) -> None:
        """Make every Real output nan, so that nobody takes it for a result."""
        for reference, variable in enumerate(self.variables):
            if variable.causality == "output" and variable.kind == "Real":
                self.current[reference] = nan

    def _unknown(self, kind: Kind, reference: int) -> str:
        known = sorted(self._references[kind])
        return f"value reference {reference} is not of type {kind}; expected one of {known}"

    def _require_settable(self, reference: int, phase: Phase) -> None:
        variable = self.variables[reference]
        if variable.causality == "output":
            raise IllegalCall(f"output {variable.name} cannot be set; expected an input or a parameter")
        if phase is Phase.TERMINATED:
            raise IllegalCall(f"{variable.causality} {variable.name} cannot be set after terminate")
        if phase is Phase.STEPPING and variable.variability == "fixed":
            raise IllegalCall(f"parameter {variable.name} is fixed; it can be set until the initialisation ends")
