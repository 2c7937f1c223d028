"""The interface table of SoftTorque: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import (
    NOT_IN_THE_PAPER,
    STRING,
    TOP_DAMPING,
    choice_row,
    drive_terminal,
    enabled_row,
    flag_row,
    input_row,
    output_row,
    parameter_row,
    references_terminal,
)
from ...schema import Model, Variable
from . import page


def virtual_drive_rows(
    filter_time: float,
) -> tuple[tuple[Variable, ...], tuple[Variable, ...], tuple[Variable, ...]]:
    """Return the rows of inputs, outputs and parameters that laws have which make the drive a virtual one."""
    ends = ("top_speed", "top_torque", "speed_ref")
    inputs = (
        input_row("top_speed", "rad/s", 0.0, "Angular velocity of the top of the string", "cures 1"),
        input_row("top_torque", "N.m", 0.0, "Torque of the drive on the string", "cures 1", low=-1e8, high=1e8),
        input_row("speed_ref", "rad/s", 10.0, "Rotation asked for", "cures 2", low=-1e4, high=1e4),
        enabled_row("Whether the law acts; if not, speed_ref passes through", "cures 6"),
    )
    outputs = (
        output_row("Omega", "rad/s", "Angular velocity asked of the rotary drive", "cures 4", needs=ends, initially=("speed_ref", "Omega_max")),
        flag_row("limit_active", "Omega is held at its limit", "cures 7", ends, ("speed_ref", "Omega_max")),
    )  # fmt: skip
    parameters = (
        *STRING,
        TOP_DAMPING,
        choice_row("slip", "The string's top turns slower than asked for by its slip torque / c_a, or as asked for", "cures 2", "mean", "compensated"),
        parameter_row("filter_time", "s", filter_time, 0.0, 1e3, f"Time constant T_f of the filter of the wave; 0: none ({NOT_IN_THE_PAPER})", "cures 3"),
        parameter_row("slip_time", "s", 5.0, 1e-3, 1e6, f"Time constant of the filter of the torque for the slip ({NOT_IN_THE_PAPER})", "cures 2"),
        parameter_row("handover_time", "s", 1.0, 0.0, 1e3, f"Time constant with which a switch takes effect ({NOT_IN_THE_PAPER})", "cures 6", "tunable"),
        parameter_row("Omega_max", "rad/s", 40.0, 1e-3, 1e4, f"Limit of Omega in both directions ({NOT_IN_THE_PAPER})", "cures 7", "tunable"),
    )  # fmt: skip
    return inputs, outputs, parameters


_INPUTS, _OUTPUTS, _PARAMETERS = virtual_drive_rows(0.04)

MODEL = Model(
    name="SoftTorque",
    description="Drive speed law that makes the drive soft: soft torque, or impedance matching",
    variables=(
        *_INPUTS,
        *_OUTPUTS,
        *_PARAMETERS,
        choice_row("mode", "Gains of soft torque or of impedance matching, by formula, or P, K and J_v", "cures 5", "soft_torque", "z_torque", "own"),
        parameter_row("P", "N.m.s/rad", 450.0, 1e-3, 1e9, f"Damping the string is to meet; mode own ({NOT_IN_THE_PAPER})", "cures 3"),
        parameter_row("K", "N.m/rad", 188.0, 0.0, 1e9, f"Stiffness the string is to meet; mode own ({NOT_IN_THE_PAPER})", "cures 3"),
        parameter_row("J_v", "kg.m2", 0.0, 0.0, 1e6, f"Inertia the string is to meet; mode own ({NOT_IN_THE_PAPER})", "cures 3"),
    ),
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(drive_terminal("Omega", "top_speed", "top_torque"), references_terminal("speed_ref", "enabled")),
)  # fmt: skip
