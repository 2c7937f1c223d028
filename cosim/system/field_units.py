"""Units of the field: values in them turned into the units that variables declare, and shown in figures.

Factors are those of NIST SP 811 (2008), Appendix B.8, exact where it says so: 1 lbf = 4.4482216152605 N, 1 ft =
0.3048 m, 1 US gal = 3.785411784e-3 m^3. A ton-force is not among them, since there are three.
"""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from cosim.errors import InputError, Refusals, SystemDefinitionError, suggestion
from cosim.system.compatibility import convert
from cosim.system.description import Description, Match, Unit, Variable, compare, converted, describe
from cosim.system.signals import Ramp, Signal, Table, Value, plain_value
from cosim.system.staircase import Staircase, levels_of_table
from cosim.system.structure import Component, Port, System

log = logging.getLogger("cosim")

_LBF, _FT, _GALLON, _LB = 4.4482216152605, 0.3048, 3.785411784e-3, 0.45359237
_PSI = _LBF / 0.0254**2


def _units(powers: tuple[int, ...], **factors: float) -> dict[str, tuple[tuple[int, ...], float, float]]:
    """List units of one kind, with their factors; powers are given up to the last that is not 0."""
    padded = (*powers, *(0,) * (8 - len(powers)))
    return {name: (padded, factor, 0.0) for name, factor in factors.items()}


# By names without spaces; powers of kg, m, s, A, K, mol, cd, rad.
_KNOWN: dict[str, tuple[tuple[int, ...], float, float]] = {
    **_units((0, 0, 1), s=1.0, sec=1.0, ms=1e-3, min=60.0, h=3600.0, hr=3600.0, d=86400.0, day=86400.0),
    **_units((0, 1), m=1.0, mm=1e-3, cm=1e-2, km=1e3, ft=_FT, **{"in": 0.0254, "inch": 0.0254}),
    **_units((1,), kg=1.0, lb=_LB, lbm=_LB, g=1e-3, t=1e3),
    **_units(
        (1, 1, -2), N=1.0, kN=1e3, MN=1e6, daN=10.0, kdaN=1e4, lbf=_LBF, klbf=1e3 * _LBF, klb=1e3 * _LBF,
        klbs=1e3 * _LBF, kips=1e3 * _LBF, kip=1e3 * _LBF, kgf=9.80665, tf=9806.65,
    ),
    **_units(
        (1, 2, -2),
        **{
            "N.m": 1.0, "Nm": 1.0, "kN.m": 1e3, "kNm": 1e3, "daN.m": 10.0, "J": 1.0, "kJ": 1e3, "MJ": 1e6,
            "ft.lbf": _FT * _LBF, "ft.lb": _FT * _LBF, "lbf.ft": _FT * _LBF, "lb.ft": _FT * _LBF,
            "kft.lbf": 1e3 * _FT * _LBF, "kft.lb": 1e3 * _FT * _LBF, "klbf.ft": 1e3 * _FT * _LBF,
        },
    ),
    **_units((1, 2, -3), W=1.0, kW=1e3, MW=1e6, hp=550.0 * _FT * _LBF),
    **_units((1, -1, -2), Pa=1.0, kPa=1e3, MPa=1e6, bar=1e5, psi=_PSI, ksi=1e3 * _PSI, atm=101325.0),
    **_units((1, -3), **{"kg/m3": 1.0, "g/cm3": 1e3, "sg": 1e3, "ppg": _LB / _GALLON, "lb/gal": _LB / _GALLON}),
    **_units(
        (0, 1, -1),
        **{"m/s": 1.0, "m/min": 1 / 60, "m/h": 1 / 3600, "m/hr": 1 / 3600, "ft/s": _FT, "ft/min": _FT / 60},
        **{"ft/h": _FT / 3600, "ft/hr": _FT / 3600, "fph": _FT / 3600, "in/s": 0.0254},
    ),
    **_units(
        (0, 3, -1),
        **{"m3/s": 1.0, "m3/min": 1 / 60, "m3/h": 1 / 3600, "L/s": 1e-3, "L/min": 1e-3 / 60, "lpm": 1e-3 / 60},
        **{"gpm": _GALLON / 60, "gal/min": _GALLON / 60},
    ),
    **_units((0, 0, 0, 0, 0, 0, 0, 1), rad=1.0, deg=math.pi / 180, rev=2 * math.pi),
    **_units(
        (0, 0, -1, 0, 0, 0, 0, 1),
        **{"rad/s": 1.0, "deg/s": math.pi / 180, "rpm": math.pi / 30, "r/min": math.pi / 30, "rev/min": math.pi / 30},
    ),
    **_units((0, 0, -1), Hz=1.0),
    **_units((), **{"1": 1.0, "%": 1e-2}),
    "K": ((0, 0, 0, 0, 1, 0, 0, 0), 1.0, 0.0),
    "degC": ((0, 0, 0, 0, 1, 0, 0, 0), 1.0, 273.15),
    "°C": ((0, 0, 0, 0, 1, 0, 0, 0), 1.0, 273.15),
    "degF": ((0, 0, 0, 0, 1, 0, 0, 0), 5 / 9, 459.67 * 5 / 9),
    "°F": ((0, 0, 0, 0, 1, 0, 0, 0), 5 / 9, 459.67 * 5 / 9),
}  # fmt: skip
_IN_ONE_CASE = {name.lower(): name for name in _KNOWN}


