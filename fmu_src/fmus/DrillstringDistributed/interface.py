"""The interface table of DrillstringDistributed: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import NOT_IN_THE_PAPER, drive_terminal, output_row, parameter_row, weight_terminal
from ...schema import Model, Variable
from ..DrillstringNeutral.interface import PLANT_INPUTS, plant_outputs, plant_parameters
from . import page

MOST_STATIONS = 9


def _station(number: int) -> tuple[Variable, ...]:
    place = f"station {number}; 0 if there are fewer"
    needs = ("stations", "initial_torque", "beta", "L")
    return (
        output_row(f"station_{number}_speed", "rad/s", f"Angular velocity at {place}", "Eq. (1)", initially=("stations", "initial_speed")),
        output_row(f"station_{number}_torque", "N.m", f"Torque the string transmits at {place}", "Eq. (1)", initially=(*needs, "initial_speed")),
        output_row(f"station_{number}_twist", "rad", f"Twist of the string above {place}", "Eq. (1)", initially=(*needs, "initial_speed", "G", "J")),
    )  # fmt: skip


MODEL = Model(
    name="DrillstringDistributed",
    description="Torsion of an oilwell drillstring, damped along its length, with set-valued bit friction and stations",
    variables=(
        *PLANT_INPUTS,
        *plant_outputs("beta", "L"),
        output_row("string_loss", "J", "Energy lost along the string since the start", "Eq. (8)"),
        *(variable for number in range(1, MOST_STATIONS + 1) for variable in _station(number)),
        *plant_parameters("Torque in the string at the bit before the start"),
        parameter_row("beta", "N.s/rad", 0.0, 0.0, 1e4, f"Damping of the string per unit length ({NOT_IN_THE_PAPER})", "Eq. (1)"),
        Variable(
            "stations", "parameter", "Stations between top and bit, which divide the string into equal parts", "Integer",
            "fixed", start=2, minimum=0, maximum=MOST_STATIONS, equation="model 27",
        ),
    ),
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(drive_terminal("Omega", "top_speed", "bit_speed", "top_torque"), weight_terminal("WOB", "bit_speed")),
)  # fmt: skip
