"""Eqs. (5) to (8) in normalised form, along a motion of the oracle, whose physics is in physical form."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from models.theory.stability.normalised_form import NormalisedForm
from tests.oracle import OracleParameters, OracleSolution, Program, solve
from tests.plant.judge import away_from
from tests.theory.strings import NOMINAL, PAPER, oracle_of

STRINGS = {
    "paper": PAPER,
    "damped bit, softer top": replace(PAPER, c_b=65.0, c_a=1500.0),
    "short": replace(PAPER, L=400.0),
}
OMEGA = Program((0.0, 3.0), (0.0, 12.0), (4.0, 0.0))
"""Brought up on a ramp, so that no wave jumps."""
END = 14.0
GAP = 1e-4
FIRST = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / (12.0 * GAP)
"""Of values at t - 2 gaps ... t + 2 gaps: the derivative, of order four."""


@dataclass(frozen=True)
class Motion:
    """A motion of the string from what goes on at its top, by d'Alembert's solution, paper (13)."""

    string: OracleParameters
    solution: OracleSolution

    def waves(self, sigma: np.ndarray, time: float | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the speeds of the waves up and down at places of the string."""
        z, travel = self.string.impedance, self.string.travel_time * sigma
        ahead, back = self.solution(time + travel), self.solution(time - travel)
        up = (ahead["top_speed"] - ahead["top_torque"] / z) / 2
        return up, (back["top_speed"] + back["top_torque"] / z) / 2

    def slope(self, sigma: np.ndarray, time: float | np.ndarray) -> np.ndarray:
        """Return z_s, which is L p (phi' - psi')."""
        up, down = self.waves(sigma, time)
        return self.string.travel_time * (up - down)

    def speed(self, sigma: np.ndarray, time: float | np.ndarray) -> np.ndarray:
        """Return z_t [rad/s]."""
        up, down = self.waves(sigma, time)
        return up + down

    def kinks(self) -> np.ndarray:
        """Return when anything at an end of the string may have a kink [s]."""
        found = self.solution
        events = [[0.0], OMEGA.times, found.stops, found.releases, found.crossings]
        echoes = np.arange(END // self.string.travel_time + 2) * self.string.travel_time
        return np.add.outer(np.concatenate(events), echoes).ravel()

    def smooth_times(self) -> np.ndarray:
        times = np.random.default_rng(3).uniform(1.0, END - 1.0, 120)
        return times[away_from(times, self.kinks(), 5 * GAP)]


@cache
def motion(name: str) -> Motion:
    string = oracle_of(STRINGS[name])
    return Motion(string, solve(string, OMEGA, Program.constant(NOMINAL), END))


@cache
def form(name: str) -> NormalisedForm:
    return NormalisedForm.of(STRINGS[name], NOMINAL)


def friction(name: str, time: float) -> float:
    """Return mu_b sgn, or what takes its place at rest, from the torque on bit."""
    string, now = STRINGS[name], motion(name).solution(time)
    return float((now["bit_torque"] - string.c_b * now["bit_speed"]) / (NOMINAL * string.R_b))


@pytest.mark.parametrize("name", STRINGS)
def test_equation_5_holds_inside_the_string(name):
    moving, stencil = motion(name), GAP * np.arange(-2, 3)
    travel = moving.string.travel_time
    times, sigma = (axis.ravel() for axis in np.meshgrid(moving.smooth_times(), np.linspace(0.05, 0.95, 7)))
    clear = [away_from(times + side * sigma * travel, moving.kinks(), 5 * GAP) for side in (1, -1)]
    times, sigma = (axis[clear[0] & clear[1], None] for axis in (times, sigma))
    by_time = moving.speed(sigma, times + stencil) @ FIRST
    by_place = moving.slope(sigma + stencil / travel, times) @ FIRST * travel
    assert len(by_time) > 300
    assert np.abs(by_time).max() > 1.0
    assert form(name).a * by_place == pytest.approx(by_time, abs=1e-6 * np.abs(by_time).max())


@pytest.mark.parametrize("name", STRINGS)
def test_equations_6_hold_at_the_ends(name):
    moving, stencil = motion(name), GAP * np.arange(-2, 3)
    stuck = []
    for time in moving.smooth_times():
        now = moving.solution(time)
        omega = OMEGA.line(time, time)[0]
        top, bit = moving.slope(np.array([0.0, 1.0]), time)
        assert form(name).top_slope(now["top_speed"], omega) == pytest.approx(top, abs=1e-9)
        acceleration = FIRST @ moving.solution(time + stencil)["bit_speed"]
        assert form(name).bit_slope(now["bit_speed"], friction(name, time), acceleration) == pytest.approx(
            bit, abs=1e-6
        )
        stuck.append(bool(now["bit_stuck"]))
    assert 0 < sum(stuck) < len(stuck)


@pytest.mark.parametrize("name", STRINGS)
def test_energy_7_and_its_rate_8_are_those_of_the_physical_string(name):
    moving, unit = motion(name), form(name).unit
    places, weights = composite_gauss(400, 6)
    for time in moving.smooth_times()[:40]:
        now, omega = moving.solution(time), OMEGA.line(time, time)[0]
        slopes, speeds = moving.slope(places, time), moving.speed(places, time)
        energy = unit * form(name).energy(slopes, speeds, weights, float(now["bit_speed"]))
        assert energy == pytest.approx(float(now["energy"]), rel=1e-6)
        ends = float(now["top_speed"]), float(now["bit_speed"])
        rate = unit * form(name).energy_rate(speeds, weights, ends, friction(name, time), omega)
        seen = FIRST @ moving.solution(time + GAP * np.arange(-2, 3))["energy"]
        assert rate == pytest.approx(seen, rel=1e-6, abs=1e-2)


def composite_gauss(cells: int, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points and weights over (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    places = (np.arange(cells)[:, None] + (nodes + 1) / 2) / cells
    return places.ravel(), np.tile(weights / 2 / cells, cells)


def test_damping_along_the_string_is_lost_as_equation_8_says():
    """A rigid rotation at w under beta loses beta L w^2."""
    damped = NormalisedForm.of(PAPER, 0.0, beta=0.3)
    places, weights = composite_gauss(3, 4)
    speeds = np.full(places.size, 5.0)
    rate = damped.unit * damped.energy_rate(speeds, weights, (0.0, 0.0), 0.0, 0.0)
    assert rate == pytest.approx(-0.3 * PAPER.L * 25.0, rel=1e-12)


def test_proposition_1_is_a_square_completed():
    """With law (9), dE/dt is the negative square printed below it, whatever the speeds."""
    form, c_1, c_2, wanted = NormalisedForm.of(replace(PAPER, c_b=65.0), NOMINAL), 0.3, 2.0, 10.0
    none, ratio = np.zeros(0), form.k / form.g
    for top, bit, mu in np.random.default_rng(5).uniform((0.5, -20, 0.5), (20, 20, 0.8), (50, 3)):
        omega = c_1 * top + 2 * math.sqrt(ratio * (1 - c_1)) * bit + 2 * math.sqrt(c_2 * (1 - c_1)) * wanted
        omega -= (c_2 * wanted**2 + 2 * math.sqrt(c_2 * ratio) * bit * wanted) / top
        square = math.sqrt(1 - c_1) * top - math.sqrt(ratio) * bit - math.sqrt(c_2) * wanted
        friction = math.copysign(mu, bit)
        due = -2 * form.a * (form.q * mu * abs(bit) + form.g * square**2)
        assert form.energy_rate(none, none, (top, bit), friction, omega) == pytest.approx(due, rel=1e-9)


@pytest.mark.parametrize(("values", "message"), [((-1.0, 0.0), "WOB is -1.0"), ((0.0, math.nan), "beta is nan")])
def test_nonsense_is_refused(values, message):
    with pytest.raises(ValueError, match=message):
        NormalisedForm.of(PAPER, *values)
