"""The law of eq. (9) and its tracking form against transcriptions of their own, and the identities they stand for."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np
import pytest

from models.controllers.laws import DissipativeLaw
from tests.oracle import OracleParameters
from tests.plant.drive import Drive

PACKAGINGS = ("native", "python")
PAPER = OracleParameters()
LOOSE = {"Omega_max": 1e4, "top_speed_min": 1e-9}


@dataclass(frozen=True)
class Inputs:
    """Speeds of top and bit, the speed wanted [rad/s] and the torque there [N m]."""

    top_speed: float
    bit_speed: float
    bit_speed_ref: float
    bit_torque_ref: float = 0.0


def printed(x: Inputs, c_1: float, c_2: float, c_a: float = 2000.0, c_b: float = 0.03) -> float:
    """Eq. (9) with g = c_a L/(G J), k = c_b L/(G J), its first root over k (1 - c_1)/g."""
    per_length = PAPER.L / (PAPER.G * PAPER.J)
    g, k = c_a * per_length, c_b * per_length
    z_t0, z_t1, z_ref = x.top_speed, x.bit_speed, x.bit_speed_ref
    return (
        c_1 * z_t0
        + 2 * math.sqrt(k * (1 - c_1) / g) * z_t1
        + 2 * math.sqrt(c_2 * (1 - c_1)) * z_ref
        - c_2 * z_ref**2 / z_t0
        - 2 * math.sqrt(c_2 * k / g) * z_t1 * z_ref / z_t0
    )


def tracking(x: Inputs, c_1: float, c_a: float = 2000.0, c_b: float = 0.03) -> float:
    """Return r + T_ref/c_a + c_1 (ydot - r) + 2 sqrt(c_b (1 - c_1)/c_a) (v - r)."""
    r = x.bit_speed_ref
    return (
        r + x.bit_torque_ref / c_a + c_1 * (x.top_speed - r) + 2 * math.sqrt(c_b * (1 - c_1) / c_a) * (x.bit_speed - r)
    )


def answer(inputs: Inputs, packaging: str, **parameters: float) -> dict[str, float]:
    """Return the outputs of the FMU, after the initialisation and after a step, which must be the same."""
    with Drive("DissipativeLaw", parameters | vars(inputs), packaging) as law:
        first = law.named()
        law.go(0.001)
        assert law.named() == first
        return first


def drawn(count: int, seed: int) -> list[tuple[Inputs, float, float]]:
    """Return inputs with c_1 and c_2."""
    random = np.random.default_rng(seed)
    return [
        (
            Inputs(*random.uniform(-30, 30, 3), random.uniform(-2e4, 2e4)),
            random.uniform(-2, 0.999),
            10 ** random.uniform(-2, 1),
        )
        for _ in range(count)
    ]


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_printed_form_is_equation_9(packaging):
    for x, c_1, c_2 in drawn(100, 1):
        seen = answer(x, packaging, c_1=c_1, c_2=c_2, c_b=15.0, **LOOSE)
        scale = abs(c_2 * x.bit_speed_ref**2 / x.top_speed) + 100
        assert seen["Omega"] == pytest.approx(printed(x, c_1, c_2, c_b=15.0), abs=1e-13 * scale)
        assert (seen["guard_active"], seen["limit_active"]) == (0, 0)


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_tracking_form_is_the_same_square_in_deviations(packaging):
    for x, c_1, _ in drawn(100, 2):
        seen = answer(x, packaging, form=2, c_1=c_1, c_b=15.0, **LOOSE)
        assert seen["Omega"] == pytest.approx(tracking(x, c_1, c_b=15.0), abs=1e-11)
        assert (seen["guard_active"], seen["limit_active"]) == (0, 0)


def test_defaults_are_those_of_figure_7():
    x = Inputs(12.0, 8.0, 10.0)
    assert answer(x, "native")["Omega"] == pytest.approx(printed(x, 0.3, 2.0), rel=1e-13)
    assert DissipativeLaw().command(12.0, 8.0, 10.0, 0.0).omega == answer(x, "native")["Omega"]


def test_printed_form_completes_the_square_in_the_energy_balance():
    # (8) under (9): z_0 (z_0 - Omega) + (k/g) z_1^2 = (sqrt(1-c_1) z_0 - sqrt(k/g) z_1 - sqrt(c_2) z_ref)^2
    for x, c_1, c_2 in drawn(100, 3):
        omega = answer(x, "native", c_1=c_1, c_2=c_2, c_b=15.0, **LOOSE)["Omega"]
        ratio = 15.0 / 2000.0
        left = x.top_speed * (x.top_speed - omega) + ratio * x.bit_speed**2
        root = math.sqrt(1 - c_1) * x.top_speed - math.sqrt(ratio) * x.bit_speed - math.sqrt(c_2) * x.bit_speed_ref
        assert left == pytest.approx(root**2, rel=1e-9, abs=1e-9)


def test_tracking_form_completes_the_square_in_deviations():
    for x, c_1, _ in drawn(100, 4):
        omega = answer(x, "native", form=2, c_1=c_1, c_b=15.0, **LOOSE)["Omega"]
        ratio, r = 15.0 / 2000.0, x.bit_speed_ref
        top, bit, drive = x.top_speed - r, x.bit_speed - r, omega - r - x.bit_torque_ref / 2000.0
        left = top * (top - drive) + ratio * bit**2
        assert left == pytest.approx((math.sqrt(1 - c_1) * top - math.sqrt(ratio) * bit) ** 2, rel=1e-9, abs=1e-9)


def test_tracking_form_without_the_bit_is_a_softer_top():
    # c_a (Omega - ydot) = c (r + T/c - ydot) with c = c_a (1 - c_1)
    for x, c_1, _ in drawn(50, 5):
        omega = answer(x, "native", form=2, c_1=c_1, c_b=0.0, **LOOSE)["Omega"]
        softer = 2000.0 * (1 - c_1)
        torque = softer * (x.bit_speed_ref + x.bit_torque_ref / softer - x.top_speed)
        assert 2000.0 * (omega - x.top_speed) == pytest.approx(torque, rel=1e-9, abs=1e-7)


def test_tracking_form_asks_for_the_equilibrium_at_the_wanted_speed():
    x = Inputs(10.0, 10.0, 10.0, 7580.0)
    assert answer(x, "native", form=2)["Omega"] == 10.0 + 7580.0 / 2000.0


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize(
    ("top_speed", "divisor", "guard"),
    [
        (0.0, 0.01, 1),
        (-0.0, -0.01, 1),
        (0.009999, 0.01, 1),
        (-0.009999, -0.01, 1),
        (5e-324, 0.01, 1),
        (0.01, 0.01, 0),
        (-0.01, -0.01, 0),
        (0.010001, 0.010001, 0),
    ],
)
def test_divisor_is_held_away_from_zero_with_the_sign_of_the_top_speed(packaging, top_speed, divisor, guard):
    # a small reference keeps Omega off its limit
    seen = answer(Inputs(top_speed, 3.0, 0.2), packaging)
    expected = printed(Inputs(divisor, 3.0, 0.2), 0.3, 2.0) + 0.3 * (top_speed - divisor)
    assert seen["Omega"] == pytest.approx(expected, rel=1e-12)
    assert (seen["guard_active"], seen["limit_active"]) == (guard, 0)
    assert abs(seen["Omega"]) < 40.0


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_tracking_form_needs_no_guard(packaging):
    seen = answer(Inputs(0.0, 0.0, 5.0), packaging, form=2)
    assert (seen["guard_active"], seen["limit_active"]) == (0, 0)


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("form", [1, 2])
def test_limit_holds_omega_on_both_sides_and_says_so(packaging, form):
    for top_speed, sign in ((1.0, -1.0 if form == 1 else 1.0), (-1.0, 1.0)):
        x = Inputs(top_speed, 0.0, 10.0, 1e5)
        seen = answer(x, packaging, form=form)
        assert (seen["Omega"], seen["limit_active"]) == (sign * 40.0, 1)
    seen = answer(Inputs(1.0, 0.0, -10.0, -1e5), packaging, form=2)
    assert (seen["Omega"], seen["limit_active"]) == (-40.0, 1)


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_omega_at_its_limit_exactly_is_not_limited(packaging):
    for drive in (40.0, -40.0):
        seen = answer(Inputs(drive, drive, drive), packaging, form=2)
        assert (seen["Omega"], seen["limit_active"]) == (drive, 0)


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_guard_and_limit_are_told_apart(packaging):
    for top_speed, reference in product((0.0, 1.0, 20.0), (0.1, 10.0)):
        seen = answer(Inputs(top_speed, 0.0, reference), packaging)
        assert seen["guard_active"] == (top_speed == 0.0)
        divisor = 0.01 if top_speed == 0.0 else top_speed
        free = printed(Inputs(divisor, 0.0, reference), 0.3, 2.0) + 0.3 * (top_speed - divisor)
        assert seen["limit_active"] == (abs(free) > 40.0)


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_law_follows_its_tunable_parameters_and_inputs_from_step_to_step(packaging):
    with Drive("DissipativeLaw", vars(Inputs(12.0, 8.0, 10.0)), packaging) as law:
        for k, c_1 in enumerate((0.3, 0.7, -1.0), start=1):
            x = Inputs(12.0 + k, 8.0, 10.0)
            law.put(c_1=c_1, top_speed=x.top_speed)
            law.go(0.001 * k)
            assert law.get("Omega") == pytest.approx(printed(x, c_1, 2.0), rel=1e-13)
