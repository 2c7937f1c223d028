"""Symmetry under reversal, and dimensional analysis."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tests.oracle import OracleParameters, Program
from tests.plant.drive import RANGE, Trajectory, follow
from tests.plant.judge import BARS
from tests.plant.programs import CASES, RAMPS, Case
from tests.verify.finding import Finding, greatest, law

SYMMETRY, SCALING = "Symmetry", "Dimensional analysis"
STEP = 0.0137
ODD = ("bit_speed", "top_speed", "bit_torque", "top_torque", "bit_angle", "top_angle")
UNITS = {"feet, pounds and 6 s": (1 / 0.3048, 1 / 0.45359237, 1 / 6), "2.7 m, 0.19 kg and 0.48 s": (0.37, 5.3, 2.1)}
"""What a metre, a kilogram and a second measure in other units."""
SCALED = ("stick-slip of figure 2", "drive reversed", "weight lifted off while wound up")
END = 20.0
"""Of the runs that are scaled [s]."""


def scaled(program: Program, value: float, time: float = 1.0) -> Program:
    """Return a program with other values, at other times."""
    times = [time * at for at in program.times]
    slopes = [value / time * slope for slope in program.slopes]
    return Program(times, [value * one for one in program.values], slopes)


def mirrored(case: Case) -> Case:
    """Return a case that turns the other way."""
    p = case.parameters
    turned = replace(p, initial_speed=-p.initial_speed, initial_torque=-p.initial_torque)
    return replace(case, parameters=turned, omega=scaled(case.omega, -1.0))


@law(SYMMETRY)
def turning_the_other_way_is_the_mirror_image_bit_for_bit() -> Finding:
    """With Ω and the start reversed all speeds, torques and angles are reversed, and nothing else changes"""
    differ = 0
    for case in (CASES | RAMPS).values():
        grid = np.arange(1, int(case.end / STEP)) * STEP
        run, image = (follow(c.parameters, c.omega, c.wob, grid, cells=150) for c in (case, mirrored(case)))
        differ += sum(int((run[name] != -image[name]).sum()) for name in ODD)
        differ += int((run["bit_speed_min"] != -image["bit_speed_max"]).sum())
        differ += sum(int((run[name] != image[name]).sum()) for name in set(run.names) - {*ODD, *RANGE})
    return Finding(
        f"all outputs in {len(CASES | RAMPS)} cases", differ, 0.0, "equality: a change of sign rounds nothing", "values"
    )


def in_units(p: OracleParameters, length: float, mass: float, time: float) -> OracleParameters:
    """Return the same string measured in other units."""
    torque = mass * length**2 / time**2
    units = {
        "G": mass / (length * time**2), "J": length**4, "I": mass * length, "L": length, "I_B": mass * length**2,
        "c_a": torque * time, "c_b": torque * time, "R_b": length, "v_f": 1 / time,
        "initial_speed": 1 / time, "initial_torque": torque,
    }  # fmt: skip
    return replace(p, **{name: getattr(p, name) * unit for name, unit in units.items()})


@law(SCALING)
def motion_does_not_depend_on_the_units_of_length_mass_and_time() -> Finding:
    """A string measured in other units moves alike: no length, mass or time is hidden in the equations"""
    errors = []
    for length, mass, time in UNITS.values():
        for name in SCALED:
            case, grid = CASES[name], np.arange(1, int(END / STEP)) * STEP
            force = mass * length / time**2
            run = follow(case.parameters, case.omega, case.wob, grid, cells=800)
            omega, weight = scaled(case.omega, 1 / time, time), scaled(case.wob, force, time)
            other = follow(in_units(case.parameters, length, mass, time), omega, weight, time * grid, cells=800)
            kept = np.isin(run.times, grid)
            same = np.interp(grid, other.times / time, other["bit_speed"] * time)
            errors.append(run["bit_speed"][kept] - same)
    reason = "the plant's bar in both units of time"
    allowed = (1.0 + max(time for _, _, time in UNITS.values())) * BARS["bit_speed"]
    return Finding(
        f"bit speed of {len(SCALED)} cases in {'; in '.join(UNITS)}", greatest(errors), allowed, reason, "rad/s"
    )


@law(SCALING)
def motion_depends_on_the_string_by_impedance_and_travel_time_alone() -> Finding:
    """I, GJ and L matter by √(IGJ) and L √(I/GJ) only"""
    grid, errors = np.arange(1, int(END / STEP)) * STEP, []
    for name in SCALED:
        case = CASES[name]
        p = case.parameters
        run = follow(p, case.omega, case.wob, grid)
        for factor in (0.31, 1.9):
            other = replace(p, I=p.I / factor, G=p.G * math.sqrt(factor), J=p.J * math.sqrt(factor), L=p.L * factor)
            errors.append(_difference(run, follow(other, case.omega, case.wob, grid)))
    reason = "parameters differ by rounding, which stick-slip magnifies; the plant's bar"
    return Finding(
        f"bit and top speed of {len(SCALED)} cases, twice", greatest(errors), BARS["bit_speed"], reason, "rad/s"
    )


@law(SCALING)
def weight_radius_and_friction_matter_by_their_product_alone() -> Finding:
    """W, R_b and the coefficients of friction matter by W R_b mu only"""
    grid, errors = np.arange(1, int(END / STEP)) * STEP, []
    for name in SCALED:
        case = CASES[name]
        p = case.parameters
        run = follow(p, case.omega, case.wob, grid)
        other = replace(p, R_b=p.R_b / 0.7, mu_cb=p.mu_cb / 2.0, mu_sb=p.mu_sb / 2.0)
        errors.append(_difference(run, follow(other, case.omega, scaled(case.wob, 1.4), grid)))
    reason = "parameters differ by rounding, which stick-slip magnifies; the plant's bar"
    return Finding(f"bit and top speed of {len(SCALED)} cases", greatest(errors), BARS["bit_speed"], reason, "rad/s")


def _difference(run: Trajectory, other: Trajectory) -> float:
    return greatest(run[name] - other[name] for name in ("bit_speed", "top_speed"))


@law(SCALING)
def all_speeds_scale_with_the_speed_of_friction() -> Finding:
    """With Ω, v_f, W and the start multiplied by one factor the motion is multiplied by it"""
    grid, errors, factor = np.arange(1, int(END / STEP)) * STEP, [], 1.7
    for name in SCALED:
        case = CASES[name]
        p = case.parameters
        run = follow(p, case.omega, case.wob, grid)
        other = replace(
            p, v_f=factor * p.v_f, initial_speed=factor * p.initial_speed, initial_torque=factor * p.initial_torque
        )
        more = follow(other, scaled(case.omega, factor), scaled(case.wob, factor), grid)
        errors.append(factor * run["bit_speed"] - more["bit_speed"])
    reason = "the plant's bar, on both sides"
    allowed = (1.0 + factor) * BARS["bit_speed"]
    return Finding(f"bit speed of {len(SCALED)} cases, {factor} times", greatest(errors), allowed, reason, "rad/s")
