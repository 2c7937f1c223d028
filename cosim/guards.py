"""Guards and limits: Boolean outputs that say that a value is not what the equations ask for.

A law that divides by what may vanish guards the divisor, a drive has a limit. What comes out then closes a loop between
components like any other value, but it is the guard's or the limit's and not a solution of the equations.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.description import Description
from cosim.errors import SystemDefinitionError, suggestion
from cosim.signals import FloatArray
from cosim.system import System

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


def active_spans(
    guards: tuple[str, ...], times: FloatArray, columns: Mapping[str, NDArray[Any]]
) -> dict[str, dict[str, Any]]:
    """Tell of each guard that was ever active at how many communication points, and when first and last.

    Parameters
    ----------
    guards : tuple of str
        Their names.
    times : ndarray, shape (rows,)
        Communication points, s.
    columns : mapping of str to ndarray, shape (rows,)
        Recorded values by name.
    """
    rows = {name: np.flatnonzero(columns[name]) for name in guards}
    return {
        name: {"points": int(active.size), "first": float(times[active[0]]), "last": float(times[active[-1]])}
        for name, active in rows.items()
        if active.size
    }
