"""Limits in which the motion is known in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.oracle import OracleParameters, Program
from tests.plant.drive import follow
from tests.plant.programs import PAPER
from tests.plant.theory import torque_on_bit

IMMOVABLE = Program.constant(1e8)
"""A weight no string of the test breaks loose [N]."""


def test_waves_pass_a_top_that_asks_for_what_they_bring_unhindered():
    # the initial rotation and torque are those of a drive at Omega = v0 + tau0/c_a, whatever c_a
    for top in (120.0, PAPER.impedance, 1e6):
        start = replace(PAPER, c_a=top, c_b=50.0, initial_speed=7.0)
        torque = torque_on_bit(start, 2e4, 7.0)
        run = follow(
            replace(start, initial_torque=torque), Program.constant(7.0 + torque / top), Program.constant(2e4), [2.0]
        )
        assert run["top_speed"] == pytest.approx(7.0, abs=1e-9)
        assert run["top_torque"] == pytest.approx(torque, rel=1e-7)


@pytest.mark.parametrize("inertia", [5.0, 89.0])
def test_free_bit_answers_the_first_wave_like_a_mass_on_a_damper(inertia):
    # I_B v' = 2 Z D - (Z + c_b) v until the wave is back
    parameters = OracleParameters(I_B=inertia, c_b=40.0)
    run = follow(parameters, Program.constant(10.0), Program.constant(0.0), np.linspace(0.01, 1.11, 111))
    damping = parameters.impedance + parameters.c_b
    since = np.maximum(0.0, run.times - parameters.travel_time)
    push = 2 * parameters.impedance * parameters.transmission * 10.0 / damping
    assert run["bit_speed"] == pytest.approx(push * -np.expm1(-damping / inertia * since), abs=1e-9)
    angle = push * (since + inertia / damping * np.expm1(-damping / inertia * since))
    assert run["bit_angle"] == pytest.approx(angle, abs=1e-9)
    assert run["bit_torque"] == pytest.approx(parameters.c_b * run["bit_speed"], abs=1e-9)
    assert not run["bit_stuck"][run.times > parameters.travel_time].any()


@pytest.mark.parametrize("packaging", ["native", "python"])
def test_friction_that_fades_at_once_is_coulomb_friction(packaging):
    # I_B v' = tau0 - W R_b mu_cb - (Z + c_b) v, over pieces so long that no number of halvings follows the fading
    parameters = replace(PAPER, L=1e5, v_f=1e-6, initial_torque=2e6)
    grid = np.arange(1, 40) * 0.5
    drive, weight = Program.constant(2e6 / PAPER.c_a), Program.constant(1e7)
    run = follow(parameters, drive, weight, grid, cells=4, packaging=packaging)
    damping = parameters.impedance + parameters.c_b
    push = (2e6 - 1e7 * parameters.R_b * parameters.mu_cb) / damping
    assert run["bit_speed"] == pytest.approx(push * -np.expm1(-damping / parameters.I_B * grid), rel=1e-8)


def test_bit_at_rest_slips_at_once_under_more_than_the_static_torque():
    static = 97347.0 * PAPER.R_b * PAPER.mu_sb
    for torque, slips in ((static - 1.0, 0), (static + 1.0, 1), (-static - 1.0, 1), (1.0 - static, 0)):
        start = replace(PAPER, initial_torque=torque)
        # the drive of the torque: Omega = tau0 / c_a keeps the waves as they are
        run = follow(start, Program.constant(torque / PAPER.c_a), Program.constant(97347.0), [1e-3, 0.3])
        assert run["slip_count"].tolist() == [slips, slips]
        assert (run["bit_stuck"] == 1 - slips).all()
        assert (np.sign(run["bit_speed"]) == slips * np.sign(torque)).all()


def test_angles_differ_by_the_twist_that_the_torque_makes():
    # at rest under the torque tau0: y - w = tau0 L / (G J)
    torque = 8000.0
    start = replace(PAPER, initial_torque=torque)
    run = follow(start, Program.constant(torque / PAPER.c_a), IMMOVABLE, [1.0, 5.0])
    assert run["top_angle"] == pytest.approx(torque * PAPER.L / (PAPER.G * PAPER.J), rel=1e-12)
    assert (run["bit_angle"] == 0.0).all()
    assert run["bit_torque"] == pytest.approx(torque, rel=1e-12)
