"""The interface table of DrillstringNeutral: the only place where a variable of it is written down."""

from __future__ import annotations

from ...rows import (
    BIT_RADIUS,
    FRICTION,
    HOLDING,
    SLIPPING,
    STRING,
    TOP_DAMPING,
    count_row,
    drive_terminal,
    flag_row,
    input_row,
    output_row,
    parameter_row,
    weight_terminal,
)
from ...schema import Model, Variable
from . import page

_WAVE = ("Omega", "G", "J", "I", "c_a", "initial_speed", "initial_torque")
PLANT_INPUTS = (
    input_row("Omega", "rad/s", 10.0, "Angular velocity of the rotary drive", "Eq. (2)", low=-1e4, high=1e4),
    input_row("WOB", "N", 97347.0, "Weight on bit", "Eq. (3)", low=0.0, high=1e8),
)


def plant_outputs(*drag: str) -> tuple[Variable, ...]:
    """Return the outputs of a plant; `drag` are the parameters from which the torque along the string follows."""
    return (
        output_row("bit_speed", "rad/s", "Angular velocity of the bit", "Eq. (14)", initially=("initial_speed",)),
        output_row("top_speed", "rad/s", "Angular velocity of the top of the string", "Eq. (15)", needs=("Omega",), initially=(*_WAVE, *drag)),
        output_row(
            "bit_torque", "N.m", "Torque on bit; the reaction of the rock while the bit is stuck", "Eq. (3)",
            needs=("WOB",), initially=("WOB", *SLIPPING, "G", "J", "I", "initial_speed", "initial_torque"),
        ),
        output_row("top_torque", "N.m", "Torque of the drive on the string, c_a (Omega - top_speed)", "Eq. (2)", needs=("Omega",), initially=(*_WAVE, *drag)),
        output_row("bit_angle", "rad", "Angle turned by the bit, 0 at the start", "Eq. (13)"),
        output_row("top_angle", "rad", "Angle of the top of the string", "Eq. (13)", initially=("initial_torque", "L", "G", "J", *(("initial_speed", *drag[:1]) if drag else ()))),
        flag_row("bit_stuck", "The bit is held by dry friction", "Eq. (3)", (), ("WOB", *HOLDING, "initial_speed", "initial_torque")),
        output_row("energy", "J", "Energy stored in string and bit, (I L / 2) E of Eq. (7)", "Eq. (7)", initially=("I_B", "L", "G", "J", "I", "initial_speed", "initial_torque", *drag[:1])),
        output_row("bit_speed_min", "rad/s", "Least bit speed since the last communication point", "Eq. (14)", initially=("initial_speed",)),
        output_row("bit_speed_max", "rad/s", "Greatest bit speed since the last communication point", "Eq. (14)", initially=("initial_speed",)),
        output_row("stuck_time", "s", "Time the bit has been stuck since the start", "Eq. (3)"),
        count_row("slip_count", "Number of releases of the bit since the start", "Eq. (3)"),
        output_row("last_stop_time", "s", "Time of the last stop of the bit; the start time before the first", "Eq. (3)"),
        output_row("last_release_time", "s", "Time of the last release of the bit; the start time before the first", "Eq. (3)"),
        output_row("work_in", "J", "Integral of top_torque times top_speed since the start", "Eq. (8)"),
        output_row("bit_loss", "J", "Integral of bit_torque times bit_speed since the start", "Eq. (8)"),
        output_row("drive_work", "J", "Integral of top_torque times Omega since the start", "model 11"),
        output_row("top_loss", "J", "Integral of top_torque times (Omega - top_speed) since the start, lost in the sliding", "model 11"),
        count_row("cells_used", "Number of cells the travel time is divided into", "model 14", ("cells", "L", "G", "J", "I")),
        count_row("breaks_folded", "Number of significant breaks folded into their cell since the start", "model 16"),
        output_row("folded_energy", "J", "Energy removed from the waves by folding breaks since the start", "model 16"),
    )  # fmt: skip


def plant_parameters(torque: str) -> tuple[Variable, ...]:
    """Return the parameters of a plant; `torque` says what its initial torque is."""
    return (
        *STRING,
        TOP_DAMPING,
        FRICTION[0],
        BIT_RADIUS,
        *FRICTION[1:],
        parameter_row("initial_speed", "rad/s", 0.0, -1e4, 1e4, "Uniform rotation before the start", "model 8"),
        parameter_row("initial_torque", "N.m", 0.0, -1e8, 1e8, torque, "model 8"),
        Variable(
            "cells", "parameter", "Cells in one travel time; 0: chosen so that a cell is at most 0.5 ms", "Integer",
            "fixed", start=0, minimum=0, maximum=200000, equation="model 14",
        ),
    )  # fmt: skip


MODEL = Model(
    name="DrillstringNeutral",
    description="Torsion of an oilwell drillstring as a neutral delay system with set-valued bit friction",
    variables=(*PLANT_INPUTS, *plant_outputs(), *plant_parameters("Uniform torque in the string before the start")),
    use=page.USE,
    equations=page.EQUATIONS,
    limits=page.LIMITS,
    terminals=(drive_terminal("Omega", "top_speed", "bit_speed", "top_torque"), weight_terminal("WOB", "bit_speed")),
)
