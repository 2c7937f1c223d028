"""A string in full stick-slip, and laws engaged on it: FMUs coupled one after the other, in steps of 10 ms."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from tests.plant.drive import PLANT, Drive
from tests.plant.fmi import must

STEP = 0.01
WEIGHT = 97347.0
SETTLED = 60.0
"""From when on stick-slip is in full cycle from rest [s]."""
WINDOW = 2000
"""Steps of the last 20 s, over which the severity is taken."""


@cache
def in_cycle(speed: float, phase: float, string: tuple[tuple[str, float], ...] = ()) -> tuple[float, bytes]:
    """Return time and state of a plant that has been in stick-slip for long, `phase` seconds later."""
    with Drive(PLANT, {"Omega": speed, "WOB": WEIGHT, **dict(string)}) as plant:
        plant.go(SETTLED + phase)
        assert plant.get("slip_count") > 3
        return plant.time, plant.serialized()


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Attributes
    ----------
    last_stuck : float
        When the bit was stuck last, from the beginning on [s].
    severity : float
        (max - min) / (2 mean) of the bit speed over the last 20 s.
    mean : float
        Of the bit speed over the last 20 s [rad/s].
    columns : mapping of str to ndarray
        What was recorded at every step.
    """

    last_stuck: float
    severity: float
    mean: float
    columns: Mapping[str, np.ndarray]


def run(
    speed: float,
    phase: float,
    act: Callable[[Drive, int], Mapping[str, float]],
    seconds: float = 60.0,
    string: Mapping[str, float] | None = None,
) -> Outcome:
    """Follow a plant from full cycle on.

    Parameters
    ----------
    act : callable
        Sets the drive's speed for the next step, from the plant and the number of the step, and returns what is to be
        recorded.
    string : mapping of str to float, optional
        Parameters and weight of another plant.
    """
    time, state = in_cycle(speed, phase, tuple((string or {}).items()))
    rows: list[dict[str, float]] = []
    with Drive(PLANT, {}) as plant:
        must(plant, plant.restore(state))
        plant.time = time
        stuck, last = plant.get("stuck_time"), 0.0
        for k in range(round(seconds / STEP)):
            told = act(plant, k)
            plant.go(time + (k + 1) * STEP)
            rows.append({"bit_speed": plant.get("bit_speed"), **told})
            before, stuck = stuck, plant.get("stuck_time")
            last = (k + 1) * STEP if stuck > before else last
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    end = columns["bit_speed"][-WINDOW:]
    return Outcome(last, float(end.max() - end.min()) / (2.0 * float(end.mean())), float(end.mean()), columns)


def engaged(
    model: str, speed: float, phase: float, parameters: Mapping[str, Any] | None = None, seconds: float = 60.0
) -> Outcome:
    """Engage a law that answers the top of the string with a drive speed, without a drive between them."""
    with Drive(model, {"enabled": False, "speed_ref": speed, **(parameters or {})}) as law:

        def act(plant: Drive, k: int) -> Mapping[str, float]:
            law.put(top_speed=plant.get("top_speed"), top_torque=plant.get("top_torque"))
            if k == 0:
                law.put(enabled=True)
            law.go((k + 1) * STEP)
            plant.put(Omega=law.get("Omega"))
            return {"Omega": law.get("Omega")}

        return run(speed, phase, act, seconds)


def engaged_behind_a_drive(
    model: str,
    speed: float,
    phase: float,
    parameters: Mapping[str, Any] | None = None,
    drive: Mapping[str, Any] | None = None,
    seconds: float = 60.0,
) -> Outcome:
    """Engage a law that commands the speed of TopDrive and goes by what the drive's sensors show."""
    _, state = in_cycle(speed, phase)
    with Drive(PLANT, {}) as plant:
        must(plant, plant.restore(state))
        top = {name: plant.get(name) for name in ("top_speed", "top_torque")}
    rotor = Drive("TopDrive", {"Omega_command": speed, **top, **(drive or {})})
    with rotor, Drive(model, {"enabled": False, "speed_ref": speed, **top, **(parameters or {})}) as law:

        def act(plant: Drive, k: int) -> Mapping[str, float]:
            if k == 0:
                law.put(enabled=True)
            law.put(**{name: rotor.get(f"{name}_measured") for name in top})
            law.go((k + 1) * STEP)
            rotor.put(Omega_command=law.get("Omega"), **{name: plant.get(name) for name in top})
            rotor.go((k + 1) * STEP)
            plant.put(Omega=rotor.get("Omega"))
            names = ("Omega", "motor_torque_applied", "limit_active")
            return {name: rotor.get(name) for name in names}

        return run(speed, phase, act, seconds)


def engaged_on_a_rotor(
    speed: float,
    phase: float,
    parameters: Mapping[str, Any] | None = None,
    drive: Mapping[str, Any] | None = None,
    string: Mapping[str, float] | None = None,
) -> Outcome:
    """Engage SpeedPid, which turns TopDrive's rotor by its torque, on a plant or another one."""
    _, state = in_cycle(speed, phase, tuple((string or {}).items()))
    with Drive(PLANT, {}) as plant:
        must(plant, plant.restore(state))
        torque = plant.get("top_torque")
    known = {name: value for name, value in (string or {}).items() if name != "WOB"}
    rotor_start = {"mode": 3, "Omega_command": speed, "motor_torque": torque, "top_torque": torque}
    law_start = {"speed_ref": speed, "Omega": speed, "torque_initial": torque, **known, **(parameters or {})}
    with Drive("TopDrive", {**rotor_start, **(drive or {})}) as rotor, Drive("SpeedPid", law_start) as law:

        def act(plant: Drive, k: int) -> Mapping[str, float]:
            law.put(Omega=rotor.get("Omega_measured"))
            law.go((k + 1) * STEP)
            rotor.put(motor_torque=law.get("motor_torque"), top_torque=plant.get("top_torque"))
            rotor.go((k + 1) * STEP)
            plant.put(Omega=rotor.get("Omega"))
            return {"Omega": rotor.get("Omega"), "motor_torque": rotor.get("motor_torque_applied")}

        return run(speed, phase, act, string=string)
