"""How rows of the interface tables are written: the units there are, and one function for each kind of row."""

from __future__ import annotations

from math import pi

from .schema import DisplayUnit, Unit, Value, Variability, Variable

UNITS: tuple[Unit, ...] = (
    Unit("1"),
    Unit("rad", rad=1, display=(DisplayUnit("rev", 0.5 / pi), DisplayUnit("deg", 180.0 / pi))),
    Unit("rad/s", rad=1, s=-1, display=(DisplayUnit("rev/min", 30.0 / pi),)),
    Unit("s", s=1, display=(DisplayUnit("ms", 1e3),)),
    Unit("m", m=1),
    Unit("m4", m=4),
    Unit("kg.m", kg=1, m=1),
    Unit("kg.m2", kg=1, m=2),
    Unit("N", kg=1, m=1, s=-2, display=(DisplayUnit("kN", 1e-3),)),
    Unit("N.m", kg=1, m=2, s=-2, display=(DisplayUnit("kN.m", 1e-3),)),
    Unit("J", kg=1, m=2, s=-2, display=(DisplayUnit("kJ", 1e-3),)),
    Unit("Pa", kg=1, m=-1, s=-2, display=(DisplayUnit("GPa", 1e-9),)),
    Unit("N.m.s/rad", kg=1, m=2, s=-1, rad=-1, display=(DisplayUnit("kN.m.s/rad", 1e-3),)),
    Unit("N.s/rad", kg=1, m=1, s=-1, rad=-1, display=(DisplayUnit("kN.s/rad", 1e-3),)),
)

NOMINAL = {"rad/s": 10.0, "N.m": 1e4, "N": 1e5, "rad": 100.0, "J": 1e5, "s": 1.0}
DISPLAY = {"rad/s": "rev/min", "N.m": "kN.m", "N": "kN", "J": "kJ", "rad": "rev"}


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
