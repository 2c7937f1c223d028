"""The plant at moments worth saving, and how it is followed from there."""

from __future__ import annotations

from tests.plant.drive import DAMPED, PLANT, Drive

MOMENTS = {
    # Fig. 2 with jumps of the inputs on the way
    "at the start": 0.0,
    "while the bit waits for the first wave": 0.123456,
    "while the bit is stuck": 1.8,
    "while the bit slips": 3.4567891,
    "long after": 60.0001,
}
PACKAGINGS = ("native", "python")
LATER = [0.001, 0.31, 0.3100001, 2.9, 9.0]
SLOW = {"cells": 60}
BEGINS: dict[str, dict[str, float]] = {PLANT: SLOW, DAMPED: SLOW | {"beta": 0.1, "stations": 3}}


def drive_to(time: float, packaging: str = "native", model: str = PLANT) -> Drive:
    """Return a plant after jumps of both inputs, one of them just before the given time."""
    plant = Drive(model, BEGINS[model], packaging)
    for at, change in ((0.3 * time, {"Omega": 11.0}), (0.9 * time, {"WOB": 9e4}), (0.999 * time, {"Omega": 9.5})):
        if at > 0:
            plant.go(at)
            plant.put(**change)
    if time > 0:
        plant.go(time)
    return plant


def continued(plant: Drive, changes: bool = True) -> list[list[float]]:
    """Return the outputs from here on, with an input that jumps."""
    begin, rows = plant.time, []
    for number, after in enumerate(LATER):
        if changes and number == 2:
            plant.put(WOB=1.1e5)
        plant.go(begin + after)
        rows.append(plant.outputs())
    return rows
