"""Proposition 1: with law (9) the energy does not grow."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cosim import LoopError, Result, Scenario, load_scenario, simulate
from tests.plant.programs import PAPER
from tests.plant.theory import torque_on_bit
from tests.verify.claim import Trial, claim
from tests.verify.claims.runs import NOMINAL_WEIGHT, equilibrium_start

ROUNDING = 1e-9
"""Of terms that nearly cancel near the pole of (9)."""
GROWN = 1e-9
"""Growth of this part of the greatest energy is rounding."""
BETA = 0.05
"""Damping along the string where there is any [N s/rad per metre]; the paper gives no value."""
THROWN = {"plant.initial_speed": 30.0}
"""A string that turns faster than wanted, under no torque: the loop has a solution there."""


def printed(c_1: float, c_2: float, wanted: float, top: np.ndarray, bit: np.ndarray) -> np.ndarray:
    """Return the drive speed by (9), from the paper's text; k / g is c_b / c_a."""
    ratio = PAPER.c_b / PAPER.c_a
    omega = c_1 * top + 2 * math.sqrt(ratio * (1 - c_1)) * bit + 2 * math.sqrt(c_2 * (1 - c_1)) * wanted
    return omega - c_2 * wanted**2 / top - 2 * math.sqrt(c_2 * ratio) * bit * wanted / top


@claim("Proposition 1, section 2.1")
def square_is_completed() -> list[Trial]:
    """Law (9) turns (8) into minus the friction, minus the loss along the string, minus a square"""
    random, error = np.random.default_rng(1), 0.0
    for _ in range(200):
        c_1, c_2, wanted = random.uniform(-3, 1), random.uniform(0, 5), random.uniform(-20, 20)
        top, bit = random.uniform(0.1, 30, (2, 50)) * random.choice([-1, 1], (2, 50))
        friction = (torque_on_bit(PAPER, NOMINAL_WEIGHT, 1.0) - PAPER.c_b) * np.abs(bit)
        power = PAPER.c_a * top * (printed(c_1, c_2, wanted, top, bit) - top) - PAPER.c_b * bit**2 - friction
        ratio = math.sqrt(PAPER.c_b / PAPER.c_a)
        square = PAPER.c_a * (math.sqrt(1 - c_1) * top - ratio * bit - math.sqrt(c_2) * wanted) ** 2
        error = max(error, float(np.max(np.abs(power + friction + square) / (friction + square))))
    told = f"both sides {'agree within' if error <= ROUNDING else 'differ by more than'} {ROUNDING:.0e} of themselves"
    return [Trial("10000 random speeds, c_1 < 1, c_2 > 0, β = 0", told, error <= ROUNDING)]


def growth(result: Result) -> tuple[float, float]:
    """Return the greatest energy over that at the start, and the greatest growth from point to point [J]."""
    energy = result["plant.energy"]
    return float(energy.max() - energy[0]), float(np.diff(energy).max())


def _grown(result: Result) -> tuple[str, bool]:
    most, step = growth(result)
    energy = result["plant.energy"]
    holds = step <= GROWN * float(energy.max())
    later = f"{energy[-1] / 1e3:.3g} kJ at the end, never growing" if holds else f"up to {most / 1e3:.0f} kJ more later"
    return f"energy {energy[0] / 1e3:.3g} kJ at the start, {later}", holds


@claim("Proposition 1, section 2.1")
def energy_does_not_grow() -> list[Trial]:
    """For all solutions the energy (7) does not grow if law (9) is applied

    It does not while (9) is obeyed: that is the completed square. But law and string then drain all energy, and have no
    common solution when too little is left. From rest, where the energy is zero, they have none at all: a string whose
    energy does not grow never begins to turn. What is sampled and limited goes on, and is not (9). The causes of its
    growth are told apart in [energy.md](energy.md).
    """
    scenario, trials = load_scenario("dissipative-law"), list[Trial]()
    steady = {name.replace("__", "."): value for name, value in equilibrium_start().items()}
    for name, start in (("from rest", {}), ("from steady rotation", steady), ("from 30 rad/s without torque", THROWN)):
        trials += _solved(name, scenario, start)
        sampled = simulate(scenario, variant="printed", overrides=start)
        trials.append(Trial(f"{name}, sampled each millisecond, Ω within ±40 rad/s", *_grown(sampled)))
    trials += _solved(f"from 30 rad/s without torque, β = {BETA}", _damped(scenario), THROWN)
    return trials


def _solved(name: str, scenario: Scenario, start: Mapping[str, float]) -> list[Trial]:
    """Try the claim on law and string solved together: for the whole run, and as far as there is a solution."""
    options = {"variant": "printed", "algorithm": "implicit", "overrides": start}
    try:
        return [Trial(f"{name}, solved together", *_grown(simulate(scenario, **options)))]
    except LoopError as error:
        told = f"at t = {error.time:.3f} s law and string have no common solution"
        failed = Trial(f"{name}, solved together, for 60 s", told, False)
        if error.time <= 0.0:
            return [failed]
        until = simulate(scenario, **options, stop_time=error.time - 1e-3)
    return [Trial(f"{name}, solved together, as long as there is a solution", *_grown(until)), failed]


def _damped(scenario: Scenario) -> Scenario:
    """Return a scenario with damping along the string."""
    parts = {part.name: part for part in scenario.system.components}
    damping = {**parts["plant"].parameters, "beta": BETA}
    parts["plant"] = replace(parts["plant"], fmu="DrillstringDistributed", parameters=damping)
    return replace(scenario, system=replace(scenario.system, components=tuple(parts.values())))


@claim("(9), section 2.1")
def reference_can_be_achieved() -> list[Trial]:
    """The reference in (9) is the angular velocity to be achieved

    No steady rotation obeys (9), since (8) is negative whenever the bit turns: the torque that the drive is short of is
    at least the dry friction.
    """
    speeds, trials = np.geomspace(1e-3, 1e3, 20001), []
    friction = np.array([torque_on_bit(PAPER, NOMINAL_WEIGHT, float(speed)) for speed in speeds])
    for c_1, c_2 in ((0.3, 2.0), (-2.0, 2.0), (0.9, 2.0), (0.3, 0.1), (0.3, 10.0)):
        surplus = PAPER.c_a * (printed(c_1, c_2, 10.0, speeds, speeds) - speeds) - friction
        best = int(np.argmax(surplus))
        balanced = bool(surplus[best] >= 0.0)
        told = f"the drive is short of torque at every speed, by {-surplus[best]:.0f} N m at least"
        if balanced:
            told = f"the drive has {surplus[best]:.0f} N m to spare at {speeds[best]:.3g} rad/s"
        trials.append(Trial(f"balance of torques from 0.001 to 1000 rad/s, c_1 = {c_1}, c_2 = {c_2}", told, balanced))
    return trials
