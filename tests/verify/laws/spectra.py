"""What the characteristic equation says of small motions, and what small motions of the plant do."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, replace
from functools import cache

import numpy as np
from scipy.optimize import brentq

from models.plant.parameters import DrillstringParameters
from models.theory.cycle.cycle import limit_cycle
from models.theory.stability.neutral_form import neutral_form
from models.theory.stability.spectrum import critical_omega, rightmost_roots
from tests.oracle import OracleParameters, Program
from tests.plant.drive import PLANT, Drive, follow
from tests.plant.theory import characteristic, drive_of, equilibrium, root_near, running
from tests.verify.finding import Finding, greatest, law

SECTION = "Spectra against small motions"
AMPLITUDE = 1e-4
"""Of a disturbance: small against v_f / gamma_b, large against the errors [rad/s]."""
POINTS = [(89.0, 97347.0), (89.0, 31649.0), (311.0, 97347.0)]
"""Inertia of the bit [kg m^2] and weight on it [N]."""
OTHERS = "what is left of the next roots when the motion is first looked at, after 10 periods"
MARGINS = (-0.005, 0.005)
"""How far from the threshold small motions are followed, as a part of the drive speed."""


def strings(inertia: float) -> tuple[DrillstringParameters, OracleParameters]:
    """Return the same string for the theory and for what judges it."""
    parameters = DrillstringParameters(I_B=inertia)
    return parameters, OracleParameters(**asdict(parameters))


@cache
def threshold(inertia: float, weight: float) -> float:
    """Return the bit speed [rad/s] at which a root of the judge's own equation crosses the axis."""
    _, string = strings(inertia)
    guess = 2.5j if inertia < 200.0 else 1.46j
    return brentq(lambda w: root_near(string, weight, w, guess).real, 2.0, 5.0, xtol=1e-13)


@law(SECTION)
def stability_is_lost_where_a_root_crosses_the_axis() -> Finding:
    """Rotation loses its stability at the drive speed at which a pair of roots crosses the imaginary axis"""
    errors, values = [], []
    for inertia, weight in POINTS:
        parameters, string = strings(inertia)
        values.append(critical_omega(parameters, weight))
        errors.append(values[-1] - drive_of(string, weight, threshold(inertia, weight)))
    compared = f"critical Ω {', '.join(f'{value:.9f}' for value in values)} and a secant method on (14)"
    return Finding(compared, greatest(errors), 1e-8, "nine digits after the point are given", "rad/s")


@law(SECTION)
def rightmost_roots_are_zeros_of_the_characteristic_equation() -> Finding:
    """The roots found are zeros of the equation that follows from (14), to rounding"""
    errors: list[complex] = []
    for inertia, weight in POINTS:
        parameters, string = strings(inertia)
        speed = equilibrium(string, 10.0, weight)
        for root in rightmost_roots(parameters, 10.0, weight, 12):
            errors.append(root_near(string, weight, speed, complex(root) + 1e-6) - root)
    compared = f"{len(errors)} roots and a secant method started beside them"
    return Finding(compared, greatest(errors), 1e-10, "ten digits are given", "1/s")


@law(SECTION)
def no_root_in_the_right_half_plane_is_missing() -> Finding:
    """The argument principle counts as many roots with growing motions as are found"""
    found, told = 0, []
    for inertia, weight in POINTS:
        parameters, string = strings(inertia)
        critical = critical_omega(parameters, weight)
        for part in (0.8, 0.9, 1.1):
            omega = part * critical
            roots = rightmost_roots(parameters, omega, weight, 8)
            told.append(int((roots.real > 0.0).sum()))
            found += abs(winding(string, weight, equilibrium(string, omega, weight)) - told[-1])
    return Finding(
        f"roots to the right: {', '.join(map(str, told))}; and turns of the phase", found, 0.0, "whole numbers"
    )


def winding(string: OracleParameters, weight: float, speed: float, reach: float = 300.0) -> int:
    """Return how often the phase of the characteristic equation turns along Re s = 0 and around the right half plane.

    The equation without its poles, which are to the left, is I_B s there where |s| is great: half a turn.
    """
    values = np.array([characteristic(string, weight, speed, 1j * w) for w in np.linspace(-reach, reach, 20_001)])
    along = np.unwrap(np.angle(values))
    far = np.angle(values[-1]) - np.angle(values[0])
    return round((far - (along[-1] - along[0])) / (2.0 * math.pi))


