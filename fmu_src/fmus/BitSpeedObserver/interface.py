"""The interface table of BitSpeedObserver: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import NOT_IN_THE_PAPER, STRING, drive_terminal, flag_row, input_row, parameter_row, sampled_row
from ...schema import Model
from . import page

_TOP = ("top_speed", "top_torque")

MODEL = Model(
    name="BitSpeedObserver",
    description="Bit speed and torque from speed and torque at the top of the string, one travel time late",
    variables=(
        input_row("top_speed", "rad/s", 0.0, "Angular velocity of the top of the string", "cures 19"),
        input_row("top_torque", "N.m", 0.0, "Torque of the drive on the string", "cures 19", low=-1e8, high=1e8),
        sampled_row("bit_speed", "rad/s", "Angular velocity of the bit a travel time ago", "cures 19", needs=_TOP, initially=_TOP[:1]),
        sampled_row("string_torque", "N.m", "Torque of the string on the bit a travel time ago", "cures 20", needs=_TOP, initially=_TOP[1:]),
        sampled_row("bit_torque", "N.m", "Torque on bit a travel time ago, filtered", "cures 21", needs=_TOP, initially=_TOP[1:]),
        flag_row("valid", "The history is known, and no jump is near", "cures 22", _TOP, ()),
        *STRING,
        parameter_row("filter_time", "s", 0.02, 1e-4, 1e3, f"Time constant of the filter of the torque on bit ({NOT_IN_THE_PAPER})", "cures 21"),
        parameter_row("jump", "rad/s", 1e-8, 0.0, 1e3, f"Changes of a wave in a step that are smaller are no jumps ({NOT_IN_THE_PAPER})", "cures 22"),
    ),
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(drive_terminal("top_speed", "top_torque"),),
)  # fmt: skip
