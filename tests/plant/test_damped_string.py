"""The string with damping along it, eqs. (1) to (4): the neutral plant without; closed forms, another solver with."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from tests.oracle import Program
from tests.oracle.damped_lines import DampedLines
from tests.oracle.telegraph import Telegraph
from tests.plant import theory
from tests.plant.drive import DAMPED, PLANT, Drive, Trajectory, follow
from tests.plant.fmi import must
from tests.plant.programs import CASES, PAPER, RAMPS, SPEED, WEIGHT

BETAS = (0.02, 0.1, 0.5)
RUNNING = 6.2
FREE = replace(PAPER, c_b=20.0)
NO_WEIGHT = Program.constant(0.0)


def common(run: Trajectory) -> np.ndarray:
    """Return what both plants put out."""
    names = [name for name in run.names if not name.startswith("station") and name != "string_loss"]
    return np.column_stack([run[name] for name in names])


@pytest.mark.parametrize("name", [*CASES, *RAMPS])
def test_without_damping_and_stations_it_is_the_neutral_plant_to_the_last_bit(name):
    case = (CASES | RAMPS)[name]
    grid = np.arange(1, int(case.end / 0.137)) * 0.137
    neutral = follow(case.parameters, case.omega, case.wob, grid)
    damped = follow(case.parameters, case.omega, case.wob, grid, model=DAMPED, stations=0)
    assert common(damped).tobytes() == common(neutral).tobytes()
    assert (damped["string_loss"] == 0.0).all()


def smooth_ramp(model: str, cells: int, **more: float) -> Trajectory:
    """Return a running string whose drive slows down, while the bit turns on."""
    torque = theory.torque_on_bit(PAPER, 97347.0, RUNNING)
    string = replace(PAPER, initial_speed=RUNNING, initial_torque=torque)
    drive = Program([0.0], [RUNNING + torque / PAPER.c_a], [-0.5])
    return follow(string, drive, WEIGHT, np.arange(1, 40) * 0.0731, cells=cells, model=model, **more)


def test_without_damping_the_error_of_the_grid_falls_with_at_least_the_second_power():
    exact = smooth_ramp(PLANT, 2976)
    assert exact["bit_speed"].min() > 1.0
    errors = []
    for cells in (32, 64, 128):
        run = smooth_ramp(DAMPED, cells, stations=3)
        errors.append([np.abs(run[name] - exact[name]).max() for name in ("bit_speed", "top_speed", "bit_torque")])
    orders = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    assert (orders >= 2.0).all(), orders


def ramped(beta: float, cells: int, time: float, **more: float) -> dict[str, float]:
    """Return the outputs of a string at rest and without weight, whose drive has gained speed up to a time."""
    start = asdict(FREE) | {"WOB": 0.0, "Omega": 0.0, "beta": beta, "cells": cells, "stations": 3} | more
    with Drive(DAMPED, start) as plant:
        must(plant, plant.set_slopes(Omega=5.0))
        plant.go(time)
        return plant.named()


@pytest.mark.slow
@pytest.mark.parametrize(("beta", "time"), [(0.02, 2.0), (0.1, 0.9), (0.1, 2.0), (0.5, 3.1)])
def test_without_friction_it_is_the_telegraph_equation_in_closed_form(beta, time):
    seen, exact = ramped(beta, 0, time), Telegraph(FREE, beta, 5.0)
    assert seen["bit_speed"] == pytest.approx(exact.speed(FREE.L, time), abs=2e-6)
    assert seen["top_torque"] == pytest.approx(exact.torque(0.0, time), abs=5e-3)
    for number, depth in ((1, 0.25 * FREE.L), (3, 0.75 * FREE.L)):
        assert seen[f"station_{number}_speed"] == pytest.approx(exact.speed(depth, time), abs=2e-6)
        assert seen[f"station_{number}_torque"] == pytest.approx(exact.torque(depth, time), abs=5e-3)
        assert seen[f"station_{number}_twist"] == pytest.approx(exact.twist(depth, time), abs=2e-6)


@pytest.mark.slow
@pytest.mark.parametrize("beta", [0.1, 0.5])
def test_with_damping_the_error_falls_with_the_second_power_of_the_cell(beta):
    exact = Telegraph(FREE, beta, 5.0)
    times = [1.7, 2.0, 2.3, 2.9]
    due = np.array([[exact.speed(FREE.L, time), exact.speed(0.5 * FREE.L, time)] for time in times])
    errors = []
    for cells in (96, 768):
        seen = [ramped(beta, cells, time) for time in times]
        found = np.array([[outputs["bit_speed"], outputs["station_2_speed"]] for outputs in seen])
        errors.append(np.abs(found - due).max())
    assert np.log(errors[0] / errors[1]) / np.log(8.0) >= 1.9


@pytest.mark.parametrize("beta", BETAS)
def test_the_bit_breaks_loose_when_the_closed_form_of_the_held_string_says(beta):
    slope, weight = 4.0, 60000.0
    exact = Telegraph(PAPER, beta, slope, held=True)
    with Drive(DAMPED, {"WOB": weight, "Omega": 0.0, "beta": beta}) as plant:
        must(plant, plant.set_slopes(Omega=slope))
        plant.go(6.0)
        loose = plant.get("last_release_time")
        assert plant.get("slip_count") == 1
    static = weight * PAPER.R_b * PAPER.mu_sb
    before, after = (exact.torque(PAPER.L, loose + shift) for shift in (-1e-6, 1e-6))
    assert before < static < after


@pytest.mark.parametrize("beta", [0.05, 0.2])
def test_slip_and_stop_are_those_of_another_solver(beta):
    torque = theory.torque_on_bit(PAPER, 97347.0, 6.0)
    string = replace(PAPER, initial_speed=6.0, initial_torque=torque)
    drive = 6.0 + (torque + beta * PAPER.L * 6.0) / PAPER.c_a
    times = np.arange(1, 420) * 0.01
    speeds, tops, stop = DampedLines(string, beta, 97347.0, (drive, -1.0)).follow(times)
    assert stop is not None
    run = follow(string, Program([0.0], [drive], [-1.0]), WEIGHT, times, model=DAMPED, beta=beta)
    assert run["last_stop_time"][-1] == pytest.approx(stop, abs=1e-6)
    # the other solver rings at the kink of the drive speed
    assert np.abs(run["bit_speed"][: len(speeds)] - speeds).max() <= 2e-5
    assert np.abs(run["top_speed"][: len(tops)] - tops).max() <= 1e-4


@pytest.mark.parametrize("cells", [8, 96, 0])
@pytest.mark.parametrize(("beta", "stations"), [(0.1, 3), (2.0, 9)])
def test_uniform_rotation_goes_on(beta, stations, cells):
    drag = beta * RUNNING
    second_order = (beta / PAPER.I * PAPER.travel_time / max(cells or 744, 32)) ** 2 + 1e-12
    torque = theory.torque_on_bit(PAPER, 30000.0, RUNNING)
    start = {
        "beta": beta, "stations": stations, "cells": cells, "WOB": 30000.0, "initial_speed": RUNNING,
        "initial_torque": torque, "Omega": RUNNING + (torque + drag * PAPER.L) / PAPER.c_a,
    }  # fmt: skip
    with Drive(DAMPED, start) as plant:
        for time in (0.0123, 0.71, 8.3):
            plant.go(time)
            now = plant.named()
            assert [now["bit_speed"], now["top_speed"]] == pytest.approx([RUNNING, RUNNING], rel=1e-9)
            for number in range(1, stations + 1):
                left = PAPER.L * (1 - number / (stations + 1))
                assert now[f"station_{number}_speed"] == pytest.approx(RUNNING, rel=1e-9)
                assert now[f"station_{number}_torque"] == pytest.approx(torque + drag * left, rel=1e-8)
                twist = (torque * (PAPER.L - left) + drag * (PAPER.L**2 - left**2) / 2) / (PAPER.G * PAPER.J)
                assert now[f"station_{number}_twist"] == pytest.approx(twist, rel=1e-8)
            assert now["string_loss"] == pytest.approx(drag * PAPER.L * RUNNING * time, rel=second_order)
        assert now["top_torque"] == pytest.approx(torque + drag * PAPER.L, rel=1e-8)


@pytest.mark.parametrize("beta", [0.0, 0.1])
def test_the_mirror_image_is_a_motion_as_well(beta):
    case = CASES["inputs that jump on no grid"]
    mirror = Program(case.omega.times, [-value for value in case.omega.values], case.omega.slopes)
    grid = np.arange(1, 150) * 0.1
    one, other = (
        follow(case.parameters, omega, case.wob, grid, cells=96, model=DAMPED, beta=beta, stations=3)
        for omega in (case.omega, mirror)
    )
    odd = [name for name in one.names if name.endswith(("_speed", "_torque", "_angle", "_twist")) and one[name].any()]
    assert len(odd) == 6 + 9
    for name in odd:
        assert (other[name] == -one[name]).all(), name
    for name in ("energy", "work_in", "bit_loss", "string_loss", "stuck_time", "slip_count"):
        assert (other[name] == one[name]).all(), name


def test_a_part_of_the_string_turns_by_its_torque():
    run = follow(PAPER, SPEED, WEIGHT, np.arange(1, 400) * 0.01, model=DAMPED, beta=0.1, stations=9)
    depths = np.arange(11) / 10
    torque = np.array([run["top_torque"], *(run[f"station_{number}_torque"] for number in range(1, 10))])
    twist = np.array([0.0 * run["top_torque"], *(run[f"station_{number}_twist"] for number in range(1, 10))])
    # away from the fronts of the first waves the torque is smooth along the string
    late = run.times > 3.5
    mean = np.cumsum(0.5 * (torque[1:] + torque[:-1]), axis=0)[:, late] * (depths[1] * PAPER.L)
    assert np.abs(mean / (PAPER.G * PAPER.J) - twist[1:, late]).max() <= 0.05 * twist[:, late].max()


def test_stations_that_are_not_there_read_nothing():
    with Drive(DAMPED, {"stations": 2, "initial_speed": 3.0, "initial_torque": 4e3, "beta": 0.1}) as plant:
        plant.go(1.0)
        now = plant.named()
    for number in range(1, 10):
        for what in ("speed", "torque", "twist"):
            assert (now[f"station_{number}_{what}"] != 0.0) == (number <= 2)
