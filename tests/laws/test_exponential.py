"""The exponential of the friction law against the arbitrary-precision one of decimal."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest

from models.numerics.exponential import GREATEST, LEAST, exponential
from tests.plant.fmi import Instance, must

UNIT_LAW = {"c_b": 0.0, "R_b": 1.0, "mu_cb": 0.0, "mu_sb": 1.0, "gamma_b": 1.0, "v_f": 1.0, "WOB_final": 1.0}
"""Friction parameters that make the torque on bit exp(-speed)."""


def error_in_ulp(x: float) -> float:
    """Return the distance from e^x in units in the last place of the result."""
    with localcontext() as context:
        context.prec = 60
        exact = Decimal(x).exp()
        return float(abs(Decimal(exponential(x)) - exact) / Decimal(math.ulp(float(exact))))


@pytest.mark.parametrize(("low", "high"), [(-1.0, 1.0), (-30.0, 30.0), (LEAST, GREATEST), (-1e-8, 1e-8)])
def test_error_is_below_one_unit_in_the_last_place(low, high):
    arguments = np.random.default_rng(0).uniform(low, high, 5000).tolist()
    assert max(map(error_in_ulp, arguments)) < 1.0


def test_error_is_below_one_unit_where_the_reduction_changes_over():
    # multiples of ln 2 / 2 and their neighbours
    arguments = []
    for k in range(-2042, 2045):
        middle = k * math.log(2.0) / 2
        arguments += [middle, math.nextafter(middle, math.inf), math.nextafter(middle, -math.inf)]
    inside = [x for x in arguments if LEAST <= x <= GREATEST]
    assert len(inside) > 10000
    assert max(map(error_in_ulp, inside)) < 1.0


def test_special_arguments():
    assert exponential(0.0) == exponential(-0.0) == exponential(5e-324) == 1.0
    assert exponential(LEAST - 1e-9) == exponential(-1e308) == 0.0
    assert exponential(LEAST) > 0.0
    assert exponential(1e308) == exponential(GREATEST) == pytest.approx(math.exp(GREATEST), rel=1e-15)


def test_exponential_grows():
    arguments = np.sort(np.random.default_rng(1).uniform(-5.0, 5.0, 20000)).tolist()
    values = [exponential(x) for x in arguments]
    assert values == sorted(values)


@pytest.mark.parametrize("packaging", ["native", "python"])
def test_exponential_of_the_fmus_has_the_same_bits(packaging):
    random = np.random.default_rng(2)
    speeds = [*random.uniform(0.0, 40.0, 300), *random.uniform(0.0, 720.0, 300), 708.0, 708.0000001, 1e4, 1e-300]
    with Instance("DrillingProgram", packaging) as program:
        for name, value in UNIT_LAW.items():
            must(program, program.set(**{name: value}))
        must(program, program.call("EnterInitializationMode"))
        for speed in map(float, speeds):
            must(program, program.set(speed_final=speed))
            assert program.get("bit_torque_ref") == exponential(-speed)
            must(program, program.set(speed_final=-speed))
            assert program.get("bit_torque_ref") == -exponential(-speed)
