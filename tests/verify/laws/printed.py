"""Eqs. (14) and (15) as the paper prints them (GL read as GJ), put to the outputs of the plant.

Derivatives are differences of outputs at communication points that a travel time is a multiple of, on stretches where
nothing jumps: away from stops, releases, jumps of Omega, and the echoes of all of them.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from tests.oracle import Program, solve
from tests.plant.drive import Trajectory, follow
from tests.plant.judge import BARS, away_from
from tests.plant.programs import PAPER
from tests.plant.theory import torque_on_bit
from tests.verify.finding import Finding, greatest, law

SECTION = "Residuals of the printed equations"
REASON = "what errors of 1e-6 rad/s and 1e-3 N m, the plant's bars, make of both sides and of derivatives"
PER_TRAVEL_TIME = 400
GAMMA, Z = PAPER.travel_time, PAPER.impedance
STEP = GAMMA / PER_TRAVEL_TIME
DIFFERENCE = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Weights of the central difference of order eight."""
ACCELERATION_BAR = float(np.abs(DIFFERENCE).sum()) * BARS["bit_speed"] / STEP
"""What errors of the speed within their bar can make of its derivative [rad/s^2]."""
FADED = 1e-8
"""An echo is waited out until this much is left of a jump."""
SAMPLES = 80 * PER_TRAVEL_TIME
JUMP = 41 * PER_TRAVEL_TIME + 123
"""The sample at which Omega changes."""
CASES = {
    "stick-slip": (Program.held([0, JUMP * STEP], [10, 13]), 97347.0),
    "steady drilling": (Program.held([0, JUMP * STEP], [10, 9]), 31649.0),
    "reversal": (Program.held([0, JUMP * STEP], [10, -12]), 97347.0),
}


@cache
def samples(name: str) -> tuple[Trajectory, np.ndarray]:
    """Return the outputs, and where neither they nor their neighbours in a difference are near a jump."""
    omega, weight = CASES[name]
    run = follow(PAPER, omega, Program.constant(weight), np.arange(1, SAMPLES) * STEP)
    solution = solve(PAPER, omega, Program.constant(weight), float(run.times[-1]))
    echoes = np.arange(int(2 * np.log(FADED) / np.log(PAPER.reflection))) * GAMMA
    marks = [event + echoes for event in (*omega.times, *solution.stops, *solution.releases, *solution.crossings)]
    smooth = away_from(run.times, np.concatenate(marks), 5 * STEP)
    smooth[: 3 * PER_TRAVEL_TIME] = smooth[-10:] = False
    return run, smooth


def before(values: np.ndarray, delays: int) -> np.ndarray:
    """Return values some travel times earlier; in the first places, values that are not asked for."""
    return np.roll(values, delays * PER_TRAVEL_TIME)


def acceleration(run: Trajectory) -> np.ndarray:
    """Return the derivative of the bit speed [rad/s^2]."""
    return -np.convolve(run["bit_speed"], DIFFERENCE, "same") / STEP


def drive(name: str, run: Trajectory) -> np.ndarray:
    """Return Omega up to each communication point [rad/s]."""
    omega = CASES[name][0]
    return np.array([omega.line(time - 0.5 * STEP, time)[0] for time in run.times])


def torque(name: str, run: Trajectory) -> np.ndarray:
    """Eqs. (3) and (4) while the bit turns; while it rests, what holds it [N m]."""
    stuck = run["bit_stuck"] == 1
    speeds = np.where(stuck, 1.0, run["bit_speed"])
    law = np.array([torque_on_bit(PAPER, CASES[name][1], speed) for speed in speeds])
    return np.where(stuck, run["bit_torque"], law)


@law(SECTION)
def equation_14_holds_as_printed() -> Finding:
    """Paper (14) holds along motions of the bit"""
    errors, accelerations = [], []
    upsilon, psi = PAPER.reflection, Z / PAPER.I_B
    for name in CASES:
        run, smooth = samples(name)
        w, a, t = run["bit_speed"], acceleration(run), torque(name, run)
        left = a - upsilon * before(a, 2) + psi * w + psi * upsilon * before(w, 2)
        right = (upsilon * before(t, 2) - t) / PAPER.I_B + 2 * psi * PAPER.transmission * before(drive(name, run), 1)
        errors.append((left - right)[smooth])
        accelerations.append(a[smooth])
    allowed = (1 + upsilon) * (ACCELERATION_BAR + psi * BARS["bit_speed"] + BARS["bit_torque"] / PAPER.I_B)
    compared = f"both sides in {', '.join(CASES)}; accelerations to {greatest(accelerations):.0f} rad/s²"
    return Finding(compared, greatest(errors), allowed, REASON, "rad/s²")


@law(SECTION)
def equation_15_holds_as_printed() -> Finding:
    """Paper (15) holds along motions of the top"""
    errors, reaches, big_lambda = [], [], PAPER.c_a + Z
    for name in CASES:
        run, smooth = samples(name)
        omega, y = drive(name, run), run["top_speed"]
        left = y + PAPER.reflection * before(y, 2)
        right = PAPER.transmission * (omega + before(omega, 2))
        right = right - 2 / big_lambda * (PAPER.I_B * before(acceleration(run), 1) + before(torque(name, run), 1))
        errors.append((left - right)[smooth])
        reaches.append(np.ptp(y[smooth]))
    allowed = 2 * BARS["top_speed"] + 2 / big_lambda * (PAPER.I_B * ACCELERATION_BAR + BARS["bit_torque"])
    compared = f"both sides in {', '.join(CASES)}; speeds over {greatest(reaches):.0f} rad/s"
    return Finding(compared, greatest(errors), allowed, REASON, "rad/s")


@law(SECTION)
def torque_on_a_slipping_bit_is_that_of_equations_3_and_4() -> Finding:
    """Paper (3) and (4) give the torque on a bit that slips"""
    errors = []
    for name in CASES:
        run, _ = samples(name)
        slips = (run["bit_stuck"] == 0) & (run["bit_speed"] != 0.0)
        errors.append((torque(name, run) - run["bit_torque"])[slips])
    return Finding(f"torque on bit in {', '.join(CASES)}", greatest(errors), 1e-9, "rounding of some 10 kN m", "N m")


@law(SECTION)
def torque_on_a_resting_bit_is_at_most_the_static_one() -> Finding:
    """A bit is held by no more than W R_b mu_sb, in stick-slip up to just that"""
    errors = []
    for name, (_, weight) in CASES.items():
        run, _ = samples(name)
        excess = np.abs(run["bit_torque"]) - weight * PAPER.R_b * PAPER.mu_sb
        errors.append(np.maximum(excess, 0.0)[(run["bit_stuck"] == 1) & (run.times > 0.0)])
    return Finding("excess over the static torque", greatest(errors), 1e-9, "rounding of some 10 kN m", "N m")
