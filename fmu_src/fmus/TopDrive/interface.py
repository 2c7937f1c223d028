"""The interface table of TopDrive: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import (
    NOT_IN_THE_PAPER,
    choice_row,
    drive_terminal,
    flag_row,
    input_row,
    output_row,
    parameter_row,
    rotor_terminal,
    sampled_row,
)
from ...schema import Model, Variable
from . import page

_LIMITS = ("torque_min", "torque_max", "power_max")
_ASKED = ("mode", "motor_torque", "top_torque", "Omega_command", *_LIMITS)

MODEL = Model(
    name="TopDrive",
    description="Rotary drive with lag, inertia, limits of torque and power, sampling, delay and noisy sensors",
    variables=(
        input_row("Omega_command", "rad/s", 10.0, "Speed asked for; modes speed and servo", "cures 9", low=-1e4, high=1e4),
        input_row("motor_torque", "N.m", 0.0, "Torque asked for; mode torque", "cures 10", low=-1e8, high=1e8),
        input_row("top_torque", "N.m", 0.0, "Torque of the drive on the string", "cures 10", low=-1e8, high=1e8),
        input_row("top_speed", "rad/s", 0.0, "Angular velocity of the top of the string, for its sensor", "cures 13"),
        output_row("Omega", "rad/s", "Angular velocity of the drive", "cures 9", initially=("Omega_command",)),
        sampled_row("motor_torque_applied", "N.m", "Torque of the motor", "cures 11", initially=_ASKED),
        flag_row("limit_active", "A limit of torque or power holds", "cures 12", (), _ASKED),
        sampled_row("Omega_measured", "rad/s", "Omega as its sensor shows it", "cures 13", initially=("Omega_command",)),
        sampled_row("top_torque_measured", "N.m", "top_torque as its sensor shows it", "cures 13", initially=("top_torque",)),
        sampled_row("top_speed_measured", "rad/s", "top_speed as its sensor shows it", "cures 13", initially=("top_speed",)),
        choice_row("mode", "A speed behind a lag, a rotor with a speed controller, or a rotor alone", "cures 9", "speed", "servo", "torque"),
        parameter_row("lag", "s", 0.02, 0.0, 10.0, f"Time constant; mode speed ({NOT_IN_THE_PAPER})", "cures 9"),
        parameter_row("rate_limit", "rad/s2", 10.0, 1e-3, 1e6, f"Greatest change of speed; modes speed and servo ({NOT_IN_THE_PAPER})", "cures 9"),
        parameter_row("J_r", "kg.m2", 2900.0, 1.0, 1e6, f"Inertia of the rotor; in mode speed at its limits only ({NOT_IN_THE_PAPER})", "cures 10"),
        parameter_row("K_p", "N.m.s/rad", 15000.0, 0.0, 1e8, f"Proportional gain; mode servo ({NOT_IN_THE_PAPER})", "cures 11"),
        parameter_row("K_i", "N.m/rad", 14500.0, 0.0, 1e8, f"Integral gain; mode servo ({NOT_IN_THE_PAPER})", "cures 11"),
        parameter_row("torque_min", "N.m", 0.0, -1e8, 0.0, f"Least torque of the motor ({NOT_IN_THE_PAPER})", "cures 12"),
        parameter_row("torque_max", "N.m", 6e4, 1.0, 1e8, f"Greatest torque of the motor ({NOT_IN_THE_PAPER})", "cures 12"),
        parameter_row("power_max", "W", 8e5, 1.0, 1e9, f"Greatest power of the motor ({NOT_IN_THE_PAPER})", "cures 12"),
        parameter_row("sample_time", "s", 0.01, 5e-4, 10.0, f"Time between samples ({NOT_IN_THE_PAPER})", "cures 13"),
        parameter_row("delay", "s", 0.0, 0.0, 10.0, "Delay of commands, rounded to samples, at most 64", "cures 13"),
        parameter_row("speed_noise", "rad/s", 0.0, 0.0, 1e3, "Standard deviation of measured speeds", "cures 13"),
        parameter_row("torque_noise", "N.m", 0.0, 0.0, 1e6, "Standard deviation of the measured torque", "cures 13"),
        Variable("seed", "parameter", "Seed of the noise", "Integer", "fixed", start=1, minimum=1, maximum=2147483646, equation="cures 13"),
    ),
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(drive_terminal("Omega", "Omega_command", "top_torque", "top_speed"), rotor_terminal("motor_torque", "Omega")),
)  # fmt: skip
