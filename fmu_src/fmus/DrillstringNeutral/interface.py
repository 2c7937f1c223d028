"""The interface tables: the only place where a variable of an FMU is written down.

modelDescription.xml, the C header, the pythonfmu registration and the documentation page inside each FMU
are all made from these tables. "Eq. (n)" is an equation of Saldivar et al. (2011); "model n" is a numbered
equation of docs/model.md.
"""

from __future__ import annotations

from .page import distributed_page, equations, guide
from .rows import count_row as _count
from .rows import flag_row as _flag
from .rows import input_row as _input
from .rows import output_row as _output
from .rows import parameter_row as _parameter
from .schema import Model, Terminal, Variable

NOT_IN_THE_PAPER = "default not in the paper"

LOG_CATEGORIES: tuple[tuple[str, str], ...] = (
    ("logEvents", "Stops and releases of the bit, guards and limits of the laws, as they happen."),
    ("logStatusWarning", "What limits the worth of the results."),
    ("logStatusDiscard", "Messages that come with fmi2Discard: which variable, its value, the expected range."),
    ("logStatusError", "Messages that come with fmi2Error; they are told always."),
    ("logAll", "All messages."),
)


def _drive(*members: str) -> Terminal:
    return Terminal("drive", "The speed asked of the rotary drive, and what its law goes by", members, "11 106 127")


def _weight(*members: str) -> Terminal:
    return Terminal("weight", "The weight on bit, and what its law goes by", members, "217 119 43")


def _references(*members: str) -> Terminal:
    return Terminal("references", "The rotation the laws are to bring about", members, "91 104 117")


_R_B = _parameter("R_b", "m", 0.155575, 1e-4, 10.0, "Bit radius", "Eq. (3)")
_C_A = _parameter("c_a", "N.m.s/rad", 2000.0, 1e-3, 1e9, "Damping of the sliding top end", "Eq. (2)")
_FRICTION = (
    _parameter("c_b", "N.m.s/rad", 0.03, 0.0, 1e6, "Viscous damping at the bit", "Eq. (3)", "tunable"),
    _parameter("mu_cb", "1", 0.5, 0.0, 1.0, "Coulomb friction coefficient", "Eq. (4)", "tunable"),
    _parameter("mu_sb", "1", 0.8, 0.0, 1.0, "Static friction coefficient, at least mu_cb", "Eq. (4)", "tunable"),
    _parameter("gamma_b", "1", 0.9, 0.0, 1.0, "Velocity decrease rate of the friction", "Eq. (4)", "tunable"),
    _parameter("v_f", "rad/s", 1.0, 1e-6, 1e3, "Velocity that makes gamma_b |v| / v_f a number", "Eq. (4)"),
)
_STRING = (
    _parameter("G", "Pa", 79.3e9, 1e6, 1e13, "Shear modulus", "Eq. (1)"),
    _parameter("J", "m4", 1.19e-5, 1e-12, 1.0, "Geometrical moment of inertia", "Eq. (1)"),
    _parameter("I", "kg.m", 0.095, 1e-6, 1e4, "Moment of inertia of the pipe per unit length", "Eq. (1)"),
    _parameter("L", "m", 1172.0, 1.0, 1e5, "Length of the string", "Eq. (1)"),
    _parameter("I_B", "kg.m2", 89.0, 1e-3, 1e6, f"Inertia of the bottom hole assembly ({NOT_IN_THE_PAPER})", "Eq. (2)"),
)
_WAVE = ("Omega", "G", "J", "I", "c_a", "initial_speed", "initial_torque")
_PLANT_INPUTS = (
    _input("Omega", "rad/s", 10.0, "Angular velocity of the rotary drive", "Eq. (2)", low=-1e4, high=1e4),
    _input("WOB", "N", 97347.0, "Weight on bit", "Eq. (3)", low=0.0, high=1e8),
)