def field_unit(name: str) -> Unit | None:
    """Return a unit by its name as the field writes it; None if there is no such unit here.

    Capitals do not matter in a name that is all capitals or has none, as ``RPM`` and ``KLBF``; in ``mPa`` they do.
    """
    plain = name.strip().replace("·", ".").replace("*", ".").replace("-", ".").replace("³", "3").replace("^", "")
    plain = ".".join(plain.split()) if " " in plain else plain
    if plain not in _KNOWN and (plain.isupper() or plain.islower()):
        plain = _IN_ONE_CASE.get(plain.lower(), plain)
    return Unit(name, *_KNOWN[plain]) if plain in _KNOWN else None


_QUANTITY = re.compile(r"\s*((?>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?))\s*([^\s\d.+-].*?)\s*")
"""A number and a unit, as ``120 rpm``; no sign or digit begins a unit."""


def quantity(text: str) -> tuple[float, str] | None:
    """Take a number with a unit apart, as ``120 rpm``; None if a text is none, or is a number alone."""
    found = _QUANTITY.fullmatch(text)
    return (float(found[1]), found[2]) if found else None


def in_unit(text: str, unit: str, what: str) -> float:
    """Return a number with a unit in another one.

    Parameters
    ----------
    text : str
        Such as ``2 min``, or a number alone, which is in the unit already.
    unit : str
        What it is to be in; empty where it is in none.
    what : str
        The name of the value, for messages.

    Raises
    ------
    SystemDefinitionError
        If it is no number, or of another kind, or nobody knows of which.
    """
    found = quantity(text)
    if found is None:
        try:
            return float(text)
        except ValueError:
            ways = f", with a unit or in {unit}" if unit else ""
            raise SystemDefinitionError(f"{what} is '{text}'; expected a number{ways}") from None
    if not unit:
        raise SystemDefinitionError(f"{what} is '{text}', but has no unit; expected a number alone")
    return _in_unit(found[0], found[1], Unit(unit), what, f"'{text}'")


def seconds(given: object, what: str) -> float:
    """Return a time in s: a number, of NumPy or not, or a text with a unit; InputError for anything else."""
    value = plain_value(given)
    if isinstance(value, str):
        return in_unit(value, "s", what)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{what} is {given!r}; expected a number of seconds")
    try:
        return float(value)
    except OverflowError:
        raise InputError(
            f"{what} is an integer of {int(value).bit_length()} bits; expected a number of seconds"
        ) from None


UNITS = ("si", "metric", "field")
"""The ways to show values."""
# Large values are shown in thousands.
_SHOWN: Mapping[str, Mapping[str, str]] = {
    "si": {"N.m": "kN.m", "N": "kN", "J": "kJ", "W": "kW"},
    "metric": {"rad/s": "rpm", "rad": "rev", "N.m": "kN.m", "N": "kN", "J": "kJ", "W": "kW", "m/s": "m/h"},
    "field": {
        "rad/s": "rpm", "rad": "rev", "N": "klbf", "N.m": "kft.lbf", "J": "kJ", "W": "hp", "m": "ft", "m/s": "ft/h",
    },
}  # fmt: skip


def shown_in(unit: str, units: str) -> tuple[str, float]:
    """Return the unit in which values of another are shown to people, and the factor into it.

    Parameters
    ----------
    unit : str
        As a variable declares it; what is not known is shown as it is.
    units : str
        ``"si"``: thousands of N, N.m, J and W; ``"metric"``: the same with rpm; or ``"field"``: rpm, klbf, kft.lbf
        and the like.

    Raises
    ------
    InputError
        If there is no such way.
    """
    if units not in UNITS:
        raise InputError(f"there are no units '{units}'{suggestion(units, UNITS)}")
    shown = _SHOWN[units].get(unit)
    return (unit, 1.0) if shown is None else (shown, _KNOWN[unit][1] / _KNOWN[shown][1])


