"""What is seen of a run: its columns by name, and an account of the coupling that is kept as windows come.

Columns are the outputs and inputs of each component, and what is known of the coupling, under ``coupling``.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import format_time
from cosim.master.energy_residual import EnergyAccount
from cosim.master.guards import GuardWatch, find_guards
from cosim.recording.record import BASE_TYPES, BaseType, Block, Window
from cosim.recording.rows import Column, Rows
from cosim.system.description import Description
from cosim.system.power_bonds import find_bonds
from cosim.system.structure import COUPLING, System

log = logging.getLogger("cosim")


@dataclass(frozen=True)
class _Source:
    """Where the values of a column are in a block."""

    column: Column
    component: str
    is_input: bool
    kind: BaseType
    index: int

    def values(self, blocks: Mapping[str, Block]) -> NDArray[Any]:
        """Return its values."""
        block = blocks[self.component]
        section = (block.inputs if self.is_input else block.outputs)[self.kind]
        values = section.values[:, self.index]
        return values != 0 if self.kind == "Boolean" else values


class Observation:
    """Names the columns of windows, and keeps account.

    Parameters
    ----------
    system : System
        What is coupled with what.
    descriptions : mapping of str to Description
        Of the components, by name.
    blocks : mapping of str to Block
        What is recorded of them.
    notes : mapping of str to dtype
        What is recorded about each step.

    Raises
    ------
    SystemDefinitionError
        If a guard or power bond that the system names is none.
    """

    def __init__(
        self,
        system: System,
        descriptions: Mapping[str, Description],
        blocks: Mapping[str, Block],
        notes: Mapping[str, np.dtype[Any]],
    ) -> None:
        self._guards = GuardWatch(find_guards(system, descriptions))
        self._accounts = {bond.input: EnergyAccount(bond) for bond in find_bonds(system, descriptions)}
        self._sources = [source for part in system.components for source in _sources(part.name, blocks[part.name])]
        self._not_finite = False
        float64 = np.dtype(np.float64)
        self.columns = (
            *(source.column for source in self._sources),
            *(Column(f"{COUPLING}.{name}", "1", dtype) for name, dtype in notes.items()),
            *(Column(_residual(name), "J", float64, "energy made by the coupling") for name in self._accounts),
        )

    def rows(self, window: Window) -> Rows:
        """Take account of a window, and return what is new in it."""
        columns = {source.column.name: source.values(window.blocks) for source in self._sources}
        columns |= {f"{COUPLING}.{name}": values for name, values in window.notes.items()}
        columns |= {_residual(name): account.take(window) for name, account in self._accounts.items()}
        new = slice(1 if window.first else 0, None)
        rows = Rows(
            window.first + (1 if window.first else 0),
            window.times[new],
            {name: values[new] for name, values in columns.items()},
        )
        self._guards.take(rows)
        self._warn_of_non_finite(rows)
        return rows

    def record(self) -> dict[str, Any]:
        """Return what is to be told of the coupling."""
        residuals = {name: account.summary() for name, account in self._accounts.items()}
        return {"energy_residual": residuals, "guards": self._guards.summary()}

    def snapshot(self) -> dict[str, Any]:
        """Return the account so far, as JSON can hold it."""
        return {**self.record(), "not_finite": self._not_finite}

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Go on from an account."""
        for name, summary in snapshot["energy_residual"].items():
            self._accounts[name].restore(summary)
        self._guards.restore(snapshot["guards"])
        self._not_finite = snapshot["not_finite"]

    def _warn_of_non_finite(self, rows: Rows) -> None:
        """Name the first output that ceases to be a finite number, if one does, once."""
        if self._not_finite:
            return
        bad: list[tuple[float, str, Any]] = []
        for name, values in rows.columns.items():
            if values.dtype == np.float64 and not np.isfinite(values).all():
                row = int(np.argmin(np.isfinite(values)))
                bad.append((float(rows.times[row]), name, values[row]))
        if bad:
            when, name, value = min(bad)
            log.warning("%s is %s from t = %s s on", name, value, format_time(when))
            self._not_finite = True


def _sources(component: str, block: Block) -> list[_Source]:
    """List the columns of a component: outputs, then inputs, each by type."""
    return [
        _Source(
            Column(
                f"{component}.{variable.name}",
                variable.unit.name if variable.unit else "",
                np.dtype(np.bool_) if kind == "Boolean" else section.values.dtype,
                variable.description,
            ),
            component,
            is_input,
            kind,
            index,
        )
        for is_input, sections in ((False, block.outputs), (True, block.inputs))
        for kind in BASE_TYPES
        for section in [sections[kind]]
        for index, variable in enumerate(section.variables)
    ]


def _residual(name: str) -> str:
    """Return the name of the column of a bond's energy residual."""
    return f"{COUPLING}.energy_residual.{name}"
