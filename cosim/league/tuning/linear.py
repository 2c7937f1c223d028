"""Ask the linear model about laws that come with the package: gains by formula, and the margins of any gains.

It knows no laws of one's own: their gains have no margins.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields

from cosim.drilling import mathematics
from cosim.drilling.mathematics import DrillstringParameters, Follower, Gains, PidGains, RotorTop, VirtualTop
from cosim.fmi2.locate import locate_fmu
from cosim.fmi2.model_description import read_description
from cosim.league.entries import Condition, Law, League
from cosim.league.rig import Rig
from cosim.system.compatibility import start_values
from cosim.system.field_units import in_declared_units
from cosim.system.signals import Value

OWN = "own"
DIGITS = 6
"""Of margins: what NumPy makes of exponentials differs in the last ones from processor to processor."""
NAMES = {
    "SoftTorque": ("P", "K", "J_v"),
    "TopAbsorber": ("c_f", "k_f", "J_a"),
    "SpeedPid": ("K_p", "K_i", "K_d"),
}
"""Gains by FMU, which act in its mode "own"."""
_RATIOS = {"soft_torque": 1.5, "z_torque": 1.0}
"""P / Z by mode of SoftTorque."""


@dataclass(frozen=True)
class Margin:
    """Tell how far a law is from amplifying.

    Attributes
    ----------
    reflection : float
        Greatest part of a wave, of any frequency, that comes back from the top; above 1 it is amplified.
    damping : float
        Rate at which the slowest of the small motions about uniform rotation dies away [1/s]; NaN without rotation.
    """

    reflection: float
    damping: float


@dataclass(frozen=True)
class Settings:
    """Hold the parameters on a rig, enumerations by the names of their items.

    Attributes
    ----------
    law, drive, plant : mapping of str to value
        By name, all that there are.
    """

    law: Mapping[str, Value]
    drive: Mapping[str, Value]
    plant: Mapping[str, Value]


def settings(league: League, law: Law, condition: Condition) -> Settings:
    """Return what law, drive and string are set to under a condition."""
    system = Rig(league, law, condition).scenario.system
    paths = {part.name: locate_fmu(part.fmu, "native", league.folder) for part in system.components}
    described = {name: read_description(path) for name, path in paths.items()}
    found: dict[str, dict[str, Value]] = {}
    for part in in_declared_units(system, described).components:
        given = start_values(part, described[part.name])
        values: dict[str, Value] = {}
        for variable in described[part.name].variables:
            value = given.get(variable, variable.start_value)
            if value is not None:
                items = {number: item for item, number in variable.items.items()}
                values[variable.name] = items.get(int(value), value) if items else value
        found[part.name] = values
    return Settings(found["law"], found["drive"], found["plant"])


def by_formula(model: str, law: Mapping[str, Value]) -> dict[str, Value]:
    """Return the parameters with which a law in mode "own" is what it is by formula; none of a law without modes."""
    if model not in NAMES:
        return {}
    return {"mode": OWN, **dict(zip(NAMES[model], _gains(model, law), strict=True))}


def _gains(model: str, law: Mapping[str, Value]) -> Gains | PidGains:
    """Return the gains that act."""
    mode, string = str(law["mode"]), _top_of_string(law)
    if mode == OWN:
        kind = PidGains if model == "SpeedPid" else Gains
        return kind(*(float(law[name]) for name in NAMES[model]))
    if model == "SoftTorque":
        return mathematics.soft_torque(string, _RATIOS[mode])
    if model == "TopAbsorber":
        return mathematics.absorber(string)
    inertia = float(law["J_r"])
    return mathematics.tuned(string, inertia) if mode == "tuned" else mathematics.stiff(string, inertia)


def _top_of_string(values: Mapping[str, Value]) -> mathematics.TopOfString:
    """Return the string that a law takes its own for."""
    known = [each.name for each in fields(mathematics.TopOfString) if each.name in values]
    return mathematics.TopOfString(**{name: float(values[name]) for name in known})


def _rounded(number: float) -> float:
    """Return a number to the digits that are the same on every processor."""
    return float(f"{number:.{DIGITS}g}")


class LinearModel:
    """A law under a condition, as small motions about uniform rotation.

    Parameters
    ----------
    model : str
        Name of the FMU.
    found : Settings
        What law, drive and string are set to.
    condition : Condition
        Speed and weight.
    """

    def __init__(self, model: str, found: Settings, condition: Condition) -> None:
        names = [each.name for each in fields(DrillstringParameters)]
        self._model, self._found = model, found
        self._string = DrillstringParameters(**{name: float(found.plant[name]) for name in names})
        self._slope = self._slope_at(condition)

    @property
    def known(self) -> bool:
        """Tell whether the linear model knows the law, with this drive."""
        motor = self._model == "SpeedPid"
        return self._model in NAMES and (self._found.drive["mode"] == "torque") == motor

    def margin(self, values: Mapping[str, Value]) -> Margin:
        """Return the margin of a law with these parameters."""
        top = self._top({**self._found.law, **values})
        damping = math.nan
        if self._slope is not None:
            try:
                damping = mathematics.modal_damping(top, self._slope)
            except ArithmeticError:
                damping = -math.inf
        return Margin(_rounded(mathematics.greatest_reflection(top)), _rounded(damping))

    def _slope_at(self, condition: Condition) -> float | None:
        """Return the slope of the torque on bit in uniform rotation; None if there is none."""
        try:
            if self._found.law.get("slip") == "compensated":
                curve = mathematics.TorqueCurve.of(self._string, condition.weight)
                return float(curve.slope(condition.speed))
            return mathematics.running_equilibrium(self._string, condition.speed, condition.weight).slope
        except ValueError:
            return None

    def _top(self, law: Mapping[str, Value]) -> RotorTop | VirtualTop:
        """Return the top of the string."""
        drive = {name: float(value) for name, value in self._found.drive.items() if not isinstance(value, str)}
        delay = drive["delay"] + 0.5 * drive["sample_time"]
        gains = _gains(self._model, law)
        if isinstance(gains, PidGains):
            return RotorTop(self._string, gains, float(law["filter_time"]), drive["J_r"], delay)
        follower = Follower(drive["lag"], delay)
        if self._found.drive["mode"] == "servo":
            follower = Follower(0.0, delay, drive["J_r"], drive["K_p"], drive["K_i"])
        taken = _top_of_string(law)
        times = (float(law[name]) for name in ("filter_time", "slip_time"))
        virtual = mathematics.VirtualDrive(
            taken.impedance, taken.c_a, gains, *times, compensated=law["slip"] == "compensated"
        )
        return VirtualTop(self._string, virtual, follower)
