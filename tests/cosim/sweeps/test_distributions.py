"""Distributions: their quantiles, and what is wrong with a file of them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from cosim import InputError
from cosim.sweeps.design import sampled
from cosim.sweeps.distributions import Distribution, read_distributions

FILE = """
"plant.L" = { kind = "normal", mean = 1172, deviation = 10 }
[plant]
c_b = { kind = "lognormal", median = 0.03, factor = 2 }
[plant.WOB]
kind = "triangular"
low = 5e4
mode = 8e4
high = 1e5
"""


def test_a_file_of_distributions_is_read(tmp_path: Path) -> None:
    path = tmp_path / "uncertain.toml"
    path.write_text(FILE)
    found = read_distributions(path)
    assert list(found) == ["plant.L", "plant.c_b", "plant.WOB"]
    assert found["plant.L"] == Distribution("normal", {"mean": 1172, "deviation": 10})


@pytest.mark.parametrize(
    ("distribution", "values"),
    [
        # at 0.25, 0.5 and 0.841344746, a deviation above the median of a normal distribution
        (Distribution("uniform", {"low": 2.0, "high": 6.0}), [3.0, 4.0, 2.0 + 4.0 * 0.841344746]),
        (Distribution("normal", {"mean": 10.0, "deviation": 2.0}), [10.0 - 2.0 * 0.67448975, 10.0, 12.0]),
        (Distribution("lognormal", {"median": 0.03, "factor": 2.0}), [0.03 * 2.0**-0.67448975, 0.03, 0.06]),
        # half a parabola on each side of the mode
        (
            Distribution("triangular", {"low": 0.0, "mode": 1.0, "high": 2.0}),
            [math.sqrt(0.5), 1.0, 2.0 - math.sqrt(2.0 * (1.0 - 0.841344746))],
        ),
    ],
)
def test_quantiles_are_those_of_the_textbook(distribution: Distribution, values: list[float]) -> None:
    assert distribution.quantiles(np.array([0.25, 0.5, 0.841344746])) == pytest.approx(values, rel=1e-7)


def test_samples_of_a_distribution_have_its_moments() -> None:
    axis = sampled({"a": Distribution("normal", {"mean": 5.0, "deviation": 0.5})}, 4096, "sobol", 1)
    values = np.array(axis.values["a"])
    assert values.mean() == pytest.approx(5.0, abs=1e-3)
    assert values.std() == pytest.approx(0.5, rel=1e-2)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a = 3", 'u.toml: a: expected a table such as { kind = "normal", mean = 1, deviation = 0.1 }'),
        ('a = { kind = "norml", mean = 1 }', "u.toml: a: there is no distribution 'norml'; did you mean 'normal'?"),
        (
            'a = { kind = "normal", mean = 1 }',
            "u.toml: a: a normal distribution is given mean; expected mean, deviation",
        ),
        (
            'a = { kind = "normal", mean = 1, deviation = 0 }',
            "u.toml: a: a normal distribution has mean = 1, deviation = 0; expected a deviation > 0",
        ),
        (
            'a = { kind = "uniform", low = 2, high = 1 }',
            "u.toml: a: a uniform distribution has low = 2, high = 1; expected low < high",
        ),
        ('a = { kind = "uniform", low = "x", high = 1 }', "u.toml: a.low is 'x'; expected a number"),
        (
            'a = { kind = "uniform", low = 0, high = inf }',
            "u.toml: a: a uniform distribution has low = 0, high = inf; expected low < high",
        ),
    ],
)
def test_a_distribution_that_makes_no_sense_is_refused(tmp_path: Path, text: str, sentence: str) -> None:
    (tmp_path / "u.toml").write_text(text)
    with pytest.raises(InputError) as refused:
        read_distributions(tmp_path / "u.toml")
    assert str(refused.value) == sentence
