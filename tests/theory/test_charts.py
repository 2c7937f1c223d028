"""Stability charts, cell by cell against the tests' own characteristic roots and against the critical line."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from models.theory.stability.chart import stability_boundary, stability_chart
from models.theory.stability.spectrum import critical_omega
from tests.plant.theory import equilibrium, root_near
from tests.theory.strings import LIGHT, NOMINAL, PAPER, oracle_of


def test_chart_over_drive_and_weight_changes_sign_on_the_critical_line():
    omegas, weights = np.linspace(0.5, 15, 59), np.linspace(500, 150_000, 12)
    chart = stability_chart(PAPER, 10.0, NOMINAL, ("Omega", omegas), ("WOB", weights))
    line = stability_boundary(PAPER, weights)
    assert math.isnan(line[0])
    for row, critical in enumerate(line):
        exists = chart.unstable[row] >= 0
        assert (np.isnan(chart.abscissa[row]) == ~exists).all()
        assert ((chart.abscissa[row] < 0) == (chart.unstable[row] == 0))[exists].all()
        expected = exists if math.isnan(critical) else omegas > critical
        assert ((chart.unstable[row] == 0) == expected).all()
    assert line[1:] == pytest.approx([critical_omega(PAPER, weight) for weight in weights[1:]])


@pytest.mark.parametrize(
    ("x", "y"),
    [
        (("c_b", [0.03, 40.0, 80.0]), ("WOB", [LIGHT, NOMINAL])),
        (("c_a", [1400.0, 2000.0, 5000.0]), ("L", [600.0, 1172.0, 1500.0])),
        (("WOB", [LIGHT, NOMINAL]), ("Omega", [9.0, 14.0])),
    ],
)
def test_every_cell_is_that_of_its_string_and_inputs(x, y):
    chart = stability_chart(PAPER, 12.0, NOMINAL, x, y)
    for row, low in enumerate(y[1]):
        for column, high in enumerate(x[1]):
            values = {"Omega": 12.0, "WOB": NOMINAL, x[0]: high, y[0]: low}
            omega, wob = values.pop("Omega"), values.pop("WOB")
            string = oracle_of(replace(PAPER, **values))
            speed = equilibrium(string, omega, wob)
            assert chart.speed[row, column] == pytest.approx(speed, rel=1e-12)
            # the least of the roots that start from the fundamental and the next modes of a clamped string
            modes = [math.pi * k / string.travel_time for k in (0.25, 0.35, 0.5, 1.0, 1.2)]
            roots = [root_near(string, wob, speed, -0.1 + 1j * mode) for mode in modes]
            chain = math.log(abs(string.reflection)) / (2 * string.travel_time)
            supremum = max(chain, *(root.real for root in roots))
            assert chart.abscissa[row, column] == pytest.approx(supremum, rel=1e-8)
            assert chart.unstable[row, column] == (2 if chart.abscissa[row, column] > 0 else 0)


def test_more_damping_at_the_bit_only_helps():
    chart = stability_chart(PAPER, 10.0, NOMINAL, ("c_b", np.linspace(0, 200, 21)), ("WOB", [9e4, 12e4, 13.4e4]))
    assert (np.diff(chart.unstable, axis=1) <= 0).all()
    assert chart.unstable[-1, 0] == 2
    assert (chart.unstable[:, -1] == 0).all()


@pytest.mark.parametrize(
    ("x", "y", "message"),
    [
        (("speed", [1.0]), ("WOB", [1.0]), "a chart over 'speed'"),
        (("WOB", [1.0]), ("WOB", [2.0]), "both axes"),
        (("L", [-1.0]), ("WOB", [2.0]), "parameter L is -1.0"),
        (("Omega", [math.nan]), ("WOB", [2.0]), "Omega is nan"),
    ],
)
def test_charts_over_nonsense_are_refused(x, y, message):
    with pytest.raises(ValueError, match=message):
        stability_chart(PAPER, 10.0, NOMINAL, x, y)
