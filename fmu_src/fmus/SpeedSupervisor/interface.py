"""The interface table of SpeedSupervisor: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import (
    NOT_IN_THE_PAPER,
    enabled_row,
    flag_row,
    input_row,
    parameter_row,
    references_terminal,
    sampled_row,
    telemetry_terminal,
    weight_terminal,
)
from ...schema import Model, Variable
from . import page

MODEL = Model(
    name="SpeedSupervisor",
    description="Supervisor that measures stick-slip downhole and raises the speed by what arrives at the top",
    variables=(
        input_row("bit_speed", "rad/s", 0.0, "Angular velocity of the bit, downhole", "cures 29"),
        Variable("measured", "input", "Severity that has arrived at the top", variability="discrete", unit="1", start=0.0, minimum=-1e9, maximum=1e9, nominal=1.0, equation="cures 30"),
        Variable("valid", "input", "Whether that is to be relied on", "Boolean", "discrete", start=True, equation="cures 30"),
        enabled_row("Whether the speed is raised; if not, it stays as it is", "cures 30"),
        Variable("severity", "output", "Severity of stick-slip over the last window; 0 before the first is complete", variability="discrete", unit="1", equation="cures 29"),
        sampled_row("speed_ref", "rad/s", "Rotation asked for", "cures 30", initially=("speed_initial",)),
        flag_row("limit_active", "The speed would be raised beyond its limit", "cures 30", (), ()),
        parameter_row("window", "s", 20.0, 1e-2, 1e5, f"Time over which the severity is taken ({NOT_IN_THE_PAPER})", "cures 29"),
        parameter_row("severity_max", "1", 5.0, 1e-3, 1e6, f"Greatest severity that is told ({NOT_IN_THE_PAPER})", "cures 29"),
        parameter_row("threshold", "1", 0.3, 0.0, 1e6, f"Severity above which the speed is raised ({NOT_IN_THE_PAPER})", "cures 30"),
        parameter_row("interval", "s", 30.0, 1e-2, 1e5, f"Time between decisions ({NOT_IN_THE_PAPER})", "cures 30"),
        parameter_row("speed_step", "rad/s", 1.0, 0.0, 1e3, f"By how much the speed is raised ({NOT_IN_THE_PAPER})", "cures 30"),
        parameter_row("speed_initial", "rad/s", 10.0, -1e4, 1e4, f"Speed asked for at the start ({NOT_IN_THE_PAPER})", "cures 30"),
        parameter_row("speed_max", "rad/s", 20.0, -1e4, 1e4, f"Greatest speed asked for, at least speed_initial ({NOT_IN_THE_PAPER})", "cures 30"),
    ),
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(
        weight_terminal("bit_speed"),
        telemetry_terminal("severity", "measured", "valid"),
        references_terminal("speed_ref", "enabled"),
    ),
)  # fmt: skip
