"""What the plant does before waves have come back often: closed forms, worked out by hand."""

from __future__ import annotations

import math
from dataclasses import asdict, replace

import numpy as np

from tests.oracle import OracleParameters, Program
from tests.plant.drive import PLANT, Drive, follow
from tests.plant.programs import PAPER, SPEED, WEIGHT
from tests.verify.finding import Finding, greatest, law

SECTION = "Closed forms on the first intervals"
ROUNDING = 1e-13
"""Of a handful of sums of numbers of order one, relative."""
TRUNCATION = 1e-6
"""What a piece of the plant's may leave out [rad/s]."""
PIECE = "what a piece of the plant's may leave out"


@law(SECTION)
def top_answers_the_drive_at_once() -> Finding:
    """Until the first wave is back the top turns with c_a / (c_a + Z) of the drive's speed"""
    run = follow(PAPER, SPEED, WEIGHT, np.linspace(0.01, 1.98 * PAPER.travel_time, 90))
    found = greatest([run["top_speed"] - 10.0 * PAPER.transmission])
    return Finding("top speed over 0 < t < 2 Γ", found, 10 * ROUNDING, "rounding", "rad/s")


@law(SECTION)
def bit_rests_until_a_wave_arrives_and_then_feels_twice_its_torque() -> Finding:
    """A resting bit feels nothing for one travel time, then twice the torque of the wave"""
    grid = np.linspace(0.01, 2.98 * PAPER.travel_time, 140)
    run = follow(PAPER, SPEED, WEIGHT, grid)
    share = 2.0 * PAPER.impedance * PAPER.transmission * 10.0
    found = greatest([run["bit_torque"] - np.where(run.times > PAPER.travel_time, share, 0.0)])
    return Finding("torque on bit over 0 < t < 3 Γ", found, ROUNDING * share, "rounding", "N m")


def first_release(omega: float, weight: float) -> int:
    """Return after how many travel times a resting bit breaks loose: 2 Z D grows as a geometric series."""
    static, down, count = weight * PAPER.R_b * PAPER.mu_sb, 0.0, 1
    while True:
        down = PAPER.reflection * down + PAPER.transmission * omega
        if 2.0 * PAPER.impedance * down > static:
            return count
        count += 2


@law(SECTION)
def bit_breaks_loose_with_the_wave_that_exceeds_the_static_torque() -> Finding:
    """The bit of Fig. 2 breaks loose at an odd number of travel times, the first whose wave is strong enough"""
    errors, numbers = [], []
    for omega, weight in ((10.0, 97347.0), (10.0, 31649.0), (20.0, 97347.0), (7.0, 97347.0)):
        numbers.append(first_release(omega, weight))
        due = numbers[-1] * PAPER.travel_time
        run = follow(PAPER, Program.constant(omega), Program.constant(weight), [due + 0.01])
        errors.append(float(run["last_release_time"][0]) - due)
    compared = f"first release at {', '.join(map(str, numbers))} Γ in four points of operation"
    return Finding(compared, greatest(errors), 20 * ROUNDING, "rounding of times of some seconds", "s")


@law(SECTION)
def free_bit_answers_the_first_two_waves_like_a_mass_on_a_damper() -> Finding:
    """A bit without weight obeys two linear equations in turn, over Γ to 3 Γ and 3 Γ to 5 Γ"""
    errors = []
    for inertia in (5.0, 89.0, 311.0):
        p = replace(PAPER, I_B=inertia, c_b=40.0)
        grid = np.linspace(0.01, 4.99 * p.travel_time, 400)
        run = follow(p, Program.constant(10.0), Program.constant(0.0), grid)
        errors.append(run["bit_speed"] - _free_bit(p, run.times))
    return Finding("bit speed to 5 Γ, I_B = 5, 89, 311 kg m²", greatest(errors), TRUNCATION, PIECE, "rad/s")


def _free_bit(p: OracleParameters, times: np.ndarray) -> np.ndarray:
    """I_B v' = 2 Z D(t - Γ) - (Z + c_b) v, with D = b Ω and then D = b Ω - Y (v(t - 2 Γ) - b Ω), b = c_a/(c_a + Z)."""
    k, push = (p.impedance + p.c_b) / p.I_B, 2.0 * p.impedance / p.I_B
    wave = 10.0 * p.transmission
    first = np.maximum(times - p.travel_time, 0.0)
    steady = push * wave / k
    speed = steady * -np.expm1(-k * first)
    second = np.maximum(times - 3.0 * p.travel_time, 0.0)
    at_second = steady * -np.expm1(-k * 2.0 * p.travel_time)
    end = push * (wave * (1.0 + p.reflection) - p.reflection * steady) / k
    slope = push * p.reflection * steady
    later = end + (at_second - end) * np.exp(-k * second) + slope * second * np.exp(-k * second)
    return np.where(times > 3.0 * p.travel_time, later, speed)


@law(SECTION)
def bit_under_constant_friction_goes_through_zero_to_rest_as_exponentials_say() -> Finding:
    """Without reflection and with constant friction every slip is an exponential, forwards, backwards and to rest"""
    p = replace(PAPER, c_a=PAPER.impedance, mu_cb=0.6, mu_sb=0.6)
    z, away, damping = p.impedance, p.travel_time, p.impedance + p.c_b
    friction, rate, back, rest = 0.6 * p.R_b * 30000.0, damping / p.I_B, 6.0, 9.0
    forward = (20.0 * z - friction) / damping * -math.expm1(-rate * back)
    pull = (20.0 * z + friction) / damping
    crossing = back + away + math.log1p(forward / pull) / rate
    reverse = (friction - 20.0 * z) / damping * -math.expm1(-rate * (rest + away - crossing))
    stop = rest + away + math.log1p(-reverse * damping / (friction - z)) / rate
    omega = Program.held([0.0, back, rest], [20.0, -20.0, -1.0])
    times = np.array([back + away, rest + away, 14.0])
    run = follow(p, omega, Program.constant(30000.0), times).at(times)
    errors = [run["bit_speed"] - [forward, reverse, 0.0], run["last_stop_time"][-1] - stop]
    return Finding("speeds at three instants [rad/s] and the time of the stop [s]", greatest(errors), TRUNCATION, PIECE)


@law(SECTION)
def wave_in_a_string_that_turns_stays_as_it_is() -> Finding:
    """Uniform rotation under the torque that holds it goes on for ever"""
    torque, speed = 7589.626471, 6.0
    p = replace(PAPER, c_b=torque / speed, initial_speed=speed, initial_torque=torque)
    with Drive(PLANT, asdict(p) | {"Omega": speed + torque / p.c_a, "WOB": 0.0}) as plant:
        plant.go(30.0)
        found = greatest(plant.get(name) - speed for name in ("bit_speed_min", "bit_speed_max", "top_speed"))
    reason = "breaks of 1e-9 rad/s are folded"
    return Finding("speeds within 30 s, c_b alone holding the bit", found, 1e-9, reason, "rad/s")
