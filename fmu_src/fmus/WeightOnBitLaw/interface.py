"""The interface table of WeightOnBitLaw: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import NOT_IN_THE_PAPER, input_row, output_row, parameter_row, weight_terminal
from ...schema import Model
from . import page

MODEL = Model(
    name="WeightOnBitLaw",
    description="Weight on bit that follows the bit speed",
    variables=(
        input_row("bit_speed", "rad/s", 0.0, "Angular velocity of the bit", "Eq. (22)"),
        output_row("WOB", "N", "Weight on bit, K_w |bit_speed| + WOB_0, at most WOB_max", "Eq. (22)", needs=("bit_speed",), initially=("bit_speed", "K_w", "WOB_0", "WOB_max")),
        parameter_row("K_w", "N.s/rad", 5000.0, 0.0, 1e8, f"Gain ({NOT_IN_THE_PAPER})", "Eq. (22)", "tunable"),
        parameter_row("WOB_0", "N", 97347.0, 1e-3, 1e8, "Weight kept at rest, greater than 0", "Eq. (22)", "tunable"),
        parameter_row("WOB_max", "N", 300000.0, 1e-3, 1e8, f"Upper limit, at least WOB_0 ({NOT_IN_THE_PAPER})", "model 20", "tunable"),
    ),
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(weight_terminal("WOB", "bit_speed"),),
)  # fmt: skip
