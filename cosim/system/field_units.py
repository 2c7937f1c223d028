"""Units of the field, and tables of values in them turned into the units that variables declare.

Factors are those of NIST SP 811 (2008), Appendix B.8, exact where it says so: 1 lbf = 4.4482216152605 N, 1 ft =
0.3048 m, 1 US gal = 3.785411784e-3 m^3. A ton-force is not among them, since there are three.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from dataclasses import replace

from cosim.errors import SystemDefinitionError
from cosim.system.description import Description, Match, Unit, Variable, compare, converted, describe
from cosim.system.signals import Table
from cosim.system.structure import Port, System

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
        kips=1e3 * _LBF, kip=1e3 * _LBF, kgf=9.80665, tf=9806.65,
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


def in_declared_units(system: System, descriptions: Mapping[str, Description]) -> System:
    """Return a system whose tables hold values in the units that the inputs declare.

    Raises
    ------
    SystemDefinitionError
        If a table is in a unit that is not known here, or of another kind than that of the input.
    """
    inputs = {port: signal for port, signal in system.inputs.items() if isinstance(signal, Table) and signal.unit}
    known = {
        port: descriptions[port.component].by_name[port.variable]
        for port in inputs
        if port.variable in descriptions[port.component].by_name
    }
    if not known:
        return system
    changed = {port: _converted(port, inputs[port], variable) for port, variable in known.items()}
    return replace(system, inputs={**system.inputs, **changed})


def _converted(port: Port, table: Table, variable: Variable) -> Table:
    """Return a table in the unit that its input declares, and say so."""
    declared = variable.measured_in
    if declared is None:
        log.warning("%s declares no unit; the values of the table in %s are taken as they are", port, table.unit)
        return replace(table, unit="")
    if table.unit == declared.name:
        return replace(table, unit="")
    source = field_unit(table.unit)
    target = declared if declared.powers is not None else field_unit(declared.name)
    if source is None or target is None:
        what = f"which is no unit known here; expected one that is, or a factor to {declared.name}"
        if source is not None:
            what = f"and it is not known what {declared.name} is; expected a factor to it, or no unit"
        raise SystemDefinitionError(f"{port}: the table is in {table.unit}, {what}")
    if compare(source, target) is Match.DIFFERENT:
        raise SystemDefinitionError(f"{port}: the table is in {describe(source)}; expected {describe(target)}")
    log.info("%s: the table is in %s, and is converted to %s", port, table.unit, declared.name)
    if variable.relative:
        source, target = source.of_differences, target.of_differences
    return Table(table.times, tuple(converted(point, source, target) for point in table.points))
