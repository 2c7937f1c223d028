"""The native and the python packaging answer with the same bits, through FMI, at every communication point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from fmu_src.fmus import MODELS
from tests.plant.drive import DAMPED, PLANT, Drive, follow
from tests.plant.programs import CASES, PAPER, SPEED, WEIGHT

Change = dict[str, Any]
Turn = tuple[float, Change]
"""Length of a communication step [s], and what is set before it."""

thorough = settings(
    deadline=None,
    max_examples=25,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
    phases=[Phase.explicit, Phase.generate],  # runs of the plant take too long to look for the shortest that fails
)


def spread(value: float, factor: float = 4.0) -> st.SearchStrategy[float]:
    return st.floats(value / factor, value * factor)


SPEEDS, WEIGHTS = st.floats(-40.0, 40.0), st.floats(0.0, 2e5)
STEP_SIZES = st.one_of(st.floats(1e-5, 2e-3), st.floats(1e-3, 0.3), st.sampled_from([0.001, 0.01, 0.1]))
STRING = st.fixed_dictionaries(
    {
        "L": st.floats(50.0, 2000.0),
        "G": spread(79.3e9),
        "J": spread(1.19e-5),
        "I": spread(0.095),
        "I_B": st.floats(5.0, 400.0),
        "c_a": st.floats(20.0, 1e4),
        "c_b": st.floats(0.0, 200.0),
        "R_b": spread(0.155575),
        "mu_cb": st.floats(0.0, 0.5),
        "mu_sb": st.floats(0.5, 1.0),
        "gamma_b": st.floats(0.0, 1.0),
        "v_f": st.floats(0.3, 5.0),
        "initial_speed": st.one_of(st.just(0.0), st.floats(-20.0, 20.0)),
        "initial_torque": st.one_of(st.just(0.0), st.floats(-3e4, 3e4)),
        "cells": st.integers(1, 60),
        "Omega": SPEEDS,
        "WOB": WEIGHTS,
    }
)
DRILLING = st.fixed_dictionaries(
    {}, optional={"Omega": SPEEDS, "WOB": WEIGHTS, "c_b": st.floats(0.0, 200.0), "mu_sb": st.floats(0.5, 1.0)}
)


def turns(changes: st.SearchStrategy[Change], most: int) -> st.SearchStrategy[list[Turn]]:
    return st.lists(st.tuples(STEP_SIZES, changes), min_size=3, max_size=most)


def answers(model: str, packaging: str, start_values: Change, course: Sequence[Turn], start: float = 0.0) -> np.ndarray:
    """Return all outputs at all communication points, the start included."""
    with Drive(model, start_values, packaging, start) as fmu:
        rows = [fmu.outputs()]
        for size, change in course:
            for name, value in change.items():
                fmu.put(**{name: value})
            fmu.go(fmu.time + size)
            rows.append(fmu.outputs())
    return np.array(rows)


def assert_same_bits(model: str, start_values: Change, course: Sequence[Turn], start: float = 0.0) -> None:
    native, python = (answers(model, packaging, start_values, course, start) for packaging in ("native", "python"))
    assert np.isfinite(native).all()
    assert native.tobytes() == python.tobytes()


@pytest.mark.parametrize("model", MODELS)
def test_every_fmu_gives_the_same_bits_for_inputs_at_random(model):
    random = np.random.default_rng(7)
    inputs = [variable for variable in MODELS[model].select("input") if variable.kind == "Real"]
    course = []
    for size in random.uniform(1e-4, 1.0, 100).tolist():
        drawn = {v.name: v.start + 5.0 * v.nominal * random.uniform(-1.0, 1.0) for v in inputs}
        course.append((size, {v.name: float(np.clip(drawn[v.name], *v.bounds)) for v in inputs}))
    assert_same_bits(model, {}, course)


@pytest.mark.parametrize("step", [0.01, 0.37])
def test_figure_2_at_the_default_cells_has_the_same_bits(step):
    grid = np.arange(1, int(10.0 / step) + 1) * step
    native, python = (follow(PAPER, SPEED, WEIGHT, grid, packaging) for packaging in ("native", "python"))
    assert native["slip_count"][-1] >= 2
    assert native.table.tobytes() == python.table.tobytes()


@pytest.mark.parametrize("name", CASES)
def test_jumping_inputs_and_other_strings_have_the_same_bits(name):
    case = CASES[name]
    grid = np.arange(1, int(0.6 * case.end / 0.137)) * 0.137
    native, python = (
        follow(case.parameters, case.omega, case.wob, grid, packaging, cells=60) for packaging in ("native", "python")
    )
    assert native.table.tobytes() == python.table.tobytes()


@thorough
@given(start_values=STRING, course=turns(DRILLING, 40), start=st.sampled_from([0.0, 0.3, -7.1, 1e4]))
def test_plant_has_the_same_bits(start_values, course, start):
    assert_same_bits(PLANT, start_values, course, start)


@thorough
@given(
    start_values=STRING,
    damping=st.one_of(st.floats(0.0, 1.0), st.floats(0.0, 30.0)),
    stations=st.integers(0, 9),
    course=turns(DRILLING, 30),
    start=st.sampled_from([0.0, 0.3, -7.1, 1e4]),
)
def test_damped_plant_has_the_same_bits(start_values, damping, stations, course, start):
    assert_same_bits(DAMPED, start_values | {"beta": damping, "stations": stations}, course, start)


@pytest.mark.slow
@thorough
@given(seed=st.integers(0, 2**32 - 1), cells=st.integers(4, 60))
def test_plant_under_a_law_that_is_sampled_has_the_same_bits(seed, cells):
    # a break at every communication step: more than can be kept
    random = np.random.default_rng(seed)
    course = [
        (0.001, {"Omega": omega, "WOB": wob})
        for omega, wob in zip(random.uniform(5, 15, 700), random.uniform(5e4, 1e5, 700), strict=True)
    ]
    assert_same_bits(PLANT, {"cells": cells, "L": 300.0}, course)


@thorough
@given(
    start_values=st.fixed_dictionaries(
        {
            "c_1": st.floats(-3.0, 0.999),
            "c_2": st.floats(1e-9, 50.0),
            "c_a": spread(2000.0),
            "c_b": st.floats(0.0, 200.0),
            "form": st.sampled_from([1, 2]),
            "Omega_max": st.floats(1.0, 1e4),
            "top_speed_min": st.floats(1e-9, 1.0),
        }
    ),
    course=turns(
        st.fixed_dictionaries(
            {
                "top_speed": st.one_of(st.floats(-50, 50), st.floats(-1e-3, 1e-3), st.sampled_from([0.0, -0.0])),
                "bit_speed": st.floats(-50, 50),
                "bit_speed_ref": st.floats(-50, 50),
                "bit_torque_ref": st.floats(-3e4, 3e4),
            }
        ),
        20,
    ),
)
def test_dissipative_law_has_the_same_bits(start_values, course):
    assert_same_bits("DissipativeLaw", start_values, course)


@thorough
@given(
    start_values=st.fixed_dictionaries(
        {"K_w": st.floats(0.0, 1e5), "WOB_0": st.floats(1e-3, 1e5), "WOB_max": st.floats(1e5, 1e6)}
    ),
    course=turns(st.fixed_dictionaries({"bit_speed": st.floats(-60, 60)}, optional={"K_w": st.floats(0.0, 1e5)}), 20),
)
def test_weight_on_bit_law_has_the_same_bits(start_values, course):
    assert_same_bits("WeightOnBitLaw", start_values, course)


CHANGES = {
    f"{signal}_{part}": values
    for signal, ends in (("speed", SPEEDS), ("WOB", WEIGHTS))
    for part, values in {
        "initial": ends,
        "final": ends,
        "start": st.floats(-2.0, 3.0),
        "duration": st.one_of(st.just(0.0), st.floats(0, 3)),
    }.items()
}
FRICTION = {
    "c_b": st.floats(0.0, 200.0),
    "mu_cb": st.floats(0.0, 0.5),
    "mu_sb": st.floats(0.5, 1.0),
    "R_b": spread(0.15),
}


@thorough
@given(start_values=st.fixed_dictionaries(CHANGES | FRICTION), course=turns(st.just({}), 20))
def test_program_of_changes_has_the_same_bits(start_values, course):
    assert_same_bits("DrillingProgram", start_values, course)


@thorough
@given(
    rows=st.lists(
        st.tuples(st.floats(-1.0, 4.0), SPEEDS, WEIGHTS), min_size=1, max_size=8, unique_by=lambda row: row[0]
    ),
    doubled=st.booleans(),
    course=turns(st.just({}), 20),
)
def test_program_from_a_table_has_the_same_bits(tmp_path_factory, rows, doubled, course):
    rows = sorted(rows)
    rows += [(rows[-1][0], -rows[-1][1], 1.0)] if doubled else []
    table = tmp_path_factory.mktemp("tables") / "table.csv"
    lines = ["time,speed,WOB", *(",".join(repr(number) for number in row) for row in rows)]
    table.write_text("\n".join(lines) + "\n")
    assert_same_bits("DrillingProgram", {"table": str(table)}, course)
