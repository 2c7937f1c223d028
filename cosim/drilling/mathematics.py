"""Bring the mathematics of strings and bits, under a name that clashes with nobody's.

The folder is called `models`, as many a project's is. So an installation, editable or not, knows it as `cosim.models`
alone (setup.py); a type checker, which reads folders, knows it as `models`. This is the one place that bridges the two.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cosim.errors import require

if TYPE_CHECKING:
    from models.controllers.laws import DissipativeLaw
    from models.plant.parameters import DrillstringParameters
    from models.theory.cycle.bistability import Bistability, bistable_omegas
    from models.theory.cycle.continuation import BranchPoint, input_of
    from models.theory.cycle.cycle import peak_speed
    from models.theory.lawful_energy import TopMotion, lawful_angle, lawful_work
    from models.theory.loop_set import PrintedLoop
    from models.theory.numerics.arrays import BoolArray
    from models.theory.stability.chart import StabilityChart, stability_boundary
    from models.theory.stability.equilibrium import equilibria

_HOMES = {
    "Bistability": "theory.cycle.bistability",
    "BoolArray": "theory.numerics.arrays",
    "BranchPoint": "theory.cycle.continuation",
    "DissipativeLaw": "controllers.laws",
    "DrillstringParameters": "plant.parameters",
    "PrintedLoop": "theory.loop_set",
    "StabilityChart": "theory.stability.chart",
    "TopMotion": "theory.lawful_energy",
    "bistable_omegas": "theory.cycle.bistability",
    "equilibria": "theory.stability.equilibrium",
    "input_of": "theory.cycle.continuation",
    "lawful_angle": "theory.lawful_energy",
    "lawful_work": "theory.lawful_energy",
    "peak_speed": "theory.cycle.cycle",
    "stability_boundary": "theory.stability.chart",
}

__all__ = [
    "Bistability",
    "BoolArray",
    "BranchPoint",
    "DissipativeLaw",
    "DrillstringParameters",
    "PrintedLoop",
    "StabilityChart",
    "TopMotion",
    "bistable_omegas",
    "equilibria",
    "input_of",
    "lawful_angle",
    "lawful_work",
    "peak_speed",
    "stability_boundary",
]


def __getattr__(name: str) -> object:
    """Import a name when it is first asked for: some of these need SciPy, and most users of the master none."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = require(f"cosim.models.{_HOMES[name]}", extra="theory", purpose=f"{name} of the theory")
    return getattr(module, name)
