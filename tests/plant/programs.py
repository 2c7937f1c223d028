"""Strings, and input programs that jump at times on no grid, for the plant to be driven with."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from tests.oracle import OracleParameters, OracleSolution, Program, solve

PAPER = OracleParameters()
SPEED, WEIGHT = Program.constant(10.0), Program.constant(97347.0)


def scattered(seed: int, count: int, end: float, low: float, high: float, first: float) -> Program:
    """Return steps between random values at random times."""
    random = np.random.default_rng(seed)
    times = np.sort(random.uniform(0.0, end, count))
    return Program.held([0.0, *times], [first, *random.uniform(low, high, count)])


@dataclass(frozen=True)
class Case:
    """A string, its inputs, how long they are followed [s], and how often the bit stops and turns back at least."""

    parameters: OracleParameters
    omega: Program
    wob: Program
    end: float
    stops: int = 0
    lowest: float = 0.0


CASES = {
    "stick-slip of figure 2": Case(PAPER, SPEED, WEIGHT, 100.0, stops=30),
    "inputs that jump on no grid": Case(
        PAPER, scattered(5, 15, 40.0, -15.0, 20.0, 10.0), scattered(6, 10, 40.0, 0.0, 6e4, 97347.0), 50.0, 5, -8.0
    ),
    "drive reversed": Case(PAPER, Program.held([0, 10.1234567, 30.7], [10, -12, 9]), WEIGHT, 50.0, 8, -10.0),
    "weight lifted off and set down": Case(
        PAPER, Program.held([0, 18.31], [10, 0]), Program.held([0, 9.7331, 12.9, 25.03], [9e4, 0, 9e4, 0]), 35.0, 2
    ),
    "weight lifted off while wound up": Case(
        PAPER, SPEED, Program.held([0, 2.5111, 6.0007, 15.13], [97347, 5000, 97347, 500]), 30.0, 1, -10.0
    ),
    "long string, heavy bit, weak drive": Case(
        replace(PAPER, L=3000.0, I_B=311.0, c_a=500.0),
        Program.held([0, 31.237, 47.01], [20, 2, 20]),
        Program.constant(38000.0),
        60.0,
        1,
    ),
    "short string, light bit, matched top": Case(
        replace(PAPER, L=200.0, I_B=20.0, c_a=PAPER.impedance),
        scattered(7, 12, 25.0, -15.0, 20.0, 10.0),
        scattered(8, 9, 25.0, 0.0, 3e4, 2e4),
        30.0,
        3,
        -1.0,
    ),
    "sharp friction": Case(
        replace(PAPER, gamma_b=1.0, v_f=0.3, c_a=5000.0), scattered(9, 5, 30.0, 2.0, 20.0, 10.0), WEIGHT, 40.0, 5
    ),
    "top softer than the string": Case(
        replace(PAPER, c_a=120.0),
        Program.held([0, 10.0031, 18.777], [80, 5, 80]),
        scattered(10, 6, 25.0, 5e3, 7e4, 3e4),
        30.0,
        1,
    ),
    "string that turns and is wound up": Case(
        replace(PAPER, initial_speed=6.2, initial_torque=7600.0),
        SPEED,
        Program.held([0, 7.7713], [97347, 120000]),
        40.0,
        5,
    ),
    "string that turns and is wound up the other way": Case(
        replace(PAPER, initial_torque=-25000.0, initial_speed=5.0),
        Program.constant(0.0),
        Program.held([0, 1.5003], [97347, 20000]),
        20.0,
        1,
        -20.0,
    ),
}

RAMPS = {
    "drive and weight on ramps": Case(
        PAPER,
        Program([0, 10.03, 15.1, 16.7], [0, 10.03, 10, 3], [1, 0, -0.2, 0.1]),
        Program([0, 3.07, 15.2, 20.3], [0, 30700, 97347, 97347], [10000, 4000, 0, -2000]),
        30.0,
        1,
    ),
    "drive through zero": Case(
        PAPER, Program([0, 6.021], [12, 12], [0, -1.7]), Program.constant(40000.0), 25.0, 1, -5.0
    ),
    "weight that grows until the bit stops": Case(
        replace(PAPER, initial_speed=8.768644096751, initial_torque=2462.7),
        SPEED,
        Program([0, 2.0017], [31649, 31649], [0, 9000]),
        20.0,
        1,
    ),
}


@cache
def solved(name: str) -> OracleSolution:
    """Return the oracle's solution of a case, to a little beyond its end."""
    case = (CASES | RAMPS)[name]
    return solve(case.parameters, case.omega, case.wob, case.end + 0.01)
