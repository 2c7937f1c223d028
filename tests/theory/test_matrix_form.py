"""Eqs. (17) to (20): the matrices are put to motions from the oracle, entry by entry, and their spectrum to (14)."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from models.theory.stability.neutral_form import NeutralForm, neutral_form
from tests.oracle import Program, solve
from tests.plant.judge import away_from
from tests.plant.theory import characteristic
from tests.theory.strings import NOMINAL, PAPER, oracle_of

PER_TRAVEL_TIME = 400
STEP = PAPER.travel_time / PER_TRAVEL_TIME
DIFFERENCE = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Weights of the central difference of order eight."""
BAR = 2e-7
"""Rounding of the oracle's speed, in a difference over a step, times Lambda^-1 I_B and the like [rad/s, rad/s^2]."""
JUMP = 30 * PER_TRAVEL_TIME + 123
MOTIONS = {
    "stick-slip": Program.held([0, JUMP * STEP], [10, 13]),
    "ramps": Program([0, JUMP * STEP], [10, 14], [0, -0.3]),
}


@cache
def motion(name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return x', x, Omega and torque at t, t - Gamma and t - 2 Gamma, at all times none of which is near a jump."""
    omega, count = MOTIONS[name], 60 * PER_TRAVEL_TIME
    times = np.arange(1, count) * STEP
    solution = solve(oracle_of(PAPER), omega, Program.constant(NOMINAL), times[-1])
    out = solution(times)
    acceleration = -np.convolve(out["bit_speed"], DIFFERENCE, "same") / STEP
    rates = np.stack([out["bit_speed"], acceleration, out["top_speed"]], axis=-1)
    states = np.stack([out["bit_angle"], out["bit_speed"], out["top_angle"]], axis=-1)
    drive = np.array([omega.line(time - 0.5 * STEP, time)[0] for time in times])
    echoes = np.arange(125) * PAPER.travel_time
    events = (omega.times, solution.stops, solution.releases)
    smooth = away_from(times, np.concatenate([time + echoes for group in events for time in group]), 5 * STEP)
    smooth[: 3 * PER_TRAVEL_TIME] = smooth[-10:] = False
    places = np.flatnonzero(smooth)[:, None] - PER_TRAVEL_TIME * np.arange(3)
    assert places.shape[0] > 3000
    return rates[places], states[places], drive[places], out["bit_torque"][places]


def worst(form: NeutralForm, name: str) -> np.ndarray:
    return np.abs(form.residual(*motion(name))).max(axis=0)


@pytest.mark.parametrize("name", MOTIONS)
def test_matrix_form_holds_along_motions(name):
    assert (worst(neutral_form(PAPER), name) < BAR).all()


@pytest.mark.parametrize("letter", "EABC")
def test_every_entry_is_needed_as_it_is(letter):
    form = neutral_form(PAPER)
    for place in np.ndindex(getattr(form, letter).shape):
        changed = getattr(form, letter).copy()
        changed[place] += 3e-6
        row = place[1]
        seen = max(worst(replace(form, **{letter: changed}), name)[row] for name in MOTIONS)
        assert seen > 10 * BAR, (letter, place)


def test_matrices_are_those_printed():
    form, upsilon = neutral_form(PAPER), PAPER.reflection
    big_lambda = PAPER.c_a + PAPER.impedance
    assert form.E[0] == pytest.approx(np.array([[0, 0, 0], [0, 0, 0], [0, -2 * PAPER.I_B / big_lambda, 0]]))
    assert form.E[1] == pytest.approx(np.diag([0, upsilon, -upsilon]))
    assert not form.A[1].any()


@pytest.mark.parametrize("slope", [-300.0, -15.3, 40.0])
def test_linearised_form_has_the_roots_of_14_of_the_angles_and_of_the_elimination(slope):
    """The determinant is s^2 (1 + Upsilon e) times the characteristic function of (14), (1 - Upsilon e) / I_B times."""
    system = neutral_form(PAPER).linearised(slope)
    for s in (0.3 + 2.5j, -0.2 + 9.0j, 1.7, -0.9 + 0.1j):
        echo = PAPER.reflection * np.exp(-2 * PAPER.travel_time * s)
        about = characteristic_with(slope, s) * (1 - echo) / PAPER.I_B
        assert np.linalg.det(system.characteristic(s)) == pytest.approx(s**2 * (1 + echo) * about, rel=1e-12)


def characteristic_with(slope: float, s: complex) -> complex:
    """Return the other tests' characteristic function of (14), for a bit without friction and of viscosity T'."""
    return characteristic(oracle_of(replace(PAPER, c_b=0.0)), 0.0, 1.0, s) + slope


def test_eigenvalues_of_the_generator_hold_both_spectra():
    slope = -15.3
    system = neutral_form(PAPER).linearised(slope)
    found = np.linalg.eigvals(system.generator(48))
    spurious = (np.log(PAPER.reflection) + 1j * np.pi) / (2 * PAPER.travel_time)
    from_14 = -0.20925 + 2.4966j
    for expected, accuracy in ((0.0, 1e-5), (spurious, 1e-9), (from_14, 1e-3)):
        assert np.abs(found - expected).min() < accuracy