def _plant_outputs(*drag: str) -> tuple[Variable, ...]:
    """Return the outputs of a plant; `drag` are the parameters from which the torque along the string follows."""
    return (
        _output("bit_speed", "rad/s", "Angular velocity of the bit", "Eq. (14)", initially=("initial_speed",)),
        _output("top_speed", "rad/s", "Angular velocity of the top of the string", "Eq. (15)", needs=("Omega",), initially=(*_WAVE, *drag)),
        _output(
            "bit_torque", "N.m", "Torque on bit; the reaction of the rock while the bit is stuck", "Eq. (3)",
            needs=("WOB",), initially=("WOB", "c_b", "R_b", "mu_cb", "mu_sb", "gamma_b", "v_f", "G", "J", "I", "initial_speed", "initial_torque"),
        ),
        _output("top_torque", "N.m", "Torque of the drive on the string, c_a (Omega - top_speed)", "Eq. (2)", needs=("Omega",), initially=(*_WAVE, *drag)),
        _output("bit_angle", "rad", "Angle turned by the bit, 0 at the start", "Eq. (13)"),
        _output("top_angle", "rad", "Angle of the top of the string", "Eq. (13)", initially=("initial_torque", "L", "G", "J", *(("initial_speed", *drag[:1]) if drag else ()))),
        _flag("bit_stuck", "The bit is held by dry friction", "Eq. (3)", (), ("WOB", "R_b", "mu_sb", "initial_speed", "initial_torque")),
        _output("energy", "J", "Energy stored in string and bit, (I L / 2) E of Eq. (7)", "Eq. (7)", initially=("I_B", "L", "G", "J", "I", "initial_speed", "initial_torque", *drag[:1])),
        _output("bit_speed_min", "rad/s", "Least bit speed since the last communication point", "Eq. (14)", initially=("initial_speed",)),
        _output("bit_speed_max", "rad/s", "Greatest bit speed since the last communication point", "Eq. (14)", initially=("initial_speed",)),
        _output("stuck_time", "s", "Time the bit has been stuck since the start", "Eq. (3)"),
        _count("slip_count", "Number of releases of the bit since the start", "Eq. (3)"),
        _output("last_stop_time", "s", "Time of the last stop of the bit; the start time before the first", "Eq. (3)"),
        _output("last_release_time", "s", "Time of the last release of the bit; the start time before the first", "Eq. (3)"),
        _output("work_in", "J", "Integral of top_torque times top_speed since the start", "Eq. (8)"),
        _output("bit_loss", "J", "Integral of bit_torque times bit_speed since the start", "Eq. (8)"),
        _output("drive_work", "J", "Integral of top_torque times Omega since the start", "model 11"),
        _output("top_loss", "J", "Integral of top_torque times (Omega - top_speed) since the start, lost in the sliding", "model 11"),
        _count("cells_used", "Number of cells the travel time is divided into", "model 14", ("cells", "L", "G", "J", "I")),
        _count("breaks_folded", "Number of significant breaks folded into their cell since the start", "model 16"),
        _output("folded_energy", "J", "Energy removed from the waves by folding breaks since the start", "model 16"),
    )  # fmt: skip


def _plant_parameters(torque: str) -> tuple[Variable, ...]:
    """Return the parameters of a plant; `torque` says what its initial torque is."""
    return (
        *_STRING,
        _C_A,
        _FRICTION[0],
        _R_B,
        *_FRICTION[1:],
        _parameter("initial_speed", "rad/s", 0.0, -1e4, 1e4, "Uniform rotation before the start", "model 8"),
        _parameter("initial_torque", "N.m", 0.0, -1e8, 1e8, torque, "model 8"),
        Variable(
            "cells", "parameter", "Cells in one travel time; 0: chosen so that a cell is at most 0.5 ms", "Integer",
            "fixed", start=0, minimum=0, maximum=200000, equation="model 14",
        ),
    )  # fmt: skip


DRILLSTRING_NEUTRAL = Model(
    name="DrillstringNeutral",
    description="Torsion of an oilwell drillstring as a neutral delay system with set-valued bit friction",
    variables=(*_PLANT_INPUTS, *_plant_outputs(), *_plant_parameters("Uniform torque in the string before the start")),
    log_categories=LOG_CATEGORIES,
    use=guide.PLANT_USE,
    equations=equations.PLANT_EQUATIONS,
    limits=equations.PLANT_LIMITS,
    terminals=(_drive("Omega", "top_speed", "bit_speed", "top_torque"), _weight("WOB", "bit_speed")),
)

MOST_STATIONS = 9


def _station(number: int) -> tuple[Variable, ...]:
    place = f"station {number}; 0 if there are fewer"
    needs = ("stations", "initial_torque", "beta", "L")
    return (
        _output(f"station_{number}_speed", "rad/s", f"Angular velocity at {place}", "Eq. (1)", initially=("stations", "initial_speed")),
        _output(f"station_{number}_torque", "N.m", f"Torque the string transmits at {place}", "Eq. (1)", initially=(*needs, "initial_speed")),
        _output(f"station_{number}_twist", "rad", f"Twist of the string above {place}", "Eq. (1)", initially=(*needs, "initial_speed", "G", "J")),
    )  # fmt: skip


