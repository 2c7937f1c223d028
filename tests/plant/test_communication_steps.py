"""The place of the communication points makes no difference while the inputs are held."""

from __future__ import annotations

import numpy as np
import pytest

from tests.plant.drive import PLANT, PLANTS, RANGE, Drive, follow
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


@pytest.mark.parametrize("model", PLANTS)
def test_weight_and_friction_that_change_together_where_a_block_ends_act_from_there_on(model):
    # with this string and four cells a block is a quarter of a second, to the last bit
    string = {"G": 1e6, "J": 1e-6, "I": 1.0, "L": 1.0, "cells": 4, "WOB": 0.0}
    with Drive(model, string) as plant, Drive(model, string) as beside:
        for end in (0.5, 1.5, 2.25):
            plant.go(end)
            beside.go(end + 1e-9)
            for fmu in (plant, beside):
                fmu.put(c_b=3.0 + end, WOB=1000.0 * end)
        plant.go(4.0)
        beside.go(4.0)
        assert plant.get("bit_torque") == pytest.approx(beside.get("bit_torque"), rel=1e-6)
        assert plant.get("bit_angle") == pytest.approx(beside.get("bit_angle"), rel=1e-6)
        assert plant.get("stuck_time") == pytest.approx(beside.get("stuck_time"), abs=1e-6)
