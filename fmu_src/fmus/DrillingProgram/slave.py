"""The driller's program as a pythonfmu slave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from fmu_src.fmus.DrillingProgram.interface import MODEL
from fmu_src.python.slave import TableSlave
from models.controllers.program import Change, Point, Table, read_table
from models.plant.friction import ORDERED, FrictionParameters, torque_on_bit

_FRICTION = tuple(field.name for field in fields(FrictionParameters))


class DrillingProgram(TableSlave):
    """Rotation and weight asked for over time, and the references that go with them."""

    model = MODEL
    table: Table | None = None

    def check(self, values: Sequence[Any]) -> str | None:
        """Return what is wrong between the friction coefficients."""
        return self.below(values, *ORDERED)

    def start(self, values: list[Any], time: float) -> None:
        """Read the table, if there is one, and ask for what it says at the start."""
        path = values[self.at["table"]]
        self.table = read_table(path) if path else None
        self._ask(values, time)

    def step(self, values: list[Any], time: float, end: float) -> None:
        """Ask for what the program says at the end of the step."""
        self._ask(values, end)

    def _ask(self, values: list[Any], time: float) -> None:
        speed = self._point(values, "speed", 1, time).value
        weight = self._point(values, "WOB", 2, time).value
        parameters = FrictionParameters(**{name: values[self.at[name]] for name in _FRICTION})
        for name in ("Omega", "speed_ref", "bit_speed_ref"):
            values[self.at[name]] = speed
        values[self.at["WOB"]] = weight
        values[self.at["bit_torque_ref"]] = torque_on_bit(parameters, weight, speed)

    def _point(self, values: list[Any], signal: str, column: int, time: float) -> Point:
        if self.table is not None:
            return self.table.at(time, column)
        ends = (values[self.at[f"{signal}_{part}"]] for part in ("initial", "final", "start", "duration"))
        return Change(*ends).at(time)

    def state(self) -> object:
        """Return the rows of the table."""
        return None if self.table is None else [list(row) for row in self.table.rows]

    def restore(self, state: Any) -> None:
        """Take the rows of a table over."""
        self.table = None if state is None else Table(tuple((row[0], row[1], row[2]) for row in state))
