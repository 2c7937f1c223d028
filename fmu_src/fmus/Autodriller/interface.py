"""The interface table of Autodriller: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import (
    NOT_IN_THE_PAPER,
    enabled_row,
    flag_row,
    input_row,
    output_row,
    parameter_row,
    references_terminal,
    weight_terminal,
)
from ...schema import Model
from . import page

MODEL = Model(
    name="Autodriller",
    description="Driller that feeds the string so that the weight on bit is as asked for, and the depth drilled",
    variables=(
        input_row("WOB_ref", "N", 97347.0, "Weight on bit asked for", "cures 28", low=0.0, high=1e8),
        input_row("bit_speed", "rad/s", 0.0, "Angular velocity of the bit", "cures 27", low=-1e4, high=1e4),
        enabled_row("Whether the controller feeds; if not, the feed stays as it is", "cures 28"),
        output_row("WOB", "N", "Weight on bit", "cures 26", initially=("WOB_initial",)),
        output_row("rop", "m/s", "Rate of penetration", "cures 27", needs=("bit_speed",), initially=("WOB_initial", "bit_speed", "a", "W_0")),
        output_row("depth", "m", "Depth drilled since the start", "cures 27"),
        flag_row("limit_active", "The feed or the weight is held at a limit", "cures 28", (), ("WOB_initial", "bit_speed", "a", "W_0", "feed_max")),
        parameter_row("k", "N/m", 5.98e5, 1.0, 1e12, f"Stiffness E A / L of the string ({NOT_IN_THE_PAPER})", "cures 26"),
        parameter_row("a", "1/(N.rad)", 4.85e-9, 0.0, 1.0, f"Depth per angle and weight above W_0, in m/(N rad) ({NOT_IN_THE_PAPER})", "cures 27"),
        parameter_row("W_0", "N", 5000.0, 0.0, 1e8, f"Weight from which on the bit drills ({NOT_IN_THE_PAPER})", "cures 27"),
        parameter_row("K_p", "1", 8.361204013377927e-08, 0.0, 1.0, f"Gain in m/(N s), 1 / (20 s k) ({NOT_IN_THE_PAPER})", "cures 28"),
        parameter_row("T_i", "s", 60.0, 1e-3, 1e9, f"Integral time ({NOT_IN_THE_PAPER})", "cures 28"),
        parameter_row("feed_max", "m/s", 0.02, 1e-9, 10.0, f"Greatest feed ({NOT_IN_THE_PAPER})", "cures 28"),
        parameter_row("WOB_max", "N", 3e5, 1.0, 1e8, f"Greatest weight on bit ({NOT_IN_THE_PAPER})", "cures 28"),
        parameter_row("WOB_initial", "N", 0.0, 0.0, 1e8, "Weight on bit at the start", "cures 26"),
        parameter_row("feed_min", "m/s", 0.0, -10.0, 0.0, f"Least feed; less than 0 lifts the string ({NOT_IN_THE_PAPER})", "cures 28"),
    ),
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(weight_terminal("WOB", "bit_speed"), references_terminal("WOB_ref", "enabled")),
)  # fmt: skip
