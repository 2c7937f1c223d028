"""Do what the slaves of the plants have in common: bring values by name to and from a plant of `models`."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Generic, TypeVar

from models.plant.clock import CELL_LIMIT, blocks_for
from models.plant.friction import ORDERED, TUNABLE
from models.plant.neutral import DrillstringNeutral, InitialState, Outputs
from models.plant.parameters import DrillstringParameters
from models.plant.work import TooMuchWorkError, refusal

from .slave import TableSlave

MOST_CELLS = 1e7
MOST_BLOCKS_RUN = 2.0**52
"""Up to here a cell number and a fraction of the cell fit a float."""


Plant = TypeVar("Plant", bound=DrillstringNeutral)


class PlantSlave(TableSlave, Generic[Plant]):
    """A drillstring with inputs Omega and WOB.

    Attributes
    ----------
    kind : type
        The class of the plant, a class attribute of the subclass.
    plant : DrillstringNeutral
        The plant, once it has been started.
    """

    kind: type[Plant]
    plant: Plant

    @abstractmethod
    def build(self, named: dict[str, Any], initial: InitialState, time: float) -> Plant:
        """Return the plant at a time [s] from all values by name; ValueError with a sentence if it cannot be had."""

    def check(self, values: Sequence[Any]) -> str | None:
        """Return what is wrong between the friction coefficients."""
        return self.below(values, *ORDERED)

    def require_cells(self, parameters: DrillstringParameters, cells: int) -> None:
        """Refuse a string too long for cells that are chosen."""
        if cells == 0 and parameters.travel_time / CELL_LIMIT > MOST_CELLS:
            raise ValueError(
                f"the travel time of the string asks for {parameters.travel_time / CELL_LIMIT:.3g} cells; "
                "expected at most 1e7: set cells or a shorter L"
            )

    def require_affordable(self, parameters: DrillstringParameters, blocks: int, cells: int) -> None:
        """Refuse a string that takes too much work in so many blocks, made for so many cells."""
        problem = refusal(parameters, blocks, blocks_for(cells))
        if problem is not None:
            raise ValueError(problem)

    def start(self, values: list[Any], time: float) -> None:
        """Build the plant at rest or in uniform rotation."""
        named = {name: values[index] for name, index in self.at.items()}
        self.plant = self.build(named, InitialState(named["initial_speed"], named["initial_torque"]), time)
        before = (named["slip_count"], time, 0)  # a start may be repeated
        self.write(values)
        self._tell_events(values, before, time)

    def step(self, values: list[Any], time: float, end: float) -> None:
        """Advance the plant with the inputs held."""
        plant, clock, at = self.plant, self.plant.clock, self.at
        if (end - clock.start) / clock.block > MOST_BLOCKS_RUN:
            raise ValueError(
                f"the step ends at {end!r} s; expected at most {clock.start + MOST_BLOCKS_RUN * clock.block:.9g} s, "
                f"as far as blocks of {clock.block:.3g} s can be counted"
            )
        friction = {name: values[at[name]] for name in TUNABLE}
        tuned: DrillstringParameters | None = None
        if any(friction[name] != getattr(plant.parameters, name) for name in TUNABLE):
            tuned = replace(plant.parameters, **friction)
            self.require_affordable(tuned, plant.blocks, plant.cells)
        before = (values[at["slip_count"]], values[at["last_stop_time"]], values[at["breaks_folded"]])
        kept = plant.keep()
        try:
            if tuned is not None:
                plant.set_friction(tuned)
            plant.set_inputs(values[at["Omega"]], values[at["WOB"]])
            plant.advance(end)
        except TooMuchWorkError:
            kept.put_back()
            raise
        self.write(values)
        self._tell_events(values, before, end)

    def _tell_events(self, values: Sequence[Any], before: tuple[int, float, int], end: float) -> None:
        """Say that the bit has stopped or broken loose, in the order of time; of several stops, the last."""
        slip_count, last_stop_time, breaks_folded = before
        at = self.at
        events: list[tuple[float, str]] = []
        if values[at["slip_count"]] > slip_count:
            sentence = f"the bit breaks loose, release number {values[at['slip_count']]}"
            events.append((values[at["last_release_time"]], sentence))
        if values[at["last_stop_time"]] > last_stop_time:
            events.append((values[at["last_stop_time"]], "the bit sticks"))
        for time, sentence in sorted(events):
            self.event(time, sentence)
        if breaks_folded == 0 and values[at["breaks_folded"]] > 0:
            self.warning(end, "more breaks are under way than can be kept: the weakest are folded")

    def write(self, values: list[Any]) -> None:
        """Write the outputs."""
        for name, value in zip(Outputs._fields, self.plant.outputs(), strict=True):
            values[self.at[name]] = value

    def state(self) -> object:
        """Return the state of the plant, the waves under way included."""
        return self.plant.state()

    def restore(self, state: Any) -> None:
        """Rebuild the plant that was saved."""
        self.plant = self.kind.restored(state)
