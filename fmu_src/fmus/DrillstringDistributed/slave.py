"""The plant with damping along the string as a pythonfmu slave over `models.plant.distributed`."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from fmu_src.fmus.DrillstringDistributed.interface import MODEL, MOST_STATIONS
from fmu_src.python.plant import MOST_CELLS, PlantSlave
from models.plant.clock import BLOCK
from models.plant.distributed import DrillstringDistributed as Plant
from models.plant.neutral import InitialState
from models.plant.parameters import DistributedParameters
from models.plant.station import StationOutputs


class DrillstringDistributed(PlantSlave[Plant]):
    """The drillstring with damping along its length, and stations on it."""

    model = MODEL
    kind = Plant

    def build(self, named: dict[str, Any], initial: InitialState, time: float) -> Plant:
        """Return the plant at a time [s]."""
        parameters = DistributedParameters(**{field.name: named[field.name] for field in fields(DistributedParameters)})
        cells = int(named["cells"])
        self.require_cells(parameters, cells)
        damping = BLOCK * parameters.damping_blocks
        if damping > MOST_CELLS:
            raise ValueError(
                f"the damping asks for {damping:.3g} cells; expected at most 1e7: set a lower beta or a shorter L"
            )
        stations = int(named["stations"])
        used = parameters.cells_for(cells)
        self.require_affordable(parameters, parameters.blocks_for(used, stations), used)
        return Plant(parameters, initial, cells, time, named["Omega"], named["WOB"], stations)

    def write(self, values: list[Any]) -> None:
        """Write the outputs; those of stations that are not there are zero."""
        super().write(values)
        values[self.at["string_loss"]] = self.plant.loss_along_string()
        read = self.plant.station_outputs()
        read += [StationOutputs(0.0, 0.0, 0.0)] * (MOST_STATIONS - len(read))
        for number, station in enumerate(read, start=1):
            for name, value in zip(StationOutputs._fields, station, strict=True):
                values[self.at[f"station_{number}_{name}"]] = value
