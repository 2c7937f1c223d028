"""Put each law on a rig that drills: weight, formation and mud are drawn anew every few seconds, and laws switched."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from cosim import Component, Connection, Signal, System
from cosim.system.signals import FloatArray, Value

EVERY = 5.0
"""Seconds between draws."""
SHARE_ENABLED = 0.8
WEIGHT = 97347.0
NOMINAL: Mapping[str, float] = {"WOB": WEIGHT, "mu_sb": 0.8, "mu_cb": 0.5, "gamma_b": 0.9, "c_b": 0.03}
DRAWN: Mapping[str, tuple[float, float]] = {
    "WOB": (0.0, 1.2 * WEIGHT),
    "mu_sb": (0.5, 0.9),
    "mu_cb": (0.3, 0.5),
    "gamma_b": (0.5, 1.0),
    "c_b": (0.0, 50.0),
}
"""Ranges of what is drawn: the weight, and tunable parameters of the string that stand for formation and mud."""

NOISE: Mapping[str, Value] = {"speed_noise": 0.05, "torque_noise": 150.0}
TURNS, TORQUE, FORCE = (-40.0, 40.0), (0.0, 6e4), (0.0, 3e5)
"""Limits of laws and drives by default: of a speed [rad/s], a torque [N m], a weight [N]."""


@dataclass(frozen=True)
class Draws(Signal):
    """Hold values one after the other, each for `EVERY` seconds, the last for ever."""

    kind: ClassVar[str] = "draws"

    drawn: tuple[Value, ...]

    @cached_property
    def _values(self) -> NDArray[np.generic]:
        return np.array(self.drawn)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times at which another value is drawn."""
        return tuple(EVERY * number for number in range(1, len(self.drawn)))

    @property
    def levels(self) -> tuple[Value, ...]:
        """All that is drawn."""
        return self.drawn

    def values(self, times: FloatArray) -> NDArray[np.generic]:
        """Return what is held from each time on."""
        return self._values[np.clip(np.floor(times / EVERY).astype(int), 0, len(self.drawn) - 1)]

    def left_values(self, times: FloatArray) -> NDArray[np.generic]:
        """Return what was held up to each time."""
        return self._values[np.clip(np.ceil(times / EVERY).astype(int) - 1, 0, len(self.drawn) - 1)]

    def slopes(self, times: FloatArray) -> FloatArray:
        """Return zeros."""
        return np.zeros(times.shape)


@dataclass(frozen=True)
class Rig:
    """A law on a rig.

    Attributes
    ----------
    parts, parameters : mapping
        FMU of each component by name, and its parameters; that of the string is called ``plant``.
    wires : mapping of str to str
        Source by target.
    inputs : mapping of str to value
        What is held.
    weight : str
        Input that takes the weight that is drawn; empty where a law makes it.
    switch : str
        Input that engages the law; empty where it has none.
    bounds : mapping of str to (float, float)
        Between which limits outputs are to stay.
    limits : tuple of str
        Outputs that say that a limit holds.
    told : str
        Output whose end tells whether something is wound up.
    afterwards : float
        Seconds at nominal weight and formation after the last draw, by whose end the law has forgotten what was before.
    near : float
        How far the mean of what is told may be from that of a law before which next to nothing was drawn.
    plain : tuple of str
        Targets that take a number whatever its unit.
    """

    parts: Mapping[str, str]
    parameters: Mapping[str, Mapping[str, Value]]
    wires: Mapping[str, str]
    inputs: Mapping[str, Value]
    bounds: Mapping[str, tuple[float, float]]
    limits: tuple[str, ...]
    weight: str = "plant.WOB"
    switch: str = "law.enabled"
    told: str = "plant.bit_speed"
    afterwards: float = 150.0
    near: float = 0.02
    plain: tuple[str, ...] = ()

    def system(self, draws: int, seed: int) -> System:
        """Return the rig with so many draws, after which everything is nominal."""
        random = np.random.default_rng(seed)
        inputs: dict[str, Any] = dict(self.inputs)
        for name, (low, high) in DRAWN.items():
            drawn = (*random.uniform(low, high, draws).tolist(), NOMINAL[name])
            target = self.weight if name == "WOB" else f"plant.{name}"
            if target:
                inputs[target] = Draws(drawn)
        if self.switch:
            inputs[self.switch] = Draws((*(random.random(draws) < SHARE_ENABLED).tolist(), True))
        return System(
            tuple(Component(name, fmu, self.parameters.get(name, {})) for name, fmu in self.parts.items()),
            tuple(
                Connection(source, target, unconverted=target in self.plain) for target, source in self.wires.items()
            ),
            inputs,
        )


_DRIVEN: Mapping[str, str] = {
    "drive.top_speed": "plant.top_speed",
    "drive.top_torque": "plant.top_torque",
    "plant.Omega": "drive.Omega",
}
_OF_DRIVE: Mapping[str, tuple[float, float]] = {"drive.motor_torque_applied": TORQUE, "drive.Omega": TURNS}


def behind_a_drive(law: str, **parameters: Value) -> Rig:
    """Return the rig of a law that commands the speed of a drive and goes by its sensors."""
    return Rig(
        {"law": law, "drive": "TopDrive", "plant": "DrillstringNeutral"},
        {"law": parameters, "drive": NOISE},
        {
            **_DRIVEN,
            "law.top_speed": "drive.top_speed_measured",
            "law.top_torque": "drive.top_torque_measured",
            "drive.Omega_command": "law.Omega",
        },
        {"law.speed_ref": 10.0},
        {"law.Omega": TURNS, **_OF_DRIVE},
        ("law.limit_active", "drive.limit_active"),
    )


