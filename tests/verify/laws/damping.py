"""The plant with damping along the string: eqs. (1)-(4) and (8) with beta > 0, and the neutral plant without."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from cosim import Result, load_scenario, simulate
from cosim.drilling.energy import energy_balance
from cosim.drilling.oscillation import measure
from models.plant.parameters import DrillstringParameters
from models.theory.cycle.cycle import limit_cycle
from tests.oracle import Program
from tests.oracle.elements import FieldSolution, solve_field
from tests.plant import theory
from tests.plant.drive import DAMPED, PLANT, Trajectory, follow
from tests.plant.programs import PAPER, WEIGHT
from tests.verify.finding import Finding, greatest, law
from tests.verify.laws.field import COARSE, FINE, RAMP

SECTION = "Damping along the string"
BETA = 0.1
"""N s/rad per metre; the paper gives no value."""
CELLS = 744
"""The plant's own choice for the nominal string."""
BOTH = "what halving the elements and doubling the cells change: the own errors of both are below that"
DOUBLED = "what doubling the cells changes: what remains is less"


@cache
def damped(cells: int) -> Trajectory:
    """Return the damped plant in stick-slip."""
    return follow(PAPER, RAMP, WEIGHT, np.arange(1, 876) * 0.0137, cells=cells, model=DAMPED, beta=BETA)


@cache
def field(elements: int) -> FieldSolution:
    """Return the same motion by elements."""
    return solve_field(PAPER, RAMP, WEIGHT, damped(CELLS).times, elements=elements, beta=BETA)


def differences(output: str) -> tuple[float, float]:
    """Return how far the damped plant is from the elements' solution, and by how much both change with their grids."""
    fine, coarse = (getattr(field(elements), output) for elements in (FINE, COARSE))
    run, rough = damped(CELLS)[output], damped(CELLS // 2)[output]
    return greatest([run - fine]), greatest([coarse - fine]) + greatest([rough - run])


@law(SECTION)
def damped_bit_turns_as_in_the_field_equation() -> Finding:
    """With damping along it the string lets the bit stick and slip as eqs. (1)-(4) say"""
    found, allowed = differences("bit_speed")
    return Finding(f"bit speed, 12 s of stick-slip, β = {BETA}, {FINE} elements", found, allowed, BOTH, "rad/s")


@law(SECTION)
def damping_takes_the_energy_that_it_takes_from_the_field() -> Finding:
    """What damping along the string takes is β times the integral of the speed squared, the last term of (8)"""
    found, allowed = differences("string_loss")
    lost = damped(CELLS)["string_loss"][-1] / 1e3
    return Finding(f"string_loss and that of the elements, {lost:.0f} kJ in the end", found, allowed, BOTH, "J")


@law(SECTION)
def energy_of_a_damped_string_is_that_of_the_field() -> Finding:
    """The energy of a damped string is (7), the integral over it"""
    found, allowed = differences("energy")
    return Finding("energy output and (7) integrated over the elements", found, allowed, BOTH, "J")


@cache
def damped_run(variant: str, cells: int) -> Result:
    """Return a variant of the scenario of damped strings."""
    return simulate(load_scenario("string-damping"), variant=variant, overrides={"plant.cells": cells})


@law(SECTION)
def energy_of_a_damped_string_is_balanced_to_the_order_of_the_grid() -> Finding:
    """What the drive gives is stored, or lost in the sliding top, at the bit and along the string: (8) with β > 0"""
    found, changes = [], []
    for variant in [one.name for one in load_scenario("string-damping").variants if one.name != "beta=0"]:
        coarse, fine = (energy_balance(damped_run(variant, cells)) for cells in (CELLS // 2, CELLS))
        assert coarse is not None
        assert fine is not None
        found.append(fine.worst)
        changes.append(greatest([(coarse.residual - fine.residual)[1:] / fine.put_in[1:]]))
    compared = f"balance of {len(found)} strings at {CELLS} cells, as a part of the energy put in"
    worst = int(np.argmax(np.divide(found, changes)))
    return Finding(compared, found[worst], changes[worst], DOUBLED)


@law(SECTION)
def distributed_plant_without_damping_has_the_cycle_of_the_neutral_one() -> Finding:
    """β = 0: the string on a grid of cells sticks and slips with the period of the neutral equation"""
    measures = measure(damped_run("beta=0", CELLS))
    cycle = limit_cycle(DrillstringParameters(), 10.0, 97347.0)
    error = np.nan if measures is None or measures.period is None else abs(measures.period - cycle.period)
    coarse = measure(damped_run("beta=0", CELLS // 2))
    change = np.nan if coarse is None or coarse.period is None else abs(coarse.period - cycle.period)
    compared = f"period of Fig. 2, {CELLS} cells, and the equations of a cycle"
    return Finding(compared, error, change, "the error of half as many cells", "s")


@law(SECTION)
def distributed_plant_without_damping_approaches_the_neutral_one_by_the_second_order() -> Finding:
    """β = 0: with twice as many cells the difference from the neutral plant is a quarter at most"""
    speed = 6.2
    torque = theory.torque_on_bit(PAPER, 97347.0, speed)
    string = replace(PAPER, initial_speed=speed, initial_torque=torque)
    drive, grid = Program([0.0], [speed + torque / PAPER.c_a], [-0.5]), np.arange(1, 40) * 0.0731
    exact = follow(string, drive, WEIGHT, grid, cells=2976, model=PLANT)
    errors = []
    for cells in (32, 64, 128):
        run = follow(string, drive, WEIGHT, grid, cells=cells, model=DAMPED, stations=3)
        errors.append([greatest([run[name] - exact[name]]) for name in ("bit_speed", "top_speed", "bit_torque")])
    ratios = np.array(errors)[1:] / np.array(errors)[:-1]
    return Finding("errors of 64 to 32 and of 128 to 64 cells, smooth motion", greatest([ratios]), 0.25, "second order")