def in_declared_units(system: System, descriptions: Mapping[str, Description]) -> System:
    """Return a system whose numbers with units, and tables and ramps in units, are in those of their variables.

    Raises
    ------
    SystemDefinitionError
        If one is in a unit that is not known here, or of another kind than that of its variable.
    """
    components, inputs, refusals = list(system.components), dict(system.inputs), Refusals()
    for index, part in enumerate(system.components):
        with refusals.noted():
            components[index] = _with_numbers(part, descriptions[part.name])
    for port, signal in system.inputs.items():
        with refusals.noted():
            variable = descriptions[port.component].by_name.get(port.variable)
            inputs[port] = _signal_in_declared_unit(port, signal, variable)
    refusals.raise_all(SystemDefinitionError)
    return replace(system, components=tuple(components), inputs=inputs)


def _with_numbers(component: Component, description: Description) -> Component:
    """Return a component whose parameters are numbers where they were numbers with units."""
    read = {
        name: in_declared_unit(Port(component.name, name), description.by_name.get(name), value)
        for name, value in component.parameters.items()
    }
    return component if read == component.parameters else replace(component, parameters=read)


def _signal_in_declared_unit(port: Port, given: Signal, variable: Variable | None) -> Signal:
    """Return a signal in the unit that its input declares; of what is not Real, by its levels."""
    if variable is None:
        return given
    signal = given.driving(port, variable)
    if variable.type != "Real":
        return levels_of_table(port, signal) if isinstance(signal, Table) else signal
    if isinstance(signal, Staircase):
        return signal.as_numbers(partial(_number_in_declared_unit, port, variable))
    if isinstance(signal, Table | Ramp):
        return _converted(port, signal, variable) if signal.unit else signal
    if any(isinstance(level, str) for level in signal.levels or ()):
        return signal.with_levels(partial(in_declared_unit, port, variable))
    return signal


def in_declared_unit(port: str, variable: Variable | None, value: Value) -> Value:
    """Return a number with a unit in the unit that its variable declares; anything else as it is."""
    found = quantity(value) if isinstance(value, str) and variable is not None and variable.type == "Real" else None
    if found is None or variable is None:
        return value
    if variable.measured_in is None:
        raise SystemDefinitionError(f"{port} is '{value}', but declares no unit; expected a number alone")
    return _in_unit(*found, variable.measured_in, str(port), f"'{value}'", relative=variable.relative)


def _number_in_declared_unit(port: str, variable: Variable, value: Value) -> float:
    """Return a number, with a unit or not, in the unit that its variable declares; or refuse what is none."""
    return float(convert(str(port), variable, in_declared_unit(port, variable, value)))


def _in_unit(number: float, unit: str, declared: Unit, what: str, value: str, *, relative: bool = False) -> float:
    """Convert a number into a declared unit, of which it may be a difference."""
    if unit == declared.name:
        return number
    return converted(number, *_units_of(unit, declared, f"{what} is {value}", relative=relative))


def _units_of(unit: str, declared: Unit, said: str, *, relative: bool) -> tuple[Unit, Unit]:
    """Return a unit by its name, and one that is declared, if one can be converted into the other.

    What is measured is said in words, for messages; it may be a difference.
    """
    source = field_unit(unit)
    target = declared if declared.powers is not None else field_unit(declared.name)
    if source is None:
        raise SystemDefinitionError(
            f"{said}, and {unit} is no unit known here; expected one that is, or {declared.name}"
        )
    if target is None:
        raise SystemDefinitionError(
            f"{said}, and it is not known what {declared.name} is; expected a value in it, alone"
        )
    if compare(source, target) is Match.DIFFERENT:
        raise SystemDefinitionError(f"{said}, in {describe(source)}; expected {describe(target)}")
    return (source.of_differences, target.of_differences) if relative else (source, target)


def _converted(port: Port, signal: Table | Ramp, variable: Variable) -> Signal:
    """Return a table or ramp in the unit that its input declares, and say so."""
    declared, kind = variable.measured_in, signal.kind
    if declared is None:
        log.warning("%s declares no unit; the values of the %s in %s are taken as they are", port, kind, signal.unit)
        return replace(signal, unit="")
    if signal.unit == declared.name:
        return replace(signal, unit="")
    source, target = _units_of(signal.unit, declared, f"{port} is a {kind}", relative=variable.relative)
    log.info("%s: the %s is in %s, and is converted to %s", port, kind, signal.unit, declared.name)
    if isinstance(signal, Ramp):
        initial, final = (converted(value, source, target) for value in (signal.initial, signal.final))
        return replace(signal, initial=initial, final=final, unit="")
    return Table(signal.times, tuple(converted(point, source, target) for point in signal.points))
