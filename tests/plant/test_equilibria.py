"""Steady drilling: where it is, and that it stays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.oracle import Program
from tests.plant.drive import follow
from tests.plant.programs import PAPER, SPEED, WEIGHT
from tests.plant.theory import equilibrium, torque_on_bit

NOMINAL = 97347.0
STEADY = [
    # Omega, WOB, c_b and the speed at which the torques balance, from a solver good to 1e-9
    (10.0, 31649.0, 0.03, 8.768644096751),
    (20.0, NOMINAL, 0.03, 16.213565871),
    (10.0, NOMINAL, 150.0, 5.768533359),
    (10.0, NOMINAL, 0.03, 6.205186764),
]


@pytest.mark.parametrize(("omega", "weight", "damping", "speed"), STEADY)
def test_plant_started_in_equilibrium_stays_there(omega, weight, damping, speed):
    parameters = replace(PAPER, c_b=damping)
    balance = equilibrium(parameters, omega, weight)
    assert balance == pytest.approx(speed, abs=1e-9)
    start = replace(parameters, initial_speed=balance, initial_torque=torque_on_bit(parameters, weight, balance))
    run = follow(start, Program.constant(omega), Program.constant(weight), np.arange(1, 1001) * 0.1)
    for name in ("bit_speed", "top_speed", "bit_speed_min", "bit_speed_max"):
        assert np.abs(run[name] - balance).max() <= 1e-9, name
    assert run["bit_angle"] == pytest.approx(balance * run.times, rel=1e-10)
    assert (run["slip_count"] == 0).all()


@pytest.mark.parametrize(("omega", "weight", "damping", "speed"), STEADY[:3])
def test_plant_from_rest_settles_in_equilibrium(omega, weight, damping, speed):
    run = follow(replace(PAPER, c_b=damping), Program.constant(omega), Program.constant(weight), [139.0, 140.0])
    assert run["bit_speed"] == pytest.approx(speed, abs=2e-9)
    assert run["top_speed"] == pytest.approx(speed, abs=2e-9)


def test_nominal_point_has_two_lasting_motions():
    speed = equilibrium(PAPER, 10.0, NOMINAL)
    disturbed = replace(PAPER, initial_speed=speed + 0.1, initial_torque=torque_on_bit(PAPER, NOMINAL, speed))
    grid = np.arange(1, 3001) * 0.1
    running_on, from_rest = (follow(start, SPEED, WEIGHT, grid) for start in (disturbed, PAPER))
    assert running_on["slip_count"][-1] == 0
    assert running_on["bit_speed"][-100:] == pytest.approx(speed, abs=1e-3)
    assert from_rest["slip_count"][-1] > 90
    assert from_rest["bit_speed"][-100:].max() == pytest.approx(18.7605, abs=0.1)
