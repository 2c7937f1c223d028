"""Eq. (8) with damping along the string: every loss is told, and what is left is stored."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from tests.oracle import Program
from tests.plant.drive import DAMPED, Drive, Trajectory, follow
from tests.plant.programs import CASES, PAPER, RAMPS, Case
from tests.plant.test_energy import random_case

RATES = ("energy", "drive_work", "top_loss", "string_loss", "work_in", "bit_loss")
BETA = 0.1


def start_energy(case: Case, beta: float) -> float:
    """Return the energy of uniform rotation, whose torque grows towards the top by beta times its speed [J]."""
    p = case.parameters
    drag = beta * p.initial_speed * p.L
    square = p.initial_torque**2 + p.initial_torque * drag + drag**2 / 3
    return 0.5 * (p.L * p.I + p.I_B) * p.initial_speed**2 + p.L * square / (2 * p.G * p.J)


def run_of(case: Case, cells: int, beta: float = BETA, step: float = 0.0137) -> Trajectory:
    grid = np.arange(1, int(case.end / step)) * step
    return follow(case.parameters, case.omega, case.wob, grid, cells=cells, model=DAMPED, beta=beta)


def imbalance(run: Trajectory, before: float) -> float:
    """Return the greatest energy that came from or went to nowhere, as a part of the most that was put in."""
    used = run["bit_loss"] + run["string_loss"] + run["folded_energy"]
    put_in = before + np.abs(run["work_in"]).max()
    return float((np.abs(run["energy"] - before - (run["work_in"] - used)) / put_in).max())


@pytest.mark.parametrize("name", [*CASES, *RAMPS])
def test_energy_put_in_and_not_lost_is_stored(name):
    case = (CASES | RAMPS)[name]
    run = run_of(case, 0)
    assert imbalance(run, start_energy(case, BETA)) <= 3e-6
    assert run["string_loss"][-1] > 0.0


@pytest.mark.parametrize("name", ["stick-slip of figure 2", "drive reversed", "string that turns and is wound up"])
def test_the_balance_closes_with_the_second_power_of_the_cell(name):
    case = replace(CASES[name], end=20.0)
    coarse, fine = (imbalance(run_of(case, cells), start_energy(case, BETA)) for cells in (96, 768))
    assert np.log(coarse / fine) / np.log(8.0) >= 1.9


@pytest.mark.parametrize("seed", range(5))
def test_what_the_drive_gives_and_does_not_put_in_is_lost_in_the_sliding(seed):
    case = random_case(seed)
    run = run_of(case, 96)
    put_in = np.maximum.accumulate(np.abs(run["drive_work"]))
    assert (np.abs(run["drive_work"] - run["top_loss"] - run["work_in"]) <= 1e-12 * put_in).all()
    assert (np.diff(run["top_loss"]) >= 0.0).all()


@pytest.mark.parametrize("beta", [0.0, 0.01, 1.0])
def test_energy_never_grows_without_drive(beta):
    case = Case(
        replace(PAPER, initial_speed=7.0, initial_torque=-9e3), Program.constant(0.0), Program.constant(0.0), 30.0
    )
    energy = run_of(case, 96, beta, 0.1)["energy"]
    assert (np.diff(energy) <= 1e-9 * energy[0]).all()
    assert energy[-1] < 0.01 * energy[0]


def test_rates_are_those_of_the_outputs():
    # quotients over a step within one piece, so that nothing jumps in it
    start = asdict(PAPER) | {"beta": BETA, "stations": 3}
    names = [*RATES, *(f"station_{number}_{what}" for number in (1, 2, 3) for what in ("speed", "torque", "twist"))]
    compared = 0
    with Drive(DAMPED, start) as plant:
        for time in np.arange(1, 80) * 0.1137:
            plant.go(time - 2e-6)
            before = plant.named()
            plant.go(time)
            now, rates = plant.named(), {name: plant.rate(name) for name in names}
            plant.go(time + 2e-6)
            after = plant.named()
            for name in names:
                sides = [(now[name] - before[name]) / 2e-6, (after[name] - now[name]) / 2e-6]
                scale = 1e-4 * abs(rates[name]) + 1e-7 * abs(now[name]) / 2e-6 * 1e-3 + 1e-3
                if abs(sides[0] - sides[1]) <= scale:
                    compared += 1
                    assert rates[name] == pytest.approx(sides[0], abs=3 * scale), (time, name)
    assert compared > 0.9 * 79 * len(names)