def deviations(string: OracleParameters, weight: float, omega: float, period: float) -> Iterator[np.ndarray]:
    """Yield how far a disturbed bit is from its equilibrium, over 20 periods from the 10th and from the 60th on."""
    speed = equilibrium(string, omega, weight)
    start = running(string, weight, speed) | {"initial_speed": speed + AMPLITUDE}
    with Drive(PLANT, asdict(string) | start) as plant:
        for first in (10, 60):  # by then the other roots have faded
            values = []
            for k in range(400):
                plant.go((first + k / 20) * period)
                values.append(plant.get("bit_speed") - speed)
            yield np.array(values)
        assert plant.get("slip_count") == 0


@cache
def observed(inertia: float, weight: float, margin: float) -> tuple[complex, complex, float]:
    """Return the rightmost root, what a small motion shows of it [1/s], and how much of other roots is left then."""
    parameters, string = strings(inertia)
    omega = critical_omega(parameters, weight) * (1.0 + margin)
    root, _, other = rightmost_roots(parameters, omega, weight, 3)
    period = 2.0 * math.pi / root.imag
    early, late = deviations(string, weight, omega, period)
    rate = math.log(np.sqrt(np.mean(late**2)) / np.sqrt(np.mean(early**2))) / (50 * period)
    # x[n + 1] + x[n - 1] = 2 cosh(s h) x[n], with the growth over a step divided out
    grown = late * np.exp(-rate * np.arange(len(late)) * period / 20)
    cosine = float(grown[1:-1] @ (grown[2:] + grown[:-2]) / (2.0 * grown[1:-1] @ grown[1:-1]))
    left = math.exp((other.real - root.real) * 10 * period)
    return root, complex(rate, math.acos(cosine) / (period / 20)), left


@law(SECTION)
def small_motions_grow_and_decay_as_the_rightmost_root_says() -> Finding:
    """Beside its equilibrium the plant moves away or returns at the rate of the rightmost root"""
    pairs = [observed(*point, margin) for point in POINTS for margin in MARGINS]
    found = greatest(seen.real / root.real - 1.0 for root, seen, _ in pairs)
    rates = ", ".join(f"{root.real:+.5f}" for root, *_ in pairs)
    allowed = max(left for *_, left in pairs)
    return Finding(f"rates {rates} 1/s and 50 periods of the plant, relative", found, allowed, OTHERS)


@law(SECTION)
def small_motions_swing_as_the_rightmost_root_says() -> Finding:
    """Beside its equilibrium the plant swings at the frequency of the rightmost root"""
    pairs = [observed(*point, margin) for point in POINTS for margin in MARGINS]
    found = greatest(seen.imag / root.imag - 1.0 for root, seen, _ in pairs)
    return Finding("frequencies at six points, relative", found, max(left for *_, left in pairs), OTHERS)


@law(SECTION)
def jump_of_the_drive_fades_by_the_difference_part() -> Finding:
    """A jump that runs to and fro shrinks by |Υ| in each round trip, in a period by |Υ|^(T / 2 Γ)"""
    parameters, string = strings(89.0)
    cycle, trip, begin = limit_cycle(parameters, 10.0, 97347.0), 2.0 * string.travel_time, 40.0
    returns = begin + trip * np.arange(1, 7)
    beside = np.sort(np.concatenate([returns - 1e-9, returns + 1e-9]))
    omega = Program.held([0.0, begin], [10.0, 10.5])
    speeds = dict(zip(beside, follow(string, omega, Program.constant(97347.0), beside)["top_speed"][-12:], strict=True))
    jumps = np.array([speeds[time + 1e-9] - speeds[time - 1e-9] for time in returns])
    per_period = (jumps[1:] / jumps[:-1]) ** (cycle.period / trip)
    found = greatest([per_period - cycle.difference_multiplier])
    reason = "the speed moves by 5e-8 rad/s between the instants around a return, and the least jump is 0.1 rad/s"
    return Finding(f"|Υ|^(T/2Γ) = {cycle.difference_multiplier:.6f} and five returns", found, 1e-6, reason)


@law(SECTION)
def formal_stability_is_the_decay_of_the_waves_alone() -> Finding:
    """Over a bit that cannot turn waves shrink by the radius of the difference operator of (17) squared"""
    errors = []
    for top in (20.0, 120.0, 2000.0, 20000.0):
        parameters = replace(DrillstringParameters(), c_a=top)
        string, trip = OracleParameters(**asdict(parameters)), 2.0 * parameters.travel_time
        pulse, sampled = Program.held([0.0, trip / 2], [10.0, 0.0]), (np.arange(1, 9) + 0.25) * trip
        run = follow(string, pulse, Program.constant(1e8), sampled).at(sampled)
        shares = np.abs(run["top_speed"][1:] / run["top_speed"][:-1])
        errors.append(shares - neutral_form(parameters).difference.radius ** 2)
    reason = "breaks weaker than 1e-9 rad/s are folded"
    return Finding("ρ² and the top speed, c_a = 20, 120, 2000, 20000", greatest(errors), 1e-9, reason)