def on_a_rotor() -> Rig:
    """Return the rig of SpeedPid, on a rotor and string that it is able to free."""
    string: dict[str, Value] = {"L": 3000.0}
    return Rig(
        {"law": "SpeedPid", "drive": "TopDrive", "plant": "DrillstringNeutral"},
        {
            "law": {"J_r": 500.0, **string},
            "drive": {"mode": "torque", "J_r": 500.0, **NOISE},
            "plant": string,
        },
        {**_DRIVEN, "law.Omega": "drive.Omega_measured", "drive.motor_torque": "law.motor_torque"},
        {"law.speed_ref": 12.0, "drive.Omega_command": 0.0},
        {"law.motor_torque": TORQUE, **_OF_DRIVE},
        ("law.limit_active", "drive.limit_active"),
    )


def dissipative(form: str) -> Rig:
    """Return the rig of DissipativeLaw, which knows the torque on bit at the speed that it is to reach."""
    return Rig(
        {"law": "DissipativeLaw", "drive": "TopDrive", "plant": "DrillstringNeutral"},
        {"law": {"form": form}},
        {
            **_DRIVEN,
            "law.top_speed": "drive.top_speed_measured",
            "law.bit_speed": "plant.bit_speed",
            "drive.Omega_command": "law.Omega",
        },
        {"law.bit_speed_ref": 10.0, "law.bit_torque_ref": 7590.0},
        {"law.Omega": TURNS, **_OF_DRIVE},
        ("law.limit_active", "law.guard_active", "drive.limit_active"),
        switch="",
    )


def weight_law() -> Rig:
    """Return the rig of WeightOnBitLaw."""
    return Rig(
        {"law": "WeightOnBitLaw", "drive": "TopDrive", "plant": "DrillstringNeutral"},
        {},
        {**_DRIVEN, "law.bit_speed": "plant.bit_speed", "plant.WOB": "law.WOB"},
        {"drive.Omega_command": 10.0},
        {"law.WOB": FORCE, **_OF_DRIVE},
        ("drive.limit_active",),
        weight="",
        switch="",
    )


def autodriller() -> Rig:
    """Return the rig of Autodriller, which is asked for the weights that are drawn, under SoftTorque."""
    soft = behind_a_drive("SoftTorque")
    return Rig(
        {"driller": "Autodriller", **soft.parts},
        # left to itself the feed goes on for 5 s and more: then a bit can stall, and has to be lifted off
        {**soft.parameters, "driller": {"feed_min": -0.02}},
        {**soft.wires, "driller.bit_speed": "plant.bit_speed", "plant.WOB": "driller.WOB"},
        soft.inputs,
        {**soft.bounds, "driller.WOB": FORCE},
        ("driller.limit_active", *soft.limits),
        weight="driller.WOB_ref",
        switch="driller.enabled",
        afterwards=600.0,  # its integral time is a minute, and the weight follows the feed with another
    )


def seen_from_the_top() -> Rig:
    """Return the rig of BitSpeedObserver, which watches a string under SoftTorque."""
    soft = behind_a_drive("SoftTorque")
    return Rig(
        {"observer": "BitSpeedObserver", **soft.parts},
        {**soft.parameters, "observer": {"jump": 10.0}},
        {**soft.wires, "observer.top_speed": "plant.top_speed", "observer.top_torque": "plant.top_torque"},
        soft.inputs,
        soft.bounds,
        soft.limits,
        told="observer.bit_speed",
    )


def heard_from_downhole() -> Rig:
    """Return the rig of MudPulse, which sends the speed of a bit under SoftTorque."""
    soft = behind_a_drive("SoftTorque")
    return Rig(
        {"link": "MudPulse", **soft.parts},
        soft.parameters,
        {**soft.wires, "link.value": "plant.bit_speed"},
        soft.inputs,
        {**soft.bounds, "link.measured": (0.0, 40.0), "link.age": (0.0, 3.0)},
        soft.limits,
        told="link.measured",
        near=0.05,  # a third of a quantum; sixty values a minute scatter by half of one
        plain=("link.value",),
    )


def supervised() -> Rig:
    """Return the rig of SpeedSupervisor, which raises the speed by what MudPulse brings it of its own severity."""
    return Rig(
        {"supervisor": "SpeedSupervisor", "link": "MudPulse", "drive": "TopDrive", "plant": "DrillstringNeutral"},
        {"link": {"range": 5.0, "loss": 0.1}, "drive": NOISE},
        {
            **_DRIVEN,
            "supervisor.bit_speed": "plant.bit_speed",
            "link.value": "supervisor.severity",
            "supervisor.measured": "link.measured",
            "supervisor.valid": "link.valid",
            "drive.Omega_command": "supervisor.speed_ref",
        },
        {},
        {"supervisor.severity": (0.0, 5.0), "supervisor.speed_ref": (10.0, 20.0), **_OF_DRIVE},
        ("supervisor.limit_active", "drive.limit_active"),
        switch="supervisor.enabled",
        told="supervisor.severity",
        afterwards=600.0,  # from 10 rad/s it takes him up to five minutes
    )


RIGS: Mapping[str, Rig] = {
    "soft-torque": behind_a_drive("SoftTorque"),
    "z-torque": behind_a_drive("SoftTorque", mode="z_torque"),
    "absorber": behind_a_drive("TopAbsorber", filter_time=0.08),
    "speed-pid": on_a_rotor(),
    "tracking": dissipative("tracking"),
    "printed": dissipative("printed"),
    "weight-law": weight_law(),
    "autodriller": autodriller(),
    "observer": seen_from_the_top(),
    "mud-pulse": heard_from_downhole(),
    "supervisor": supervised(),
}
"""By what they are called at the command line."""
