"""Limits in which the motion is known: no friction, no reflection, a bit that cannot turn, a rigid drive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tests.oracle import OracleParameters, Program
from tests.plant.drive import Trajectory, follow
from tests.plant.programs import PAPER, scattered
from tests.verify.finding import Finding, greatest, law

SECTION = "Limits"
IMMOVABLE = Program.constant(1e8)
"""A weight no string here breaks loose [N]."""
NOTHING = Program.constant(0.0)
TRUNCATION = 1e-6
"""What a piece of the plant's may leave out [rad/s]."""


def staircase(p: OracleParameters, times: np.ndarray, omega: float) -> tuple[np.ndarray, np.ndarray]:
    """Return top speed and torque on a bit that cannot turn: D grows by a geometric series, once a round trip."""
    trip = 2.0 * p.travel_time
    down = [0.0]
    for _ in range(int(times[-1] / trip) + 2):
        down.append(p.reflection * down[-1] + p.transmission * omega)
    trips, arrived = (times / trip).astype(int), ((times + p.travel_time) / trip).astype(int)
    waves = np.array(down)
    return waves[trips + 1] - waves[trips], 2.0 * p.impedance * waves[arrived]


@law(SECTION)
def waves_over_a_bit_that_cannot_turn_are_a_geometric_series() -> Finding:
    """Over an immovable bit the torque climbs a staircase of reflections"""
    errors = []
    for top in (120.0, 2000.0, 1e6):
        for step in (0.0137, 0.61):
            p = replace(PAPER, c_a=top)
            run = follow(p, Program.constant(10.0), IMMOVABLE, np.arange(1, int(11 / step)) * step)
            speed, torque = staircase(p, run.times, 10.0)
            errors += [(run["top_speed"] - speed) / 10.0, (run["top_torque"] - top * (10.0 - speed)) / (10.0 * top)]
            errors += [
                (run["bit_torque"] - torque) / torque.max(),
                run["bit_speed"],
                run["stuck_time"] / run.times - 1.0,
            ]
    compared = "speeds, torques and rest, relative, c_a = 120, 2000, 1e6"
    return Finding(compared, greatest(errors), 1e-12, "rounding in 15 round trips")


@law(SECTION)
def rigid_drive_winds_an_immovable_bit_up_by_2_z_omega_each_round_trip() -> Finding:
    """c_a to infinity: nothing slides, and each round trip adds 2 Z Ω to the torque"""
    p = replace(PAPER, c_a=1e9)
    run = follow(p, Program.constant(10.0), IMMOVABLE, np.arange(1, 800) * 0.0137)
    trips = ((run.times + p.travel_time) / (2.0 * p.travel_time)).astype(int)
    step = 2.0 * p.impedance * 10.0
    found = greatest([run["bit_torque"] / step - trips])
    allowed = float(trips[-1]) ** 2 * p.impedance / p.c_a
    reason = "the series (1 - Υ^n) / (1 - Υ) is short of n by n² Z / c_a"
    return Finding(f"torque on bit in steps, {trips[-1]} round trips, c_a = 1e9", found, allowed, reason, "steps")


@law(SECTION)
def top_of_the_strings_impedance_absorbs_every_wave() -> Finding:
    """c_a = Z: nothing comes back from the top, so one round trip after the last change nothing moves"""
    p = replace(PAPER, c_a=PAPER.impedance)
    run = follow(p, Program.held([0.0, 3.0003], [10.0, -4.0]), IMMOVABLE, np.arange(1, 800) * 0.0137)
    trip = 2.0 * p.travel_time
    late = run.times > 3.0004 + trip
    between, at_first = (run.times > trip) & (run.times < 3.0), run.times < trip
    errors = [run["top_speed"][late | between], run["bit_torque"][late] / (-4.0 * p.c_a) - 1.0]
    errors.append(run["top_speed"][at_first] - 5.0)
    return Finding("top speed [rad/s] and relative torque over an immovable bit", greatest(errors), 1e-12, "rounding")


