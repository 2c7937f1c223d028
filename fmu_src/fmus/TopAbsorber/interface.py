"""The interface table of TopAbsorber: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import NOT_IN_THE_PAPER, choice_row, drive_terminal, parameter_row, references_terminal
from ...schema import Model
from ..SoftTorque.interface import virtual_drive_rows
from . import page

_INPUTS, _OUTPUTS, _PARAMETERS = virtual_drive_rows(0.08)

MODEL = Model(
    name="TopAbsorber",
    description="Drive speed law that makes the drive a table on spring and damper, tuned to stick-slip",
    variables=(
        *_INPUTS,
        *_OUTPUTS,
        *_PARAMETERS,
        choice_row("mode", "Table tuned by formula, or c_f, k_f and J_a", "cures 18", "tuned", "own"),
        parameter_row("c_f", "N.m.s/rad", 450.0, 1e-3, 1e9, f"Damping of the table; mode own ({NOT_IN_THE_PAPER})", "cures 18"),
        parameter_row("k_f", "N.m/rad", 280.0, 0.0, 1e9, f"Stiffness of the table; mode own ({NOT_IN_THE_PAPER})", "cures 18"),
        parameter_row("J_a", "kg.m2", 45.0, 0.0, 1e6, f"Inertia of the table; mode own ({NOT_IN_THE_PAPER})", "cures 18"),
    ),
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(drive_terminal("Omega", "top_speed", "top_torque"), references_terminal("speed_ref", "enabled")),
)  # fmt: skip
