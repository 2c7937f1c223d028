"""Observe a run: its columns by name, and an account of the coupling that is kept as windows come.

Columns are the outputs and inputs of each component, and what is known of the coupling, under ``coupling``.

A law that divides by what may vanish guards the divisor, a drive has a limit. What comes out then closes a loop between
components like any other value, but it is the guard's or the limit's and not a solution of the equations; Boolean
outputs say so, and are counted.

Across a power bond, what is taken in is not just what is given. Over each step the power taken in is the input as it
was set, held or on a straight line, times the output of the same component; the power given is the output that drives
the input, times what its component was given in return: both as that component counts them, in its own units, where a
connection converts. Between communication points outputs are taken to go on
straight lines. The difference, integrated over the step, is the energy residual: positive where the coupling adds
energy. An exact coupling has none. Energy residuals are due to Sadjina, Kyllingstad, Skjong and Pedersen (2017), Energy
conservation and power bonds in co-simulations, Engineering with Computers 33, who take the powers at communication
points.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import SystemDefinitionError, format_time, suggestion
from cosim.recording.record import BASE_TYPES, BaseType, Block, Section, Window, base_type
from cosim.recording.result import Column, Rows
from cosim.system.conversion import Conversion, conversion_of
from cosim.system.dependency import Loop, feedthrough_loops, moves
from cosim.system.description import Description
from cosim.system.power_bonds import Bond, find_bonds
from cosim.system.signals import FloatArray
from cosim.system.structure import COUPLING, Connection, Port, System

log = logging.getLogger("cosim")


@dataclass(frozen=True)
class _Source:
    """Locate the values of a column in a block."""

    column: Column
    component: str
    is_input: bool
    kind: BaseType
    index: int

    @property
    def is_flag(self) -> bool:
        """Tell whether values are made of those in the block, and are not these themselves."""
        return self.kind == "Boolean"

    def values(self, blocks: Mapping[str, Block]) -> NDArray[Any]:
        """Return its values."""
        block = blocks[self.component]
        section = (block.inputs if self.is_input else block.outputs)[self.kind]
        values = section.values[:, self.index]
        return values != 0 if self.is_flag else values


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
    iterates : bool
        Whether loops are closed, so that what is not iterated has to be told.

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
        *,
        iterates: bool = False,
    ) -> None:
        loops = feedthrough_loops(system, descriptions) if iterates else ()
        late = [connection for connection in system.connections if iterates and not moves(connection, descriptions)]
        self._late = LateWatch(late, loops, descriptions)
        self._guards = GuardWatch(find_guards(system, descriptions))
        self._accounts = {
            bond.input: EnergyAccount(bond, _discrete(bond, descriptions)) for bond in find_bonds(system, descriptions)
        }
        self._sources = [source for part in system.components for source in _sources(part.name, blocks[part.name])]
        self._not_finite = False
        float64 = np.dtype(np.float64)
        self._flags = [each for each in self._sources if each.is_flag]
        self._seen: tuple[Mapping[str, Block], int] | None = None
        self._views: dict[str, NDArray[Any]] = {}
        self.columns = (
            *(source.column for source in self._sources),
            *(Column(f"{COUPLING}.{name}", "1", dtype) for name, dtype in notes.items()),
            *(Column(_residual(name), "J", float64, "energy made by the coupling") for name in self._accounts),
        )

    def rows(self, window: Window) -> Rows:
        """Take account of a window, and return what is new in it."""
        new = slice(1 if window.first else 0, None)
        seen = window.blocks, new.start
        if self._seen is None or self._seen[0] is not seen[0] or self._seen[1] != seen[1]:
            # as a rule, all windows but the first and the last have the same memory
            self._seen = seen
            self._views = {each.column.name: each.values(window.blocks)[new] for each in self._sources}
        columns = dict(self._views)
        for each in self._flags:
            columns[each.column.name] = each.values(window.blocks)[new]
        columns |= {f"{COUPLING}.{name}": values[new] for name, values in window.notes.items()}
        residuals = {_residual(name): account.take(window)[new] for name, account in self._accounts.items()}
        columns |= residuals
        rows = Rows(window.first + new.start, window.times[new], columns)
        self._guards.take(rows)
        self._late.take(window)
        if not self._not_finite and not _are_finite(window, residuals.values()):
            self._warn_of_non_finite(rows)
        return rows

    def record(self) -> dict[str, Any]:
        """Return what is to be told of the coupling."""
        residuals = {name: account.summary() for name, account in self._accounts.items()}
        late = self._late.summary()
        told = {"energy_residual": residuals, "guards": self._guards.summary()}
        return {**told, "not_iterated": late} if late else told

    def snapshot(self) -> dict[str, Any]:
        """Return the account so far, as JSON can hold it."""
        return {**self.record(), "not_finite": self._not_finite}

    def restore(self, snapshot: Mapping[str, Any]) -> None:
        """Go on from an account."""
        for name, summary in snapshot["energy_residual"].items():
            self._accounts[name].restore(summary)
        self._guards.restore(snapshot["guards"])
        self._late.restore(snapshot.get("not_iterated", {}))
        self._not_finite = snapshot["not_finite"]

    def _warn_of_non_finite(self, rows: Rows) -> None:
        """Name the first output that ceases to be a finite number, if one does, once."""
        bad: list[tuple[float, str, Any]] = []
        for name, values in rows.columns.items():
            if values.dtype == np.float64 and not np.isfinite(values).all():
                row = int(np.argmin(np.isfinite(values)))
                bad.append((float(rows.times[row]), name, values[row]))
        if bad:
            when, name, value = min(bad)
            log.warning("%s is %s from t = %s s on", name, value, format_time(when))
            self._not_finite = True


def _are_finite(window: Window, residuals: Iterable[NDArray[Any]]) -> bool:
    """Tell whether all numbers of a window are finite, at less cost than by column."""
    numbers = [part["Real"].values for block in window.blocks.values() for part in (block.inputs, block.outputs)]
    return all(np.isfinite(values).all() for values in (*numbers, *window.notes.values(), *residuals))


def _sources(component: str, block: Block) -> list[_Source]:
    """List the columns of a component: outputs, then inputs, each by type."""
    return [
        _Source(
            Column(
                Port(component, variable.name),
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


_ENDING = "_active"


def find_guards(system: System, descriptions: Mapping[str, Description]) -> tuple[Port, ...]:
    """Return the guards: those the system names, or else all Boolean outputs that end in ``_active``.

    Raises
    ------
    SystemDefinitionError
        If the system names something that is not a Boolean output.
    """
    outputs = [
        Port(name, variable.name)
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


class LateWatch:
    """Notes how far the ends of connections lie apart that an algorithm which closes loops does not iterate.

    Parameters
    ----------
    connections : sequence of Connection
        Those that pass what does not change continuously.
    loops : sequence of Loop
        The algebraic loops of the system.
    descriptions : mapping of str to Description
        By name of component.
    """

    def __init__(
        self, connections: Sequence[Connection], loops: Sequence[Loop], descriptions: Mapping[str, Description]
    ) -> None:
        self._kinds: dict[Connection, tuple[BaseType, BaseType]] = {}
        self._conversions: dict[Connection, Conversion | None] = {}
        self._found: dict[str, dict[str, Any]] = {}
        for connection in connections:
            source, target = (
                descriptions[port.component].by_name[port.variable] for port in (connection.source, connection.target)
            )
            if "String" in (source.type, target.type):
                continue
            self._kinds[connection] = base_type(source), base_type(target)
            self._conversions[connection] = conversion_of(connection, descriptions)
            loop = next((str(loop) for loop in loops if connection.target in loop.variables), None)
            self._found[_arrow(connection)] = {"loop": loop, "largest_difference": 0.0, "time": None}

    def take(self, window: Window) -> None:
        """Compare both ends at the end of each step."""
        for connection, (kind, target_kind) in self._kinds.items():
            source, target = connection.source, connection.target
            given = _column(window.blocks[source.component].outputs[kind], source)
            conversion = self._conversions[connection]
            given = given if conversion is None else conversion.of_all(given)
            taken = _column(window.blocks[target.component].inputs[target_kind], target)
            apart = np.nan_to_num(np.abs(given - taken)[1:], nan=0.0, posinf=np.inf)
            found = self._found[_arrow(connection)]
            if apart.size and apart.max() > found["largest_difference"]:
                found["largest_difference"] = float(apart.max())
                found["time"] = float(window.times[1 + int(np.argmax(apart))])

    def summary(self) -> dict[str, dict[str, Any]]:
        """Return by connection the loop it is in, if any, the largest difference, and when it was first so large, s."""
        return {name: dict(found) for name, found in self._found.items()}

    def restore(self, summary: Mapping[str, Mapping[str, Any]]) -> None:
        """Go on from what was noted."""
        self._found = {name: dict(summary.get(name, found)) for name, found in self._found.items()}


def _arrow(connection: Connection) -> str:
    """Name a connection."""
    return f"{connection.source} -> {connection.target}"


def _column(section: Section, port: Port) -> FloatArray:
    """Return the values of a variable as real numbers."""
    return section.values[:, section.column(port.variable)].astype(np.float64)


Line = tuple[FloatArray, FloatArray]
"""Values at the beginnings and ends of steps."""


@dataclass
class EnergyAccount:
    """Sum up what has happened across a bond so far.

    Attributes
    ----------
    bond : Bond
        Of the system that is run.
    discrete : tuple of Port
        Its values that do not change continuously, and are taken to go on straight lines all the same.
    sum, absolute : float
        Of the residuals, and of their absolute values, J.
    exchanged : float
        Energy taken in over all steps, each counted as positive, J.
    """

    bond: Bond
    discrete: tuple[Port, ...] = ()
    sum: float = 0.0
    absolute: float = 0.0
    exchanged: float = 0.0

    def take(self, window: Window) -> FloatArray:
        """Account for a window; return the energy made in the step that led to each row, 0 for the first [J]."""
        sizes = np.diff(window.times)
        effort = _output(self.bond.output, window)
        taken = self.bond.factor * _integral(_input(self.bond.input, window, sizes), effort, sizes)
        given = self._given(window, effort, sizes)
        residual = taken - given
        self.sum += float(residual.sum())
        self.absolute += float(np.abs(residual).sum())
        self.exchanged += float(np.abs(taken).sum())
        return np.concatenate([[0.0], residual])

    def _given(self, window: Window, effort: Line, sizes: FloatArray) -> FloatArray:
        """Return the energy that the source gives in each step [J]."""
        bond, source = self.bond, _output(self.bond.source, window)
        if bond.back is not None:
            factor = bond.factor if bond.given_factor is None else bond.given_factor
            return factor * _integral(source, _input(bond.back, window, sizes), sizes)
        if bond.conversion is not None:
            first, last = map(bond.conversion.of_all, source)
            source = first, last
        return bond.factor * _integral(source, effort, sizes)

    def summary(self) -> dict[str, Any]:
        """Return the sums [J], and what is not as the account takes it to be, if anything."""
        sums = {"sum": self.sum, "absolute": self.absolute, "exchanged": self.exchanged}
        return {**sums, "discrete": [str(port) for port in self.discrete]} if self.discrete else sums

    def restore(self, summary: Mapping[str, Any]) -> None:
        """Go on from sums."""
        self.sum, self.absolute, self.exchanged = (summary[name] for name in ("sum", "absolute", "exchanged"))


def _discrete(bond: Bond, descriptions: Mapping[str, Description]) -> tuple[Port, ...]:
    """Return the values of a bond that do not change continuously."""
    ports = [port for port in (bond.source, bond.input, bond.output, bond.back) if port is not None]
    return tuple(port for port in ports if not descriptions[port.component].by_name[port.variable].is_continuous)


def _integral(first: Line, second: Line, sizes: FloatArray) -> FloatArray:
    """Integrate the product of two straight lines over each step."""
    (a, b), (c, d) = first, second
    return sizes / 6.0 * (2.0 * a * c + a * d + b * c + 2.0 * b * d)


def _output(port: Port, window: Window) -> Line:
    """Return an output at both ends of each step."""
    section = window.blocks[port.component].outputs["Real"]
    values = section.values[:, section.column(port.variable)].astype(np.float64)
    return values[:-1], values[1:]


def _input(port: Port, window: Window, sizes: FloatArray) -> Line:
    """Return an input at both ends of each step: it ends where it is recorded, and came there with its slope."""
    block = window.blocks[port.component]
    section, slopes = block.inputs["Real"], block.slopes
    index = section.column(port.variable)
    ends = section.values[1:, index].astype(np.float64)
    column = None if slopes is None else slopes.column(int(section.references[index]))
    return (ends if slopes is None or column is None else ends - sizes * slopes.values[1:, column]), ends