@law(SECTION)
def free_bit_under_a_matched_top_is_a_mass_on_a_damper_for_ever() -> Finding:
    """c_a = Z, W = 0: one exponential, without echoes"""
    p = replace(PAPER, c_a=PAPER.impedance, c_b=40.0)
    run = follow(p, Program.constant(10.0), NOTHING, np.arange(1, 800) * 0.0137)
    damping = p.impedance + p.c_b
    since, rate = np.maximum(0.0, run.times - p.travel_time), damping / p.I_B
    end = p.impedance * 10.0 / damping
    errors = [run["bit_speed"] + end * np.expm1(-rate * since)]
    errors.append(run["bit_angle"] - end * (since + np.expm1(-rate * since) / rate))
    errors.append((run["bit_torque"] - p.c_b * run["bit_speed"]) / p.c_b)
    reason = "what a piece of the plant's may leave out"
    return Finding("bit speed, angle [rad] and torque / c_b over 11 s", greatest(errors), TRUNCATION, reason, "rad/s")


@law(SECTION)
def heavy_bit_takes_up_the_momentum_of_the_waves_over_an_immovable_one() -> Finding:
    """I_B to infinity: the bit's momentum is the torque in time that waves have on a bit that cannot turn"""
    p = replace(PAPER, I_B=1e6, c_b=0.0)
    run = follow(p, Program.constant(10.0), NOTHING, np.arange(1, 3001) * 0.001)
    arrivals = p.travel_time * np.arange(1, 9, 2)
    _, torques = staircase(p, arrivals + 1e-9, 10.0)
    steps = np.diff(torques, prepend=0.0)
    momentum = (steps * np.maximum(run.times[:, None] - arrivals, 0.0)).sum(axis=1)
    found = greatest([run["bit_speed"] - momentum / p.I_B])
    # a bit that gives way takes Z v from the torque, and each arrival brings 2 Z times as much again
    given_way = p.impedance * float(momentum.max()) / p.I_B * run.times[-1] / p.I_B
    allowed = given_way * (1.0 + 2.0 * len(arrivals))
    reason = "second order in 1 / I_B: Z times the bit's speed, and its echoes"
    return Finding(f"bit speed to {momentum.max() / p.I_B:.3f} rad/s, I_B = 1e6 kg m²", found, allowed, reason, "rad/s")


@law(SECTION)
def string_without_weight_adds_up_what_drives_it() -> Finding:
    """W = 0: the system is linear, the answer to a sum is the sum of the answers"""
    one, other = scattered(11, 8, 20.0, -15.0, 20.0, 10.0), scattered(12, 8, 20.0, -15.0, 20.0, -3.0)
    times = sorted({*one.times, *other.times})
    both = Program.held(times, [one.line(t + 1e-9, t)[0] + other.line(t + 1e-9, t)[0] for t in times])
    grid = np.arange(1, 1500) * 0.0137
    runs = [follow(PAPER, program, NOTHING, np.union1d(grid, times[1:])) for program in (one, other, both)]
    found = greatest(_surplus(name, runs) for name in ("bit_speed", "top_speed"))
    reason = "three times what a piece of the plant's may leave out"
    return Finding("two programs of jumps and their sum, both speeds", found, 3 * TRUNCATION, reason, "rad/s")


def _surplus(name: str, runs: Sequence[Trajectory]) -> np.ndarray:
    one, other, both = (run[name] for run in runs)
    return one + other - both


@law(SECTION)
def string_without_weight_settles_where_the_dampers_balance() -> Finding:
    """W = 0: in the end both ends turn with c_a Ω / (c_a + c_b)"""
    p = replace(PAPER, c_b=150.0)
    run = follow(p, Program.constant(10.0), NOTHING, [59.0, 60.0])
    end = p.c_a * 10.0 / (p.c_a + p.c_b)
    found = greatest(run[name] - end for name in ("bit_speed", "top_speed"))
    return Finding("both speeds after 60 s, c_b = 150", found, 1e-9, "breaks of 1e-9 rad/s are folded", "rad/s")
