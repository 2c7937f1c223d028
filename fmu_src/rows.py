"""Write rows of the interface tables: units, one function for each kind of row, and what tables share.

"Eq. (n)" is an equation of Saldivar et al. (2011); "model n" is a numbered equation of docs/model.md.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi

from .schema import DisplayUnit, Model, Terminal, Unit, Value, Variability, Variable

UNITS: tuple[Unit, ...] = (
    Unit("1"),
    Unit("rad", rad=1, display=(DisplayUnit("rev", 0.5 / pi), DisplayUnit("deg", 180.0 / pi))),
    Unit("rad/s", rad=1, s=-1, display=(DisplayUnit("rev/min", 30.0 / pi),)),
    Unit("s", s=1, display=(DisplayUnit("ms", 1e3),)),
    Unit("m", m=1),
    Unit("m/s", m=1, s=-1, display=(DisplayUnit("m/h", 3600.0),)),
    Unit("N/m", kg=1, s=-2),
    Unit("1/(N.rad)", kg=-1, m=-1, s=2, rad=-1),
    Unit("m4", m=4),
    Unit("kg.m", kg=1, m=1),
    Unit("kg.m2", kg=1, m=2),
    Unit("N", kg=1, m=1, s=-2, display=(DisplayUnit("kN", 1e-3),)),
    Unit("N.m", kg=1, m=2, s=-2, display=(DisplayUnit("kN.m", 1e-3),)),
    Unit("J", kg=1, m=2, s=-2, display=(DisplayUnit("kJ", 1e-3),)),
    Unit("N.m.s2/rad", kg=1, m=2, rad=-1),
    Unit("W", kg=1, m=2, s=-3, display=(DisplayUnit("kW", 1e-3),)),
    Unit("rad/s2", rad=1, s=-2),
    Unit("Pa", kg=1, m=-1, s=-2, display=(DisplayUnit("GPa", 1e-9),)),
    Unit("N.m.s/rad", kg=1, m=2, s=-1, rad=-1, display=(DisplayUnit("kN.m.s/rad", 1e-3),)),
    Unit("N.m/rad", kg=1, m=2, s=-2, rad=-1, display=(DisplayUnit("kN.m/rad", 1e-3),)),
    Unit("N.s/rad", kg=1, m=1, s=-1, rad=-1, display=(DisplayUnit("kN.s/rad", 1e-3),)),
)

NOMINAL = {"rad/s": 10.0, "N.m": 1e4, "N": 1e5, "rad": 100.0, "J": 1e5, "s": 1.0, "m/s": 1e-3, "m": 100.0}
DISPLAY = {"rad/s": "rev/min", "N.m": "kN.m", "N": "kN", "J": "kJ", "rad": "rev"}

NOT_IN_THE_PAPER = "default not in the paper"


def input_row(
    name: str, unit: str, start: float, text: str, equation: str, *, low: float = -1e6, high: float = 1e6
) -> Variable:  # fmt: skip
    """Return an input."""
    return Variable(
        name, "input", text, unit=unit, display=DISPLAY.get(unit), start=start, minimum=low, maximum=high,
        nominal=NOMINAL[unit], equation=equation,
    )  # fmt: skip


def output_row(
    name: str, unit: str, text: str, equation: str, *, needs: tuple[str, ...] = (), initially: tuple[str, ...] = ()
) -> Variable:
    """Return a Real output; `needs` and `initially` are its dependencies."""
    return Variable(
        name, "output", text, unit=unit, display=DISPLAY.get(unit), nominal=NOMINAL[unit], equation=equation,
        dependencies=needs, initial_dependencies=initially,
    )  # fmt: skip


def enabled_row(text: str, equation: str) -> Variable:
    """Return the Boolean input that switches a law on and off."""
    return Variable("enabled", "input", text, "Boolean", "discrete", start=True, equation=equation)


def choice_row(name: str, text: str, equation: str, *items: str) -> Variable:
    """Return an enumeration among the parameters that starts with its first item."""
    return Variable(name, "parameter", text, "Enumeration", "fixed", start=1, equation=equation, items=items)


def sampled_row(
    name: str, unit: str, text: str, equation: str, *, needs: tuple[str, ...] = (), initially: tuple[str, ...] = ()
) -> Variable:
    """Return a Real output that is held from sample to sample."""
    row = output_row(name, unit, text, equation, needs=needs, initially=initially)
    return replace(row, variability="discrete")


def parameter_row(
    name: str, unit: str, start: Value, low: float, high: float, text: str, equation: str = "",
    variability: Variability = "fixed",
) -> Variable:  # fmt: skip
    """Return a Real parameter."""
    return Variable(
        name, "parameter", text, variability=variability, unit=unit, start=start, minimum=low, maximum=high,
        equation=equation,
    )  # fmt: skip


def flag_row(name: str, text: str, equation: str, needs: tuple[str, ...], initially: tuple[str, ...]) -> Variable:
    """Return a Boolean output."""
    return Variable(
        name,
        "output",
        text,
        "Boolean",
        "discrete",
        equation=equation,
        dependencies=needs,
        initial_dependencies=initially,
    )


def count_row(name: str, text: str, equation: str, initially: tuple[str, ...] = ()) -> Variable:
    """Return an Integer output."""
    return Variable(name, "output", text, "Integer", "discrete", equation=equation, initial_dependencies=initially)


def drive_terminal(*members: str) -> Terminal:
    """Return the terminal of the rotary drive, named for its first member."""
    return Terminal("drive", "The speed asked of the rotary drive, and what its law goes by", members, "11 106 127")


def rotor_terminal(*members: str) -> Terminal:
    """Return the terminal of the rotor between motor and string."""
    return Terminal("rotor", "The torque asked of the motor, and how its rotor turns", members, "28 39 51")


def telemetry_terminal(*members: str) -> Terminal:
    """Return the terminal of what is sent from downhole."""
    return Terminal("telemetry", "What is measured downhole, whatever it is", members, "122 81 149")


def weight_terminal(*members: str) -> Terminal:
    """Return the terminal of the weight on bit."""
    return Terminal("weight", "The weight on bit, and what its law goes by", members, "217 119 43")


def references_terminal(*members: str) -> Terminal:
    """Return the terminal of the references."""
    return Terminal("references", "The rotation the laws are to bring about", members, "91 104 117")


STRING = (
    parameter_row("G", "Pa", 79.3e9, 1e6, 1e13, "Shear modulus", "Eq. (1)"),
    parameter_row("J", "m4", 1.19e-5, 1e-12, 1.0, "Geometrical moment of inertia", "Eq. (1)"),
    parameter_row("I", "kg.m", 0.095, 1e-6, 1e4, "Moment of inertia of the pipe per unit length", "Eq. (1)"),
    parameter_row("L", "m", 1172.0, 1.0, 1e5, "Length of the string", "Eq. (1)"),
    parameter_row(
        "I_B", "kg.m2", 89.0, 1e-3, 1e6, f"Inertia of the bottom hole assembly ({NOT_IN_THE_PAPER})", "Eq. (2)"
    ),
)
BIT_RADIUS = parameter_row("R_b", "m", 0.155575, 1e-4, 10.0, "Bit radius", "Eq. (3)")
TOP_DAMPING = parameter_row("c_a", "N.m.s/rad", 2000.0, 1e-3, 1e9, "Damping of the sliding top end", "Eq. (2)")
FRICTION = (
    parameter_row("c_b", "N.m.s/rad", 0.03, 0.0, 1e6, "Viscous damping at the bit", "Eq. (3)", "tunable"),
    parameter_row("mu_cb", "1", 0.5, 0.0, 1.0, "Coulomb friction coefficient", "Eq. (4)", "tunable"),
    parameter_row("mu_sb", "1", 0.8, 0.0, 1.0, "Static friction coefficient, at least mu_cb", "Eq. (4)", "tunable"),
    parameter_row("gamma_b", "1", 0.9, 0.0, 1.0, "Velocity decrease rate of the friction", "Eq. (4)", "tunable"),
    parameter_row("v_f", "rad/s", 1.0, 1e-6, 1e3, "Velocity that makes gamma_b |v| / v_f a number", "Eq. (4)"),
)
SLIPPING = tuple(row.name for row in (FRICTION[0], BIT_RADIUS, *FRICTION[1:]))
"""Parameters of the torque on a bit that turns."""
HOLDING = ("R_b", "mu_sb")
"""Parameters of the torque that holds a bit at rest."""


def drive_law(name: str, description: str, *parameters: Variable) -> Model:
    """Return the table of a law of the drive's speed that derives from `fmu_src.python.switched_law.SwitchedLaw`."""
    ends = ("top_speed", "top_torque", "speed_ref")
    variables = (
        input_row("top_speed", "rad/s", 0.0, "Angular velocity of the top of the string", ""),
        input_row("top_torque", "N.m", 0.0, "Torque of the drive on the string", "", low=-1e8, high=1e8),
        input_row("speed_ref", "rad/s", 10.0, "Rotation asked for", "", low=-1e4, high=1e4),
        enabled_row("Whether the law acts; if not, speed_ref passes through", ""),
        output_row("Omega", "rad/s", "Speed asked of the drive", "", needs=ends, initially=("speed_ref", "Omega_max")),
        flag_row("limit_active", "Omega is held at its limit", "", ends, ("speed_ref", "Omega_max")),
        parameter_row("handover_time", "s", 1.0, 0.0, 1e3, "Time in which a switch takes effect", "", "tunable"),
        parameter_row("Omega_max", "rad/s", 40.0, 1e-3, 1e4, "Limit of Omega in both directions", "", "tunable"),
    )
    terminals = (drive_terminal("Omega", "top_speed", "top_torque"), references_terminal("speed_ref", "enabled"))
    return Model(name, description, (*variables, *parameters), terminals=terminals)
