"""The interface table of SpeedPid: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import (
    NOT_IN_THE_PAPER,
    STRING,
    choice_row,
    enabled_row,
    flag_row,
    input_row,
    output_row,
    parameter_row,
    references_terminal,
    rotor_terminal,
)
from ...schema import Model
from . import page

_STARTS = ("torque_initial", "torque_min", "torque_max")

MODEL = Model(
    name="SpeedPid",
    description="PI and PID control of the rotor's speed, stiff or tuned to stick-slip",
    variables=(
        input_row("speed_ref", "rad/s", 10.0, "Rotation asked for", "cures 14", low=-1e4, high=1e4),
        input_row("Omega", "rad/s", 10.0, "Angular velocity of the rotor", "cures 15", low=-1e4, high=1e4),
        enabled_row("Whether the gains of the mode act; if not, those of an ordinary drive", "cures 16"),
        output_row("motor_torque", "N.m", "Torque asked of the motor", "cures 15", needs=("Omega",), initially=_STARTS),
        flag_row("limit_active", "motor_torque is held at its limit", "cures 17", ("Omega",), _STARTS),
        choice_row("mode", "Gains tuned to stick-slip or stiff, by formula, or K_p, K_i and K_d", "cures 16", "tuned", "stiff", "own"),
        *STRING,
        parameter_row("J_r", "kg.m2", 2900.0, 1.0, 1e6, f"Inertia of the rotor ({NOT_IN_THE_PAPER})", "cures 16"),
        parameter_row("K_p", "N.m.s/rad", 1200.0, 0.0, 1e8, f"Proportional gain; mode own ({NOT_IN_THE_PAPER})", "cures 15"),
        parameter_row("K_i", "N.m/rad", 18000.0, 0.0, 1e8, f"Integral gain; mode own ({NOT_IN_THE_PAPER})", "cures 15"),
        parameter_row("K_d", "N.m.s2/rad", 0.0, 0.0, 1e8, f"Derivative gain; mode own ({NOT_IN_THE_PAPER})", "cures 15"),
        parameter_row("filter_time", "s", 0.05, 1e-4, 1e3, f"Time constant of the filter of the derivative part ({NOT_IN_THE_PAPER})", "cures 15"),
        parameter_row("rate_limit", "rad/s2", 2.0, 1e-3, 1e6, f"Greatest change of the set point ({NOT_IN_THE_PAPER})", "cures 14"),
        parameter_row("torque_initial", "N.m", 0.0, -1e8, 1e8, "Torque at the start", "cures 15"),
        parameter_row("torque_min", "N.m", 0.0, -1e8, 1e8, f"Least torque ({NOT_IN_THE_PAPER})", "cures 17", "tunable"),
        parameter_row("torque_max", "N.m", 6e4, -1e8, 1e8, f"Greatest torque ({NOT_IN_THE_PAPER})", "cures 17", "tunable"),
    ),
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(rotor_terminal("motor_torque", "Omega"), references_terminal("speed_ref", "enabled")),
)  # fmt: skip