DRILLSTRING_DISTRIBUTED = Model(
    name="DrillstringDistributed",
    description="Torsion of an oilwell drillstring, damped along its length, with set-valued bit friction and stations",
    variables=(
        *_PLANT_INPUTS,
        *_plant_outputs("beta", "L"),
        _output("string_loss", "J", "Energy lost along the string since the start", "Eq. (8)"),
        *(variable for number in range(1, MOST_STATIONS + 1) for variable in _station(number)),
        *_plant_parameters("Torque in the string at the bit before the start"),
        _parameter("beta", "N.s/rad", 0.0, 0.0, 1e4, f"Damping of the string per unit length ({NOT_IN_THE_PAPER})", "Eq. (1)"),
        Variable(
            "stations", "parameter", "Stations between top and bit, which divide the string into equal parts", "Integer",
            "fixed", start=2, minimum=0, maximum=MOST_STATIONS, equation="model 27",
        ),
    ),
    log_categories=LOG_CATEGORIES,
    use=distributed_page.USE,
    equations=distributed_page.EQUATIONS,
    limits=distributed_page.LIMITS,
    terminals=(_drive("Omega", "top_speed", "bit_speed", "top_torque"), _weight("WOB", "bit_speed")),
)  # fmt: skip

_LAW_INPUTS = ("top_speed", "bit_speed", "bit_speed_ref", "bit_torque_ref")
_LAW_ALL = (*_LAW_INPUTS, "c_1", "c_2", "c_a", "c_b", "form", "Omega_max", "top_speed_min")

DISSIPATIVE_LAW = Model(
    name="DissipativeLaw",
    description="Drive speed law that keeps the energy of the string from growing, as printed and in tracking form",
    variables=(
        _input("top_speed", "rad/s", 0.0, "Angular velocity of the top of the string", "Eq. (9), model 19"),
        _input("bit_speed", "rad/s", 0.0, "Angular velocity of the bit", "Eq. (9), model 19"),
        _input("bit_speed_ref", "rad/s", 10.0, "Angular velocity the bit is to reach", "Eq. (9), model 19"),
        _input("bit_torque_ref", "N.m", 0.0, "Torque on bit at the wanted speed (tracking form)", "model 19", low=-1e8, high=1e8),
        _output("Omega", "rad/s", "Angular velocity asked of the rotary drive", "Eq. (9)", needs=_LAW_INPUTS, initially=_LAW_ALL),
        _flag("guard_active", "The divisor of the printed form is held at top_speed_min", "model 18", ("top_speed",), ("top_speed", "top_speed_min", "form")),
        _flag("limit_active", "Omega is held at its limit", "model 18", _LAW_INPUTS, _LAW_ALL),
        _parameter("c_1", "1", 0.3, -1e3, 0.999, "Free design parameter, less than 1", "Eq. (9)", "tunable"),
        _parameter("c_2", "1", 2.0, 1e-9, 1e6, "Free design parameter of the printed form, greater than 0", "Eq. (9)", "tunable"),
        _C_A,
        _FRICTION[0],
        Variable(
            "form", "parameter", "The law as printed, or in deviations from the wanted rotation", "Enumeration",
            "fixed", start=1, equation="Eq. (9), model 19", items=("printed", "tracking"),
        ),
        _parameter("Omega_max", "rad/s", 40.0, 1e-3, 1e4, f"Limit of Omega in both directions ({NOT_IN_THE_PAPER})", "model 18", "tunable"),
        _parameter("top_speed_min", "rad/s", 0.01, 1e-9, 1e3, f"Least divisor of the printed form ({NOT_IN_THE_PAPER})", "model 18", "tunable"),
    ),
    step_size=0.001,
    log_categories=LOG_CATEGORIES,
    verdict=guide.DISSIPATIVE_LAW_VERDICT,
    use=guide.DISSIPATIVE_LAW_USE,
    equations=equations.DISSIPATIVE_LAW_EQUATIONS,
    limits=equations.DISSIPATIVE_LAW_LIMITS,
    terminals=(_drive("Omega", "top_speed", "bit_speed"), _references("bit_speed_ref", "bit_torque_ref")),
)  # fmt: skip

