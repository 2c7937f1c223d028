"""Energy: eqs. (7) and (8)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from cosim import load_scenario, simulate
from cosim.drilling.energy import EnergyBalance, energy_balance
from cosim.scenario.file import scenario_names
from models.plant.parameters import DrillstringParameters
from models.theory.stability.normalised_form import NormalisedForm
from tests.oracle import Program
from tests.plant.drive import follow
from tests.plant.judge import RELATIVE_BARS
from tests.plant.programs import PAPER
from tests.verify.finding import Finding, greatest, law
from tests.verify.laws.printed import CASES, DIFFERENCE, STEP, drive, samples

SECTION = "Energy"
BAR = 1e-9
"""Of the energy put in: the plant takes no more than this from its waves in simplifying them."""


@cache
def balances() -> dict[str, EnergyBalance]:
    """Return the balances of all scenarios in all variants."""
    found: dict[str, EnergyBalance] = {}
    for name in scenario_names():
        scenario = load_scenario(name)
        for variant in scenario.variants or (None,):
            label = variant.name if variant else None
            balance = energy_balance(simulate(scenario, variant=label))
            if balance is not None:
                found[f"{name} {label or ''}".strip()] = balance
    return found


@law(SECTION)
def energy_put_in_and_not_lost_is_stored() -> Finding:
    """What the drive gives is stored, or lost in the sliding top and at the bit: (8), integrated"""
    known = {name: balance for name, balance in balances().items() if "string_loss" not in balance.losses}
    found = greatest(balance.worst for balance in known.values())
    reason = "as a part of the energy put in; terms are accumulated one by one"
    return Finding(
        f"all communication points of {len(known)} runs of scenarios with the neutral plant", found, BAR, reason
    )


@law(SECTION)
def energy_never_grows_without_drive() -> Finding:
    """Ω = 0: whatever the string starts with only fades"""
    errors, remaining = [], 0.0
    for top in (120.0, 2000.0):
        for weight in (0.0, 3e4, 97347.0):
            for torque in (-25000.0, 9000.0):
                start = replace(PAPER, c_a=top, initial_speed=5.0, initial_torque=torque)
                run = follow(start, Program.constant(0.0), Program.constant(weight), np.arange(1, 3000) * 0.0137)
                errors.append(np.maximum(np.diff(run["energy"]), 0.0) / run["energy"][0])
                remaining = max(remaining, float(run["energy"][-1] / run["energy"][0]))
    compared = f"greatest growth in a step, 12 starts, of which {100 * remaining:.0f} % remains at most"
    return Finding(compared, greatest(errors), 1e-12, "rounding, as a part of the energy at the start")


def rate_error(form_of: Callable[[float], NormalisedForm]) -> tuple[float, float]:
    """Return how far (8) is from differences of the energy, and the greatest rate seen [W].

    Parameters
    ----------
    form_of : callable
        Gives the coefficients of (8) for a weight on bit.
    """
    errors, slopes = [], []
    none = np.zeros(1)  # beta = 0: no integral over the string
    for name, (_, weight) in CASES.items():
        run, smooth = samples(name)
        form = form_of(weight)
        friction = (run["bit_torque"] - PAPER.c_b * run["bit_speed"]) / (weight * PAPER.R_b)
        ends = zip(run["top_speed"], run["bit_speed"], friction, drive(name, run), strict=True)
        rates = np.array([form.energy_rate(none, none, (top, bit), mu, omega) for top, bit, mu, omega in ends])
        slope = -np.convolve(run["energy"], DIFFERENCE, "same") / STEP
        errors.append((form.unit * rates - slope)[smooth])
        slopes.append(slope[smooth])
    return greatest(errors), greatest(slopes)


@law(SECTION)
def energy_changes_at_the_rate_of_equation_8() -> Finding:
    """dE/dt is (8) at every instant, GL read as GJ"""
    found, highest = rate_error(lambda weight: NormalisedForm.of(DrillstringParameters(), weight))
    stored = max(float(samples(name)[0]["energy"].max()) for name in CASES)
    allowed = float(np.abs(DIFFERENCE).sum()) * RELATIVE_BARS["energy"] * stored / STEP
    reason = f"what differences make of errors of 1e-8 of {stored / 1e3:.0f} kJ"
    return Finding(f"(8) and differences of the energy, up to {highest / 1e3:.0f} kW", found, allowed, reason, "W")
