"""Eq. (22), W = K_w |v| + W_0, kept below an upper limit."""

from __future__ import annotations

import pytest

from models.controllers.laws import WeightOnBitLaw
from tests.plant.drive import Drive

PACKAGINGS = ("native", "python")


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize(
    ("speed", "weight"),
    [
        (0.0, 97347.0),
        (-0.0, 97347.0),
        (10.0, 147347.0),
        (-10.0, 147347.0),
        (40.5306, 300000.0),
        (40.531, 300000.0),
        (-1e6, 300000.0),
        (40.53, 299997.0),
    ],
)
def test_weight_is_equation_22_up_to_its_limit(packaging, speed, weight):
    with Drive("WeightOnBitLaw", {"bit_speed": speed}, packaging) as law:
        assert law.get("WOB") == pytest.approx(weight, rel=1e-15)
        law.put(bit_speed=1.0)
        law.go(0.01)
        assert law.get("WOB") == 102347.0
        law.put(bit_speed=speed)
        law.go(0.02)
        assert law.get("WOB") == pytest.approx(weight, rel=1e-15)


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_weight_follows_its_parameters(packaging):
    start = {"K_w": 200.0, "WOB_0": 1e4, "WOB_max": 2e4, "bit_speed": 25.0}
    with Drive("WeightOnBitLaw", start, packaging) as law:
        assert law.get("WOB") == 15000.0
        law.put(K_w=300.0)
        law.go(1.0)
        assert law.get("WOB") == 17500.0
        law.put(WOB_max=12000.0)
        law.go(2.0)
        assert law.get("WOB") == 12000.0


def test_without_gain_the_weight_is_what_is_kept_at_rest():
    assert WeightOnBitLaw(0.0, 5e4, 1e5).weight(-33.0) == 5e4


def test_weight_never_falls_when_the_bit_turns_faster():
    law = WeightOnBitLaw()
    weights = [law.weight(0.5 * k) for k in range(200)]
    assert weights == sorted(weights)
    assert weights[0] == law.least
    assert weights[-1] == law.greatest
