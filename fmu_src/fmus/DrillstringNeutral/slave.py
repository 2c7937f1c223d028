"""The plant as a pythonfmu slave over `models.plant.neutral`."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from fmu_src.fmus.DrillstringNeutral.interface import MODEL
from fmu_src.python.plant import PlantSlave
from models.plant.clock import blocks_for
from models.plant.neutral import DrillstringNeutral as Plant
from models.plant.neutral import InitialState
from models.plant.parameters import DrillstringParameters


class DrillstringNeutral(PlantSlave[Plant]):
    """The drillstring without damping along its length."""

    model = MODEL
    kind = Plant

    def build(self, named: dict[str, Any], initial: InitialState, time: float) -> Plant:
        """Return the plant at a time [s]."""
        parameters = DrillstringParameters(**{field.name: named[field.name] for field in fields(DrillstringParameters)})
        cells = int(named["cells"])
        self.require_cells(parameters, cells)
        used = parameters.cells_for(cells)
        self.require_affordable(parameters, blocks_for(used), used)
        return Plant(parameters, initial, cells, time, named["Omega"], named["WOB"])
