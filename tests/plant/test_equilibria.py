"""Steady drilling: where it is, that it stays, and where it loses its stability."""

from __future__ import annotations

import math
from dataclasses import asdict, replace

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.oracle import OracleParameters, Program
from tests.plant.drive import PLANT, Drive, follow
from tests.plant.programs import PAPER, SPEED, WEIGHT
from tests.plant.theory import drive_of, equilibrium, root_near, running, torque_on_bit

NOMINAL = 97347.0
HEAVY = replace(PAPER, I_B=311.0)
STEADY = [
    # Omega, WOB, c_b and the speed at which the torques balance, from a solver good to 1e-9
    (10.0, 31649.0, 0.03, 8.768644096751),
    (20.0, NOMINAL, 0.03, 16.213565871),
    (10.0, NOMINAL, 150.0, 5.768533359),
    (10.0, NOMINAL, 0.03, 6.205186764),
]
THRESHOLDS = [
    # parameters, WOB, and Omega [rad/s], speed [rad/s] and frequency [rad/s] at which a pair of roots crosses the axis
    (PAPER, NOMINAL, 8.345275247, 4.520150, 2.473392),
    (PAPER, 31649.0, 4.541597865, None, None),
    (HEAVY, NOMINAL, 7.492695301, None, 1.464464),
]
AMPLITUDE = 1e-4
"""Of the perturbation: small against v_f / gamma_b, large against the errors [rad/s]."""


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


@pytest.mark.parametrize(("parameters", "weight", "omega", "speed", "frequency"), THRESHOLDS)
def test_roots_cross_the_axis_at_the_known_point(parameters, weight, omega, speed, frequency):
    guess = 1j * (frequency or 2.5)
    at = brentq(lambda w: root_near(parameters, weight, w, guess).real, 2.0, 5.0, xtol=1e-13)
    root = root_near(parameters, weight, at, guess)
    assert drive_of(parameters, weight, at) == pytest.approx(omega, abs=1e-8)
    if speed is not None:
        assert at == pytest.approx(speed, abs=1e-6)
    if frequency is not None:
        assert abs(root.imag) == pytest.approx(frequency, abs=1e-6)


def observed_rate(parameters: OracleParameters, weight: float, omega: float, root: complex) -> float:
    """Return the rate at which a disturbance of steady drilling grows [1/s], from its size in two spans of time."""
    speed = equilibrium(parameters, omega, weight)
    start = running(parameters, weight, speed) | {"initial_speed": speed + AMPLITUDE}
    period, sizes = 2 * math.pi / abs(root.imag), []
    with Drive(PLANT, asdict(parameters) | start) as plant:
        for first in (10, 60):  # periods; by then the other roots have faded
            deviations = []
            for k in range(400):
                plant.go((first + k / 20) * period)
                deviations.append(plant.get("bit_speed") - speed)
            sizes.append(math.log(np.sqrt(np.mean(np.square(deviations)))))
        assert plant.get("bit_speed_max") - plant.get("bit_speed_min") < 0.05
        assert plant.get("slip_count") == 0
    return (sizes[1] - sizes[0]) / (50 * period)


@pytest.mark.parametrize("margin", [-0.005, 0.005])
@pytest.mark.parametrize(("parameters", "weight", "omega"), [row[:3] for row in THRESHOLDS])
def test_disturbance_decays_above_the_threshold_and_grows_below(parameters, weight, omega, margin):
    drive = omega * (1 + margin)
    root = root_near(parameters, weight, equilibrium(parameters, drive, weight), 2.5j if parameters is PAPER else 1.46j)
    rate = observed_rate(parameters, weight, drive, root)
    assert math.copysign(1, rate) == -math.copysign(1, margin)
    assert rate == pytest.approx(root.real, rel=1e-3)
