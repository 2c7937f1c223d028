"""The plant as a pythonfmu slave: values by value reference to and from `models.neutral`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

from fmu_src.interface import DRILLSTRING_NEUTRAL
from fmu_src.python.slave import TableSlave
from models.clock import CELL_LIMIT
from models.neutral import DrillstringNeutral as Plant
from models.neutral import InitialState, Outputs
from models.parameters import DrillstringParameters

_AT = {variable.name: index for index, variable in enumerate(DRILLSTRING_NEUTRAL.variables)}
_PARAMETERS = tuple(field.name for field in fields(DrillstringParameters))
_TUNABLE = ("c_b", "mu_cb", "mu_sb", "gamma_b")
MOST_CELLS = 1e7
MOST_BLOCKS_RUN = 2.0**52
"""Up to here a cell number and a fraction of the cell fit a float."""


class DrillstringNeutral(TableSlave):
    """The drillstring with inputs Omega and WOB."""

    model = DRILLSTRING_NEUTRAL

    def check(self, values: Sequence[Any]) -> str | None:
        """Return what is wrong between the friction coefficients."""
        return self.below(values, "mu_sb", "mu_cb")

    def start(self, values: list[Any], time: float) -> None:
        """Build the plant at rest or in uniform rotation."""
        parameters = DrillstringParameters(**{name: values[_AT[name]] for name in _PARAMETERS})
        cells = int(values[_AT["cells"]])
        if cells == 0 and parameters.travel_time / CELL_LIMIT > MOST_CELLS:
            raise ValueError(
                f"the travel time of the string asks for {parameters.travel_time / CELL_LIMIT:.3g} cells; "
                "expected at most 1e7: set cells or a shorter L"
            )
        initial = InitialState(values[_AT["initial_speed"]], values[_AT["initial_torque"]])
        self.plant = Plant(parameters, initial, cells, time, values[_AT["Omega"]], values[_AT["WOB"]])
        before = (values[_AT["slip_count"]], time, 0)  # a start may be repeated
        self._write(values)
        self._tell_events(values, before, time)

    def step(self, values: list[Any], time: float, end: float) -> None:
        """Advance the plant with the inputs held."""
        plant, clock = self.plant, self.plant.clock
        if (end - clock.start) / clock.block > MOST_BLOCKS_RUN:
            raise ValueError(
                f"the step ends at {end!r} s; expected at most {clock.start + MOST_BLOCKS_RUN * clock.block:.9g} s, "
                f"as far as blocks of {clock.block:.3g} s can be counted"
            )
        friction = {name: values[_AT[name]] for name in _TUNABLE}
        if any(friction[name] != getattr(plant.parameters, name) for name in _TUNABLE):
            plant.set_friction(replace(plant.parameters, **friction))
        plant.set_inputs(values[_AT["Omega"]], values[_AT["WOB"]])
        before = (values[_AT["slip_count"]], values[_AT["last_stop_time"]], values[_AT["breaks_folded"]])
        plant.advance(end)
        self._write(values)
        self._tell_events(values, before, end)

    def _tell_events(self, values: Sequence[Any], before: tuple[int, float, int], end: float) -> None:
        """Say that the bit has stopped or broken loose, in the order of time; of several stops, the last."""
        slip_count, last_stop_time, breaks_folded = before
        events: list[tuple[float, str]] = []
        if values[_AT["slip_count"]] > slip_count:
            sentence = f"the bit breaks loose, release number {values[_AT['slip_count']]}"
            events.append((values[_AT["last_release_time"]], sentence))
        if values[_AT["last_stop_time"]] > last_stop_time:
            events.append((values[_AT["last_stop_time"]], "the bit sticks"))
        for time, sentence in sorted(events):
            self.event(time, sentence)
        if breaks_folded == 0 and values[_AT["breaks_folded"]] > 0:
            self.warning(end, "more breaks are under way than can be kept: the weakest are folded")

    def _write(self, values: list[Any]) -> None:
        for name, value in zip(Outputs._fields, self.plant.outputs(), strict=True):
            values[_AT[name]] = value

    def state(self) -> object:
        """Return the state of the plant, the waves under way included."""
        return self.plant.state()

    def restore(self, state: Any) -> None:
        """Rebuild the plant that was saved."""
        self.plant = Plant.restored(state)
