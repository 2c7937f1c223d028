"""Bring the mathematics of strings and bits, under a name that clashes with nobody's.

The folder is called `models`, as many a project's is. So an installation, editable or not, knows it as `cosim.models`
alone (setup.py); a type checker, which reads folders, knows it as `models`. This is the one place that bridges the two.

What takes long shows how far it is, as `cosim.progress` does: `progress` is what is called, or True or False.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from typing import TYPE_CHECKING, Any

from cosim.errors import require
from cosim.progress import Progress, shown

if TYPE_CHECKING:
    from models.controllers.laws import DissipativeLaw
    from models.controllers.speed_pid import PidGains, stiff, tuned
    from models.controllers.virtual_drive import Gains, TopOfString, VirtualDrive, absorber, soft_torque
    from models.plant.parameters import DrillstringParameters
    from models.theory.cycle.bistability import Bistability, bistable_omegas, bistable_wobs
    from models.theory.cycle.continuation import BranchPoint, branch_from, input_of
    from models.theory.cycle.cycle import peak_speed
    from models.theory.lawful_energy import TopMotion, lawful_angle, lawful_work
    from models.theory.loop_set import PrintedLoop
    from models.theory.numerics.arrays import BoolArray
    from models.theory.stability.chart import StabilityChart, stability_boundary, stability_chart
    from models.theory.stability.driven_top import Follower, RotorTop, VirtualTop, greatest_reflection, modal_damping
    from models.theory.stability.equilibrium import equilibria, running_equilibrium
    from models.theory.stability.torque_curve import TorqueCurve

_HOMES = {
    "Bistability": "theory.cycle.bistability",
    "BoolArray": "theory.numerics.arrays",
    "BranchPoint": "theory.cycle.continuation",
    "DissipativeLaw": "controllers.laws",
    "DrillstringParameters": "plant.parameters",
    "Follower": "theory.stability.driven_top",
    "Gains": "controllers.virtual_drive",
    "PidGains": "controllers.speed_pid",
    "PrintedLoop": "theory.loop_set",
    "RotorTop": "theory.stability.driven_top",
    "StabilityChart": "theory.stability.chart",
    "TopMotion": "theory.lawful_energy",
    "TopOfString": "controllers.virtual_drive",
    "TorqueCurve": "theory.stability.torque_curve",
    "VirtualDrive": "controllers.virtual_drive",
    "VirtualTop": "theory.stability.driven_top",
    "absorber": "controllers.virtual_drive",
    "bistable_omegas": "theory.cycle.bistability",
    "bistable_wobs": "theory.cycle.bistability",
    "branch_from": "theory.cycle.continuation",
    "equilibria": "theory.stability.equilibrium",
    "greatest_reflection": "theory.stability.driven_top",
    "input_of": "theory.cycle.continuation",
    "lawful_angle": "theory.lawful_energy",
    "lawful_work": "theory.lawful_energy",
    "modal_damping": "theory.stability.driven_top",
    "peak_speed": "theory.cycle.cycle",
    "running_equilibrium": "theory.stability.equilibrium",
    "soft_torque": "controllers.virtual_drive",
    "stability_boundary": "theory.stability.chart",
    "stability_chart": "theory.stability.chart",
    "stiff": "controllers.speed_pid",
    "tuned": "controllers.speed_pid",
}

__all__ = [
    "Bistability",
    "BoolArray",
    "BranchPoint",
    "DissipativeLaw",
    "DrillstringParameters",
    "Follower",
    "Gains",
    "PidGains",
    "PrintedLoop",
    "RotorTop",
    "StabilityChart",
    "TopMotion",
    "TopOfString",
    "TorqueCurve",
    "VirtualDrive",
    "VirtualTop",
    "absorber",
    "bistable_omegas",
    "bistable_wobs",
    "branch_from",
    "equilibria",
    "greatest_reflection",
    "input_of",
    "lawful_angle",
    "lawful_work",
    "modal_damping",
    "peak_speed",
    "running_equilibrium",
    "soft_torque",
    "stability_boundary",
    "stability_chart",
    "stiff",
    "tuned",
]


_SLOW = {
    "bistable_omegas": "following cycles",
    "bistable_wobs": "following cycles",
    "branch_from": "following cycles",
    "stability_chart": "charting stability",
}
"""What takes long, and what it does meanwhile."""


def __getattr__(name: str) -> object:
    """Import a name when it is first asked for: some of these need SciPy, and most users of the master none."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = require(f"cosim.models.{_HOMES[name]}", extra="theory", purpose=f"{name} of the theory")
    found: object = getattr(module, name)
    return _watched(found, _SLOW[name]) if name in _SLOW and callable(found) else found


@cache
def _watched(function: Callable[..., Any], title: str) -> Callable[..., Any]:
    """Return a function that shows how far it is: the same one each time, so that it can go to other processes."""

    @wraps(function)
    def call(*arguments: Any, progress: Progress | bool | None = None, **keywords: Any) -> Any:
        with shown(progress, title) as told:
            return function(*arguments, **keywords, **({} if told is None else {"progress": told}))

    call.__module__ = __name__
    return call
