"""Every model's reference experiments, and where their files are kept."""

from __future__ import annotations

from pathlib import Path

from tests.reference import damped_plant, laws, plant

FOLDER = Path(__file__).parents[2] / "fmu_src" / "reference"
MODELS = {
    "DrillstringNeutral": plant.EXPERIMENTS,
    "DrillstringDistributed": damped_plant.EXPERIMENTS,
    "DissipativeLaw": laws.DISSIPATIVE_LAW,
    "WeightOnBitLaw": laws.WEIGHT_ON_BIT_LAW,
    "DrillingProgram": laws.DRILLING_PROGRAM,
}
