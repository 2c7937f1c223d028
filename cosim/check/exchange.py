"""Many variables got or set at once, on memory laid out beforehand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cosim.check.instance import BASE_TYPES, Instance, base_type, references
from cosim.check.library import ELEMENTS
from cosim.system.description import Variable


class Exchange:
    """Variables of one base type, got or set together on memory laid out once.

    Parameters
    ----------
    kind : str
        One of `BASE_TYPES`.
    variables : sequence of Variable
        All of that type.
    """

    def __init__(self, kind: str, variables: Sequence[Variable]) -> None:
        self.kind = kind
        self.variables = tuple(variables)
        self._references = references(self.variables)
        self._values: Any = (ELEMENTS[kind] * len(self.variables))()

    def get(self, instance: Instance) -> list[Any]:
        """Return the values; CallError if that fails."""
        instance.must(f"Get{self.kind}", self._references, len(self.variables), self._values)
        return list(self._values)

    def set(self, instance: Instance, values: Sequence[Any]) -> None:
        """Set the values; CallError if that fails."""
        self._values[:] = values
        instance.must(f"Set{self.kind}", self._references, len(self.variables), self._values)


def exchanges(variables: Sequence[Variable]) -> tuple[Exchange, ...]:
    """Return variables grouped by base type, those without any left out."""
    groups = {kind: [v for v in variables if base_type(v) == kind] for kind in BASE_TYPES}
    return tuple(Exchange(kind, group) for kind, group in groups.items() if group)