WEIGHT_ON_BIT_LAW = Model(
    name="WeightOnBitLaw",
    description="Weight on bit that follows the bit speed",
    variables=(
        _input("bit_speed", "rad/s", 0.0, "Angular velocity of the bit", "Eq. (22)"),
        _output("WOB", "N", "Weight on bit, K_w |bit_speed| + WOB_0, at most WOB_max", "Eq. (22)", needs=("bit_speed",), initially=("bit_speed", "K_w", "WOB_0", "WOB_max")),
        _parameter("K_w", "N.s/rad", 5000.0, 0.0, 1e8, f"Gain ({NOT_IN_THE_PAPER})", "Eq. (22)", "tunable"),
        _parameter("WOB_0", "N", 97347.0, 1e-3, 1e8, "Weight kept at rest, greater than 0", "Eq. (22)", "tunable"),
        _parameter("WOB_max", "N", 300000.0, 1e-3, 1e8, f"Upper limit, at least WOB_0 ({NOT_IN_THE_PAPER})", "model 20", "tunable"),
    ),
    log_categories=LOG_CATEGORIES,
    use=guide.WEIGHT_ON_BIT_LAW_USE,
    equations=equations.WEIGHT_ON_BIT_LAW_EQUATIONS,
    limits=equations.WEIGHT_ON_BIT_LAW_LIMITS,
    terminals=(_weight("WOB", "bit_speed"),),
)  # fmt: skip


def _profile(signal: str, unit: str, start: float, low: float, high: float, what: str) -> tuple[Variable, ...]:
    return (
        _parameter(f"{signal}_initial", unit, start, low, high, f"{what} before the change", "model 21"),
        _parameter(f"{signal}_final", unit, start, low, high, f"{what} after the change", "model 21"),
        _parameter(f"{signal}_start", "s", 0.0, -1e9, 1e9, f"Time at which the {signal} begins to change", "model 21"),
        _parameter(f"{signal}_duration", "s", 0.0, 0.0, 1e9, "Duration of the change; 0 is a step", "model 21"),
    )


_TABLED = ("table", "speed_initial", "speed_final", "speed_start", "speed_duration")
_TABLED_WOB = ("table", "WOB_initial", "WOB_final", "WOB_start", "WOB_duration")

DRILLING_PROGRAM = Model(
    name="DrillingProgram",
    description="What the driller asks for over time: rotation, weight on bit, and the references that go with them",
    variables=(
        _output("Omega", "rad/s", "Rotation asked for, as the drive speed", "model 21", initially=_TABLED),
        _output("WOB", "N", "Weight on bit asked for", "model 21", initially=_TABLED_WOB),
        _output("speed_ref", "rad/s", "Rotation asked for, as the reference of a speed law", "model 21", initially=_TABLED),
        _output("bit_speed_ref", "rad/s", "Rotation asked for, as the reference of the bit", "model 21", initially=_TABLED),
        _output(
            "bit_torque_ref", "N.m", "Torque on bit (3)-(4) at the rotation and weight asked for", "Eq. (3)",
            initially=(*_TABLED, *_TABLED_WOB[1:], "c_b", "R_b", "mu_cb", "mu_sb", "gamma_b", "v_f"),
        ),
        *_profile("speed", "rad/s", 10.0, -1e4, 1e4, "Rotation"),
        *_profile("WOB", "N", 97347.0, 0.0, 1e8, "Weight on bit"),
        Variable(
            "table", "parameter",
            "CSV file with columns time, speed, WOB that replaces both changes: straight lines between rows, a jump "
            "where two rows share a time, the last row kept; empty: none", "String", "fixed", start="", equation="model 21",
        ),
        _FRICTION[0],
        _R_B,
        *_FRICTION[1:],
    ),
    log_categories=LOG_CATEGORIES,
    use=guide.DRILLING_PROGRAM_USE,
    equations=equations.DRILLING_PROGRAM_EQUATIONS,
    limits=equations.DRILLING_PROGRAM_LIMITS,
    terminals=(_drive("Omega"), _weight("WOB"), _references("speed_ref", "bit_speed_ref", "bit_torque_ref")),
)  # fmt: skip

MODELS: dict[str, Model] = {
    model.name: model
    for model in (DRILLSTRING_NEUTRAL, DRILLSTRING_DISTRIBUTED, DISSIPATIVE_LAW, WEIGHT_ON_BIT_LAW, DRILLING_PROGRAM)
}
