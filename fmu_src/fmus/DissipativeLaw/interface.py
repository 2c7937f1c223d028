"""The interface table of DissipativeLaw: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import (
    FRICTION,
    NOT_IN_THE_PAPER,
    TOP_DAMPING,
    drive_terminal,
    flag_row,
    input_row,
    output_row,
    parameter_row,
    references_terminal,
)
from ...schema import Model, Variable
from . import page

_LAW_INPUTS = ("top_speed", "bit_speed", "bit_speed_ref", "bit_torque_ref")
_LAW_ALL = (*_LAW_INPUTS, "c_1", "c_2", "c_a", "c_b", "form", "Omega_max", "top_speed_min")

MODEL = Model(
    name="DissipativeLaw",
    description="Drive speed law that keeps the energy of the string from growing, as printed and in tracking form",
    variables=(
        input_row("top_speed", "rad/s", 0.0, "Angular velocity of the top of the string", "Eq. (9), model 19"),
        input_row("bit_speed", "rad/s", 0.0, "Angular velocity of the bit", "Eq. (9), model 19"),
        input_row("bit_speed_ref", "rad/s", 10.0, "Angular velocity the bit is to reach", "Eq. (9), model 19"),
        input_row("bit_torque_ref", "N.m", 0.0, "Torque on bit at the wanted speed (tracking form)", "model 19", low=-1e8, high=1e8),
        output_row("Omega", "rad/s", "Angular velocity asked of the rotary drive", "Eq. (9)", needs=_LAW_INPUTS, initially=_LAW_ALL),
        flag_row("guard_active", "The divisor of the printed form is held at top_speed_min", "model 18", ("top_speed",), ("top_speed", "top_speed_min", "form")),
        flag_row("limit_active", "Omega is held at its limit", "model 18", _LAW_INPUTS, _LAW_ALL),
        parameter_row("c_1", "1", 0.3, -1e3, 0.999, "Free design parameter, less than 1", "Eq. (9)", "tunable"),
        parameter_row("c_2", "1", 2.0, 1e-9, 1e6, "Free design parameter of the printed form, greater than 0", "Eq. (9)", "tunable"),
        TOP_DAMPING,
        FRICTION[0],
        Variable(
            "form", "parameter", "The law as printed, or in deviations from the wanted rotation", "Enumeration",
            "fixed", start=1, equation="Eq. (9), model 19", items=("printed", "tracking"),
        ),
        parameter_row("Omega_max", "rad/s", 40.0, 1e-3, 1e4, f"Limit of Omega in both directions ({NOT_IN_THE_PAPER})", "model 18", "tunable"),
        parameter_row("top_speed_min", "rad/s", 0.01, 1e-9, 1e3, f"Least divisor of the printed form ({NOT_IN_THE_PAPER})", "model 18", "tunable"),
    ),
    step_size=0.001,
    verdict=page.VERDICT,
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(drive_terminal("Omega", "top_speed", "bit_speed"), references_terminal("bit_speed_ref", "bit_torque_ref")),
)  # fmt: skip
