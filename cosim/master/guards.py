"""Guards and limits: Boolean outputs that say that a value is not what the equations ask for.

A law that divides by what may vanish guards the divisor, a drive has a limit. What comes out then closes a loop between
components like any other value, but it is the guard's or the limit's and not a solution of the equations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cosim.errors import SystemDefinitionError, suggestion
from cosim.recording.rows import Rows
from cosim.system.description import Description
from cosim.system.structure import System

_ENDING = "_active"


def find_guards(system: System, descriptions: Mapping[str, Description]) -> tuple[str, ...]:
    """Return the names of the guards: those the system names, or else all Boolean outputs that end in ``_active``.

    Raises
    ------
    SystemDefinitionError
        If the system names something that is not a Boolean output.
    """
    outputs = [
        f"{name}.{variable.name}"
        for name, description in descriptions.items()
        for variable in description.with_causality("output")
        if variable.type == "Boolean"
    ]
    if system.guards is None:
        return tuple(name for name in outputs if name.endswith(_ENDING))
    for name in system.guards:
        if name not in outputs:
            raise SystemDefinitionError(f"guards: {name} is no Boolean output{suggestion(name, outputs)}")
    return system.guards


class GuardWatch:
    """Notes at how many communication points each guard was active, and when first and last.

    Parameters
    ----------
    guards : sequence of str
        Their names.
    """

    def __init__(self, guards: Sequence[str]) -> None:
        self._guards = tuple(guards)
        self._spans: dict[str, dict[str, Any]] = {}

    def take(self, rows: Rows) -> None:
        """Look at some more rows."""
        for name in self._guards:
            active = rows.times[np.flatnonzero(rows.columns[name])]
            if active.size:
                span = self._spans.setdefault(name, {"points": 0, "first": float(active[0])})
                span["points"] += int(active.size)
                span["last"] = float(active[-1])

    def summary(self) -> dict[str, dict[str, Any]]:
        """Return what was noted of those that were ever active: points, and the first and the last time, s."""
        return {name: dict(self._spans[name]) for name in self._guards if name in self._spans}

    def restore(self, summary: Mapping[str, Mapping[str, Any]]) -> None:
        """Go on from what was noted."""
        self._spans = {name: dict(span) for name, span in summary.items()}
