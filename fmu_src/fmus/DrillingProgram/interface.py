"""The interface table of DrillingProgram: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import (
    BIT_RADIUS,
    FRICTION,
    SLIPPING,
    drive_terminal,
    output_row,
    parameter_row,
    references_terminal,
    weight_terminal,
)
from ...schema import Model, Variable
from . import page


def _profile(signal: str, unit: str, start: float, low: float, high: float, what: str) -> tuple[Variable, ...]:
    return (
        parameter_row(f"{signal}_initial", unit, start, low, high, f"{what} before the change", "model 21"),
        parameter_row(f"{signal}_final", unit, start, low, high, f"{what} after the change", "model 21"),
        parameter_row(
            f"{signal}_start", "s", 0.0, -1e9, 1e9, f"Time at which the {signal} begins to change", "model 21"
        ),
        parameter_row(f"{signal}_duration", "s", 0.0, 0.0, 1e9, "Duration of the change; 0 is a step", "model 21"),
    )


_TABLED = ("table", "speed_initial", "speed_final", "speed_start", "speed_duration")
_TABLED_WOB = ("table", "WOB_initial", "WOB_final", "WOB_start", "WOB_duration")

MODEL = Model(
    name="DrillingProgram",
    description="What the driller asks for over time: rotation, weight on bit, and the references that go with them",
    variables=(
        output_row("Omega", "rad/s", "Rotation asked for, as the drive speed", "model 21", initially=_TABLED),
        output_row("WOB", "N", "Weight on bit asked for", "model 21", initially=_TABLED_WOB),
        output_row("speed_ref", "rad/s", "Rotation asked for, as the reference of a speed law", "model 21", initially=_TABLED),
        output_row("bit_speed_ref", "rad/s", "Rotation asked for, as the reference of the bit", "model 21", initially=_TABLED),
        output_row(
            "bit_torque_ref", "N.m", "Torque on bit (3)-(4) at the rotation and weight asked for", "Eq. (3)",
            initially=(*_TABLED, *_TABLED_WOB[1:], *SLIPPING),
        ),
        *_profile("speed", "rad/s", 10.0, -1e4, 1e4, "Rotation"),
        *_profile("WOB", "N", 97347.0, 0.0, 1e8, "Weight on bit"),
        Variable(
            "table", "parameter",
            "CSV file with columns time, speed, WOB that replaces both changes: straight lines between rows, a jump "
            "where two rows share a time, the last row kept; empty: none", "String", "fixed", start="", equation="model 21",
        ),
        FRICTION[0],
        BIT_RADIUS,
        *FRICTION[1:],
    ),
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(drive_terminal("Omega"), weight_terminal("WOB"), references_terminal("speed_ref", "bit_speed_ref", "bit_torque_ref")),
)  # fmt: skip
