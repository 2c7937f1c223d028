"""Where the communication points lie makes no difference while the inputs are held."""

from __future__ import annotations

import numpy as np
import pytest

from tests.plant.drive import PLANT, RANGE, Drive, follow
from tests.plant.programs import CASES, SPEED, WEIGHT

TICK = 2.0**-20
"""Times that are multiples of this are met exactly, whatever the steps [s]."""
STEPS = {"1/1024": 1 / 1024, "7/512": 7 / 512, "1/8": 1 / 8, "random": None}
COMMON = np.arange(1, 11) * 2.5


def ticks(times: np.ndarray) -> np.ndarray:
    return np.unique(np.rint(times / TICK)) * TICK


def grid_of(step: float | None) -> np.ndarray:
    if step is None:
        times = ticks(np.random.default_rng(8).uniform(0.0, COMMON[-1], 500))
    else:
        times = np.arange(1, int(COMMON[-1] / step) + 1) * step
    return np.unique(np.concatenate([times, COMMON]))


def on_ticks(program):
    """Move the changes of a program to ticks, which are on no grid of the plant."""
    return type(program)(ticks(np.array(program.times)), program.values, program.slopes)


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("name", CASES)
def test_held_inputs_give_the_same_bits_at_any_communication_step(name, step):
    case = CASES[name]
    inputs = on_ticks(case.omega), on_ticks(case.wob)
    long, short = (
        follow(case.parameters, *inputs, grid, cells=150).at(COMMON) for grid in (COMMON, grid_of(STEPS[step]))
    )
    for output in set(long.names) - set(RANGE):
        assert (long[output] == short[output]).all(), output


def test_ranges_of_short_steps_make_up_those_of_long_ones():
    case = CASES["stick-slip of figure 2"]
    long = follow(case.parameters, SPEED, WEIGHT, COMMON, cells=150)
    short = follow(case.parameters, SPEED, WEIGHT, grid_of(None), cells=150)
    span = np.searchsorted(COMMON, short.times)
    for place in range(len(COMMON)):
        inside = span == place
        assert short["bit_speed_min"][inside].min() == pytest.approx(long["bit_speed_min"][place], abs=1e-12)
        assert short["bit_speed_max"][inside].max() == pytest.approx(long["bit_speed_max"][place], abs=1e-12)


def test_setting_an_input_to_what_it_is_changes_nothing():
    rows = []
    for sets in (False, True):
        with Drive(PLANT, {"cells": 150}) as plant:
            for end in np.arange(1, 200) * 0.0625:
                if sets:
                    plant.put(Omega=10.0, WOB=97347.0)
                plant.go(end)
            rows.append(plant.outputs())
    assert rows[0] == rows[1]


def test_a_step_of_many_travel_times_is_as_good_as_its_parts():
    ends = []
    for steps in (1, 4096):
        with Drive(PLANT, {"cells": 150}) as plant:
            for k in range(steps):
                plant.go(64.0 * (k + 1) / steps)
            ends.append({name: value for name, value in plant.named().items() if name not in RANGE})
    assert ends[0] == ends[1]
    assert ends[0]["slip_count"] >= 15
