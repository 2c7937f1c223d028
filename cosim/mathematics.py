"""The mathematics of strings and bits, under a name that clashes with nobody's.

The folder is called `models`, as many a project's is. So an installation, editable or not, knows it as `cosim.models`
alone (setup.py); a type checker, which reads folders, knows it as `models`. This is the one place that bridges the two.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from cosim.optional import require

if TYPE_CHECKING:
    from models.arrays import BoolArray
    from models.bistability import Bistability
    from models.chart import StabilityChart
    from models.continuation import BranchPoint, input_of
    from models.cycle import peak_speed
    from models.equilibrium import equilibria
    from models.lawful_energy import TopMotion, lawful_angle, lawful_work
    from models.laws import DissipativeLaw
    from models.loop_set import PrintedLoop
    from models.parameters import DrillstringParameters

_HOMES = {
    "Bistability": "bistability",
    "BoolArray": "arrays",
    "BranchPoint": "continuation",
    "DissipativeLaw": "laws",
    "DrillstringParameters": "parameters",
    "PrintedLoop": "loop_set",
    "StabilityChart": "chart",
    "TopMotion": "lawful_energy",
    "equilibria": "equilibrium",
    "input_of": "continuation",
    "lawful_angle": "lawful_energy",
    "lawful_work": "lawful_energy",
    "peak_speed": "cycle",
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
    "equilibria",
    "input_of",
    "lawful_angle",
    "lawful_work",
    "peak_speed",
]


def __getattr__(name: str) -> object:
    """Import a name when it is first asked for: some of these need SciPy, and most users of the master none."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = require(f"cosim.models.{_HOMES[name]}", extra="theory", purpose=f"{name} of the theory")
    return getattr(module, name)
