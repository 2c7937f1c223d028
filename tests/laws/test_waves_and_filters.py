"""Sine, cosine and the filter of first order, against those of the standard library and of decimal arithmetic."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from models.numerics.low_pass import low_pass
from models.numerics.trigonometry import sine_and_cosine


@pytest.mark.parametrize("reach", [0.8, 10.0, 1e5])
def test_sine_and_cosine_are_right_to_the_last_place_of_one(reach: float) -> None:
    for angle in np.random.default_rng(0).uniform(-reach, reach, 5000).tolist():
        found = sine_and_cosine(angle)
        # two products of the reduction are rounded, each to half a unit of what they are made of
        bar = 3e-16 + 2.3e-16 * abs(angle) * 1e-10
        assert abs(found.sine - math.sin(angle)) <= bar
        assert abs(found.cosine - math.cos(angle)) <= bar


@pytest.mark.parametrize("angle", [k * math.pi / 4 for k in range(-9, 10)])
def test_where_quarters_change_over_nothing_jumps(angle: float) -> None:
    for near in (math.nextafter(angle, -math.inf), angle, math.nextafter(angle, math.inf)):
        assert sine_and_cosine(near) == pytest.approx((math.sin(near), math.cos(near)), abs=3e-16)


@pytest.mark.parametrize("time_constant", [0.0, 1e-3, 0.04, 5.0])
@pytest.mark.parametrize("slope", [0.0, -3.0])
def test_filter_solves_its_equation_on_a_straight_line(time_constant: float, slope: float) -> None:
    before, value, elapsed = 2.0, 7.0, 0.3
    found = low_pass(before, value, slope, elapsed, time_constant)
    if time_constant == 0.0:
        assert found == value + slope * elapsed
        return
    with mpmath.workdps(30):
        T, x = mpmath.mpf(time_constant), mpmath.mpf(elapsed)
        share = mpmath.exp(-x / T)
        exact = value + slope * (x - T) + (before - value + slope * T) * share
    assert found == pytest.approx(float(exact), rel=1e-14)


@pytest.mark.parametrize("parts", [2, 3, 100])
def test_filter_does_not_depend_on_how_a_step_is_divided(parts: int) -> None:
    whole, divided = low_pass(1.0, 4.0, 0.0, 0.5, 0.2), 1.0
    for _ in range(parts):
        divided = low_pass(divided, 4.0, 0.0, 0.5 / parts, 0.2)
    assert divided == pytest.approx(whole, rel=1e-13)
