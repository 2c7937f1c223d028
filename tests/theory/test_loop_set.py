"""The set on which law (9) as printed has a solution with the sliding top, against a search along the top speed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from models.controllers.laws import DissipativeLaw
from models.plant.parameters import DrillstringParameters
from models.theory.loop_set import PrintedLoop
from tests.theory.strings import PAPER

LAW = DissipativeLaw()
CASES = {
    "paper": (PAPER, LAW, 10.0),
    "backwards": (PAPER, LAW, -7.0),
    "damped bit": (replace(PAPER, c_b=150.0), replace(LAW, c_b=150.0), 10.0),
    "soft top": (replace(PAPER, c_a=120.0, c_b=10.0), replace(LAW, c_a=120.0, c_b=10.0), 3.0),
    "hard top": (replace(PAPER, c_a=2e4), replace(LAW, c_a=2e4, c_1=-1.5, c_2=0.2), 12.0),
    "nearly one": (PAPER, replace(LAW, c_1=0.95, c_2=5.0), 10.0),
}
BITS = (-6.0, 0.0, 11.0)
WIDEST = 1e5
"""Of top speeds searched, rad/s."""


@dataclass(frozen=True)
class Search:
    """The torque the sliding passes on, less the torque that string and wave ask for, over top speeds of one sign."""

    string: DrillstringParameters
    law: DissipativeLaw
    speed_ref: float
    bit: float

    def surplus(self, top: float, wave: float) -> float:
        """c_a (Omega - y') - Z (D - U) with D = y' - U, paper (2) and (13), and Omega by paper (9)."""
        p, law, r = self.string, self.law, self.speed_ref
        share = law.c_b / law.c_a  # k / g
        omega = law.c_1 * top + 2 * math.sqrt(share * (1 - law.c_1)) * self.bit
        omega += 2 * math.sqrt(law.c_2 * (1 - law.c_1)) * r - law.c_2 * r**2 / top
        omega -= 2 * math.sqrt(law.c_2 * share) * self.bit * r / top
        impedance = math.sqrt(p.I * p.G * p.J)
        return p.c_a * (omega - top) - impedance * (top - 2 * wave)

    def extreme(self, sign: float) -> tuple[float, float]:
        """Return the top speed whose surplus is nearest to zero without a wave, and the wave that makes it zero."""

        def distance(exponent: float) -> float:
            return -sign * self.surplus(sign * math.exp(exponent), 0.0)

        found = minimize_scalar(distance, bounds=(-9.0, math.log(WIDEST)), method="bounded", options={"xatol": 1e-10})
        assert found.success
        top = sign * math.exp(found.x)
        p = self.string
        return top, -self.surplus(top, 0.0) / (2 * math.sqrt(p.I * p.G * p.J))

    def roots(self, wave: float) -> list[float]:
        """Return all top speeds at which the surplus is zero."""
        found: list[float] = []
        for sign in (-1.0, 1.0):
            middle, _ = self.extreme(sign)
            for low, high in ((sign * 1e-7, middle), (middle, sign * WIDEST * 10)):
                ends = [self.surplus(end, wave) for end in (low, high)]
                if ends[0] * ends[1] < 0:
                    root: Callable[..., float] = brentq
                    found.append(root(self.surplus, low, high, (wave,), 1e-13, 1e-15))
        return found


@pytest.mark.parametrize("bit", BITS)
@pytest.mark.parametrize("case", CASES)
def test_gap_lies_between_the_waves_that_just_allow_a_top_speed_of_either_sign(case, bit):
    loop, search = PrintedLoop.of(*CASES[case]), Search(*CASES[case], bit)
    (slow, low), (fast, high) = search.extreme(-1.0), search.extreme(1.0)
    assert slow < 0 < fast
    assert loop.gap(bit) == pytest.approx((low, high), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("bit", BITS)
@pytest.mark.parametrize("case", CASES)
def test_loop_has_the_solutions_a_search_finds(case, bit):
    loop, search = PrintedLoop.of(*CASES[case]), Search(*CASES[case], bit)
    low, high = (float(edge) for edge in loop.gap(bit))
    width = high - low
    for wave in (low - width, low - 1e-3 * width, high + 1e-3 * width, high + 0.1 * width, high + width):
        assert loop.solvable(bit, wave)
        roots = sorted(search.roots(wave), key=abs)
        assert len(roots) == 2
        assert loop.top_speeds(bit, wave) == pytest.approx(roots, rel=1e-9)
        assert loop.wave(roots, bit) == pytest.approx([wave, wave], rel=1e-9, abs=1e-9 * width)
    for wave in (low + 1e-3 * width, 0.5 * (low + high), high - 1e-3 * width):
        assert not loop.solvable(bit, wave)
        assert search.roots(wave) == []
        assert np.isnan(loop.top_speeds(bit, wave)).all()


def test_at_rest_there_is_no_solution_whatever_the_parameters():
    random = np.random.default_rng(9)
    for _ in range(200):
        c_a, c_b = 10.0 ** random.uniform(1, 5), 10.0 ** random.uniform(-3, 3)
        string = replace(PAPER, c_a=c_a, c_b=c_b)
        law = replace(LAW, c_1=1 - 10.0 ** random.uniform(-3, 1), c_2=10.0 ** random.uniform(-3, 2), c_a=c_a, c_b=c_b)
        loop = PrintedLoop.of(string, law, random.uniform(0.1, 30))
        assert not loop.solvable(0.0, 0.0)


def test_law_without_a_pole_always_has_a_solution():
    loop = PrintedLoop.of(PAPER, LAW, 0.0)
    assert np.isnan(loop.gap(3.0)).all()
    assert loop.solvable([0.0, 3.0], [-20.0, 20.0]).all()


def test_bit_that_turns_back_fast_enough_leaves_no_gap():
    """The pole changes its sign at v = -r sqrt(c_2 c_a / c_b) / 2: one top speed of either sign for every wave."""
    string, law = replace(PAPER, c_a=120.0, c_b=30.0), replace(LAW, c_a=120.0, c_b=30.0)
    turn = -3.0 * math.sqrt(2.0 * 120.0 / 30.0) / 2
    loop = PrintedLoop.of(string, law, 3.0)
    assert np.isfinite(loop.gap(turn + 0.01)).all()
    bit = turn - 0.5
    assert np.isnan(loop.gap(bit)).all()
    for wave in (-50.0, -1.0, 0.0, 4.0, 60.0):
        assert loop.solvable(bit, wave)
        search = Search(string, law, 3.0, bit)
        roots = [brentq(search.surplus, sign * 1e-9, sign * WIDEST, (wave,), 1e-13, 1e-15) for sign in (-1.0, 1.0)]
        assert loop.top_speeds(bit, wave) == pytest.approx(sorted(roots, key=abs), rel=1e-9)


def test_shapes_follow_from_the_arguments():
    loop = PrintedLoop.of(PAPER, LAW, 10.0)
    bits, waves = np.linspace(0, 9, 4)[:, None], np.linspace(-9, 30, 5)
    assert loop.solvable(bits, waves).shape == loop.top_speeds(bits, waves)[1].shape == (4, 5)
    assert (loop.solvable(bits, waves) == ~np.isnan(loop.top_speeds(bits, waves)[0])).all()


@pytest.mark.parametrize(
    ("law", "speed_ref", "message"),
    [
        (LAW, math.nan, "speed_ref is nan"),
        (replace(LAW, c_1=1.0), 10.0, "c_1 is 1.0"),
        (replace(LAW, c_2=-1.0), 10.0, "c_2 is -1.0"),
    ],
)
def test_loops_of_no_law_are_refused(law, speed_ref, message):
    with pytest.raises(ValueError, match=message):
        PrintedLoop.of(PAPER, law, speed_ref)
