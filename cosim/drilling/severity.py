"""Measure how severe stick-slip is at a point of a map, from what the plant itself keeps account of.

Extremes are those within steps, stops and stuck time are known to the instant, so that long steps do not blur them.
Only the torque at the top has no extremes of its own: it is sampled, every tenth of a second.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from cosim.drilling.oscillation import find_stops, stops_per_period
from cosim.system.description import Description
from cosim.system.signals import FloatArray, Value
from cosim.system.structure import System

WINDOW = 20.0
"""So much of the end of a run is measured, s."""
SAMPLING = 0.1
"""Between samples of the torque, s: a quarter of the travel time of the paper's string."""
SWING = 0.5
"""Peak-to-peak bit speed over the window above which a point is unstable, rad/s."""
_NO_SPEED = 1e-9
_NEEDED = (
    "bit_speed_min", "bit_speed_max", "bit_angle", "stuck_time", "last_stop_time", "last_release_time", "slip_count",
    "bit_stuck", "top_torque",
)  # fmt: skip


@dataclass(frozen=True)
class SeverityQuantity:
    """A number of a severity map: name, unit, and what it is."""

    name: str
    unit: str
    text: str


QUANTITIES = (
    SeverityQuantity("ssi", "", "stick-slip index"),
    SeverityQuantity("stuck_fraction", "", "stuck fraction"),
    SeverityQuantity("period", "s", "period of stick-slip"),
    SeverityQuantity("bit_speed_min", "rad/s", "least bit speed"),
    SeverityQuantity("bit_speed_max", "rad/s", "greatest bit speed"),
    SeverityQuantity("torque_swing", "N.m", "swing of the torque at the top"),
)


@dataclass(frozen=True)
class Severity:
    """Take the numbers of a severity map from the end of a run.

    Parameters
    ----------
    component : str
        Name of the plant.
    """

    component: str = "plant"
    window: float = WINDOW
    sampling: float | None = SAMPLING
    identity: str = "severity 1"

    @property
    def quantities(self) -> tuple[SeverityQuantity, ...]:
        """Name what comes of it."""
        return QUANTITIES

    @property
    def columns(self) -> tuple[str, ...]:
        """Name the outputs it is taken from."""
        return tuple(f"{self.component}.{name}" for name in _NEEDED)

    def of(self, time: FloatArray, columns: Mapping[str, FloatArray]) -> Sequence[float]:
        """Return the numbers.

        Parameters
        ----------
        time : ndarray, shape (rows,)
            Communication points, from the first of the window on, s.
        columns : mapping of str to ndarray, shape (rows,)
            The outputs.

        Returns
        -------
        sequence of float
            In the order of `QUANTITIES`. The index is (greatest - least) / (2 mean) bit speed, infinite where the bit
            does not turn on the whole; the period is NaN where stops do not repeat.
        """
        bit = {name: columns[f"{self.component}.{name}"] for name in _NEEDED}
        span = float(time[-1] - time[0])
        least, greatest = float(bit["bit_speed_min"][1:].min()), float(bit["bit_speed_max"][1:].max())
        mean = float(bit["bit_angle"][-1] - bit["bit_angle"][0]) / span
        ssi = (greatest - least) / (2.0 * mean) if mean >= _NO_SPEED else math.inf
        stuck = min(1.0, max(0.0, float(bit["stuck_time"][-1] - bit["stuck_time"][0]) / span))
        swing = float(bit["top_torque"].max() - bit["top_torque"].min())
        return [ssi, stuck, _period(time, bit), least, greatest, swing]


def _period(time: FloatArray, bit: Mapping[str, FloatArray]) -> float:
    """Return the time after which stops repeat, s; NaN where they do not, or there are none."""
    events = (bit[name] for name in ("last_stop_time", "last_release_time", "slip_count", "bit_stuck"))
    times = find_stops(time, *events).times
    count = stops_per_period(times)
    return math.nan if count is None else float(times[-1] - times[-1 - count])


def severity_of(descriptions: Mapping[str, Description]) -> Severity | None:
    """Return what measures the first component that has a bit; None if none has."""
    for name, description in descriptions.items():
        given = {each.name for each in description.with_causality("output")}
        if given >= set(_NEEDED):
            return Severity(name)
    return None


@dataclass(frozen=True)
class SteadyRotation:
    """Let the runs of a line begin in steady rotation, where there is one.

    Parameters
    ----------
    component : str
        Name of the plant.
    known : mapping of str to value
        Its parameters and inputs, as far as they do not vary.
    """

    component: str
    known: Mapping[str, Value]
    identity: str = "steady rotation"

    def __call__(self, values: Mapping[str, Value]) -> Mapping[str, Value]:
        """Return initial speed and torque of the string at the first point, by its values; of several, the fastest."""
        from cosim.drilling.mathematics import DrillstringParameters, equilibria

        own = {name.partition(".")[2]: value for name, value in values.items() if name.startswith(f"{self.component}.")}
        given: dict[str, Any] = {**self.known, **own}
        symbols = {each.name for each in fields(DrillstringParameters)}
        string = DrillstringParameters(**{name: value for name, value in given.items() if name in symbols})
        running = [each for each in equilibria(string, float(given["Omega"]), float(given["WOB"])) if not each.stuck]
        if not running:
            return {}
        speed = running[-1].speed
        torque = string.c_a * (float(given["Omega"]) - speed)
        return {f"{self.component}.initial_speed": speed, f"{self.component}.initial_torque": torque}


def rotation_of(descriptions: Mapping[str, Description], system: System) -> SteadyRotation | None:
    """Return how runs begin that come down from steady rotation; None where a string is coupled, or is none."""
    found = severity_of(descriptions)
    if found is None or system.connections:
        return None
    name = found.component
    description = descriptions[name]
    if (
        not {"initial_speed", "initial_torque", "Omega", "WOB"} <= set(description.by_name)
        or "beta" in description.by_name
    ):
        return None
    known = {each.name: each.start_value for each in description.variables if each.start_value is not None}
    known |= dict(system.component_of(f"{name}.Omega").parameters)
    signals = {port.variable: signal.levels for port, signal in system.inputs.items() if port.component == name}
    known |= {variable: levels[0] for variable, levels in signals.items() if levels}
    return SteadyRotation(name, known)
