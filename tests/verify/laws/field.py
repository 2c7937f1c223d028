"""The plant against finite elements along the string, which know no delays."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from tests.oracle import OracleParameters, Program
from tests.oracle.elements import FieldSolution, solve_field
from tests.plant.drive import Trajectory, follow
from tests.plant.programs import PAPER
from tests.verify.finding import Finding, greatest, law

SECTION = "Independent solver of the partial differential equation"
COARSE, FINE = 16, 32
REASON = "what halving the elements changes: the finer solution's own error is below that"
RAMP = Program((0.0, 2.5), (0.0, 10.0), (4.0, 0.0))
"""Brought up to 10 rad/s on a ramp, so that no jump runs through elements."""
RIGID = 1e9
"""A damping of the top that lets it slide by 1e-5 rad/s under 10 kN m [N m s/rad]."""


@cache
def both(case: str) -> tuple[Trajectory, FieldSolution, FieldSolution]:
    """Return the plant, and the elements' solution on both meshes."""
    parameters, omega, weight, end, rigid = _case(case)
    grid = np.arange(1, int(end / 0.0137) + 1) * 0.0137
    run = follow(parameters, omega, weight, grid)
    times = run.times
    return run, *(solve_field(parameters, omega, weight, times, elements=n, rigid=rigid) for n in (COARSE, FINE))


def _case(case: str) -> tuple[OracleParameters, Program, Program, float, bool]:
    nominal = Program.constant(97347.0)
    match case:
        case "stick-slip":
            return PAPER, RAMP, nominal, 12.0, False
        case "reversal":
            turning = Program((0.0, 2.5, 6.0, 8.0), (0.0, 10.0, 10.0, -6.0), (4.0, 0.0, -8.0, 0.0))
            return replace(PAPER, c_b=30.0), turning, Program.constant(4e4), 12.0, False
        case _:
            return replace(PAPER, c_a=RIGID), RAMP, nominal, 9.0, True


def differences(case: str, output: str) -> tuple[float, float]:
    """Return how far the plant is from the finer solution, and that from the coarser."""
    run, coarse, fine = both(case)
    values = getattr(fine, output)
    return greatest([run[output] - values]), greatest([getattr(coarse, output) - values])


@law(SECTION)
def bit_turns_as_in_the_field_equation() -> Finding:
    """The bit sticks and slips as eqs. (1)-(4) say without any reduction to delays"""
    found, allowed = differences("stick-slip", "bit_speed")
    return Finding(f"bit speed, 12 s of stick-slip, {FINE} elements of degree 6", found, allowed, REASON, "rad/s")


@law(SECTION)
def top_turns_as_in_the_field_equation() -> Finding:
    """The top turns as eqs. (1)-(4) say"""
    found, allowed = differences("stick-slip", "top_speed")
    return Finding(f"top speed, 12 s of stick-slip, {FINE} elements of degree 6", found, allowed, REASON, "rad/s")


@law(SECTION)
def energy_is_that_of_the_field() -> Finding:
    """The energy of the waves is (7), the integral over the string"""
    found, allowed = differences("stick-slip", "energy")
    return Finding("energy output and (7) integrated over the elements", found, allowed, REASON, "J")


@law(SECTION)
def reversal_is_that_of_the_field_equation() -> Finding:
    """A drive that turns back takes the bit with it as eqs. (1)-(4) say"""
    found, allowed = differences("reversal", "bit_speed")
    run, *_ = both("reversal")
    lowest = run["bit_speed"].min()
    return Finding(f"bit speed, down to {lowest:.1f} rad/s, c_b = 30, 40 kN", found, allowed, REASON, "rad/s")


@law(SECTION)
def rigid_drive_is_the_limit_of_the_top_damping() -> Finding:
    """For c_a to infinity the top turns with the drive"""
    found, allowed = differences("rigid top", "bit_speed")
    compared = f"bit speed at c_a = {RIGID:.0e} and with the top's speed prescribed in the field equation"
    return Finding(compared, found, allowed, REASON, "rad/s")
