"""A value or a step that cannot be taken is fmi2Discard with a sentence that says why, and nothing has changed."""

from __future__ import annotations

import subprocess
import sys
from math import inf, nan
from pathlib import Path

import pytest

from fmu_src.fmus import MODELS
from tests.plant.drive import PLANT, PLANTS, Drive
from tests.plant.fmi import DISCARD, OK, Instance, Message, must

SLOW = {"cells": 60}
PARAMETERS = {
    # out of its physical range: name, values, and what the sentence expects
    "L": (0.0, -1172.0, nan, inf, -inf, 1e300),
    "G": (0.0, -1.0, nan),
    "J": (0.0, -1.0, nan),
    "I": (0.0, -0.1, inf),
    "I_B": (0.0, -89.0, nan, inf),
    "c_a": (0.0, -2000.0, nan),
    "c_b": (-0.03, nan, inf),
    "R_b": (0.0, -0.1, nan),
    "mu_cb": (-0.1, 1.1, nan),
    "mu_sb": (-0.1, 1.1, nan),
    "gamma_b": (-0.1, 1.5, nan),
    "v_f": (0.0, -1.0, nan),
    "initial_speed": (nan, inf),
    "initial_torque": (nan, -inf),
}
INPUTS = {"Omega": (nan, inf, -inf, 1e9), "WOB": (nan, inf, -1.0, -inf, 1e12)}


def last(fmu: Instance) -> Message:
    return fmu.messages[-1]


def values_of(fmu: Instance) -> dict[str, float]:
    return {name: fmu.get(name) for name in fmu.variables if fmu.kind(name) != "String"}


def continued(plant: Drive) -> list[float]:
    """Return the outputs two seconds on."""
    plant.go(plant.time + 2.0)
    return plant.outputs()


def untouched(time: float) -> list[float]:
    """Return what `continued` gives for a plant that nobody refused anything."""
    with Drive(PLANT, SLOW) as plant:
        plant.go(time)
        return continued(plant)


@pytest.mark.parametrize("name", PARAMETERS)
def test_parameter_out_of_range_is_refused_by_name_value_and_range(name):
    with Instance(PLANT) as plant:
        must(plant, plant.call("EnterInitializationMode"))
        before = values_of(plant)
        for value in PARAMETERS[name]:
            assert plant.set(**{name: value}) == DISCARD
            assert last(plant)[:3] == ("plant", DISCARD, "logStatusDiscard")
            assert f"plant at t = 0 s: {name} is {value:.15g}" in last(plant).text.replace("-nan", "nan")
            assert "; expected a finite value in [" in last(plant).text
        assert values_of(plant) == before


@pytest.mark.parametrize("name", INPUTS)
def test_input_out_of_range_is_refused_and_the_old_one_held(name):
    with Drive(PLANT, SLOW) as plant:
        plant.go(3.0)
        for value in INPUTS[name]:
            assert plant.set(**{name: value}) == DISCARD
            assert f"plant at t = 3 s: {name} is " in last(plant).text
        assert continued(plant) == untouched(3.0)


@pytest.mark.parametrize("model", MODELS)
def test_every_bound_of_every_table_is_kept(model):
    kinds = {"Real": float, "Integer": int, "Enumeration": int}
    with Instance(model) as fmu:
        bounded = [v for v in fmu.variables.values() if v.causality != "output" and v.type in kinds]
        assert bounded
        for variable in bounded:
            number = kinds[variable.type]
            low = number(variable.min) if variable.min else 1
            high = number(variable.max) if variable.max else len(variable.declaredType.items)
            beyond = max(1, abs(high)) if number is int else abs(high) * 1e-3 + 1e-12
            for value in (low, high, number(variable.start)):
                assert fmu.set(**{variable.name: value}) == OK
            for value in (high + beyond, low - max(1, abs(low)) if number is int else low - abs(low) * 1e-3 - 1e-12):
                assert fmu.set(**{variable.name: value}) == DISCARD, (variable.name, value)


def test_of_several_values_all_are_set_or_none():
    with Drive(PLANT, SLOW) as plant:
        assert plant.set(Omega=5.0, c_b=7.0, WOB=-1.0) == DISCARD
        assert (plant.get("Omega"), plant.get("c_b"), plant.get("WOB")) == (10.0, 0.03, 97347.0)
        assert plant.set(WOB=1e4, Omega=nan) == DISCARD
        plant.go(2.0)
        assert continued(plant) == untouched(2.0)


@pytest.mark.parametrize("slope", [nan, inf, -inf])
def test_derivative_that_is_not_finite_is_refused(slope):
    with Drive(PLANT, SLOW) as plant:
        plant.go(3.0)
        assert plant.set_slopes(Omega=1.0, WOB=slope) == DISCARD
        assert "the derivative of WOB is" in last(plant).text
        assert continued(plant) == untouched(3.0)


@pytest.mark.parametrize(
    ("point", "size", "sentence"),
    [
        (3.0, 0.0, "step size is 0 s; expected a finite value > 0"),
        (3.0, -0.1, "step size is -0.1 s; expected a finite value > 0"),
        (3.0, nan, "step size is"),
        (3.0, inf, "step size is inf s; expected a finite value > 0"),
        (3.0, 1e-17, "step size is 1e-17 s; too small"),
        (2.9, 0.1, "communication point is 2.9 s; expected 3 s"),
        (3.1, 0.1, "communication point is 3.1 s; expected 3 s"),
        (0.0, 0.1, "communication point is 0 s; expected 3 s"),
        (3.0 + 1e-6, 0.1, "communication point is 3.000001 s; expected 3 s"),
        (nan, 0.1, "communication point is"),
        (inf, 0.1, "communication point is inf s; expected 3 s"),
    ],
)
def test_step_that_cannot_be_taken_is_refused_and_changes_nothing(point, size, sentence):
    with Drive(PLANT, SLOW) as plant:
        plant.go(3.0)
        before = plant.outputs()
        assert plant.step(point, size) == DISCARD
        assert f"plant at t = 3 s: {sentence}" in last(plant).text
        assert plant.outputs() == before
        assert continued(plant) == untouched(3.0)


@pytest.mark.parametrize("size", [1e25, 1e300])
def test_step_beyond_what_cells_can_be_counted_for_is_refused(size):
    # in a process of its own: what cannot be counted must not be followed either
    code = (
        "from tests.plant.drive import PLANT, Drive\n"
        "with Drive(PLANT, {'cells': 60}) as plant:\n"
        f"    plant.go(3.0); print(plant.step(3.0, {size})); plant.go(4.0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=Path(__file__).parents[2], timeout=60
    )
    assert (done.returncode, done.stdout.strip()) == (0, str(DISCARD)), done.stderr


@pytest.mark.parametrize("model", MODELS)
def test_no_model_takes_a_bad_step(model):
    with Drive(model, {}) as fmu:
        fmu.go(1.0)
        for point, size in ((1.0, 0.0), (1.0, nan), (0.5, 0.5), (2.0, 1.0)):
            assert fmu.step(point, size) == DISCARD
        fmu.go(2.0)


def test_static_friction_below_coulomb_friction_is_refused_at_the_end_of_the_initialisation():
    with Instance(PLANT) as plant:
        assert plant.set(mu_sb=0.3) == OK
        assert plant.initialize() != OK
        assert last(plant).text == "plant at t = 0 s: mu_sb is 0.3; expected at least mu_cb = 0.5"
        assert plant.set(mu_cb=0.2) == OK
        assert plant.call("ExitInitializationMode") == OK
        assert plant.step(0.0, 1.0) == OK


def test_static_friction_below_coulomb_friction_is_refused_by_the_step():
    with Drive(PLANT, SLOW) as plant:
        plant.go(3.0)
        before = plant.outputs()
        assert plant.set(mu_sb=0.4) == OK
        assert plant.step(3.0, 0.1) == DISCARD
        assert last(plant).text == "plant at t = 3 s: mu_sb is 0.4; expected at least mu_cb = 0.5"
        assert plant.outputs() == before
        plant.put(mu_sb=0.8)
        assert continued(plant) == untouched(3.0)


def test_upper_limit_below_the_weight_kept_at_rest_is_refused():
    with Instance("WeightOnBitLaw", name="law") as law:
        assert law.set(WOB_max=1000.0) == OK
        assert law.initialize() != OK
        assert last(law).text == "law at t = 0 s: WOB_max is 1000; expected at least WOB_0 = 97347"


@pytest.mark.parametrize(
    ("model", "change", "sentence"),
    [
        (PLANT, {"mu_sb": 0.4}, "mu_sb is 0.4; expected at least mu_cb = 0.5"),
        ("DrillingProgram", {"mu_sb": 0.4}, "mu_sb is 0.4; expected at least mu_cb = 0.5"),
        ("WeightOnBitLaw", {"WOB_max": 1000.5}, "WOB_max is 1000.5; expected at least WOB_0 = 97347"),
    ],
)
@pytest.mark.parametrize("packaging", ["native", "python"])
def test_both_packagings_refuse_a_step_with_values_that_do_not_fit(packaging, model, change, sentence):
    with Drive(model, SLOW if model in PLANTS else {}, packaging, logging=True) as fmu:
        fmu.go(0.5)
        before = fmu.outputs()
        assert fmu.set(**change) == OK
        assert fmu.step(0.5, 0.1) == DISCARD
        assert last(fmu).text.removesuffix(".0") == f"plant at t = 0.5 s: {sentence}"
        assert fmu.outputs() == before


def test_weight_that_would_fall_below_zero_within_the_step_is_refused():
    with Drive(PLANT, SLOW) as plant:
        plant.go(3.0)
        must(plant, plant.set_slopes(WOB=-1e6))
        assert plant.step(3.0, 0.1) == DISCARD
        assert "WOB comes to -2653 N at the end of the step by its derivative" in last(plant).text
        must(plant, plant.set_slopes(WOB=0.0))
        assert continued(plant) == untouched(3.0)


@pytest.mark.parametrize(("name", "slope"), [("Omega", 1e9), ("Omega", -1e300), ("WOB", 1e12), ("WOB", 1e308)])
def test_input_that_would_leave_its_range_within_the_step_is_refused(name, slope):
    # no input may become what its setter would refuse
    with Drive(PLANT, SLOW) as plant:
        plant.go(3.0)
        must(plant, plant.set_slopes(**{name: slope}))
        assert plant.step(3.0, 2.0) == DISCARD
        assert f"plant at t = 3 s: {name} " in last(plant).text
        must(plant, plant.set_slopes(**{name: 0.0}))
        assert continued(plant) == untouched(3.0)


def test_string_too_long_to_be_kept_is_refused():
    with Instance("DrillingProgram") as program:
        assert program.set(table="x" * 1024) == DISCARD
        assert "table is longer; expected a text of at most 1023 bytes" in last(program).text
        assert program.initialize() == OK


def test_string_so_long_that_it_needs_too_many_cells_is_refused():
    with Instance(PLANT) as plant:
        assert plant.set(L=1e5, I=1e4, J=1e-9) == OK
        assert plant.initialize() != OK
        assert "expected at most 1e7: set cells or a shorter L" in last(plant).text
        must(plant, plant.call("Reset"))
        assert plant.initialize() == OK


def test_time_added_up_by_the_importer_is_accepted():
    with Drive(PLANT, SLOW) as added, Drive(PLANT, SLOW) as exact:
        time = 0.0
        for k in range(20000):
            assert added.step(time, 0.001) == OK
            time += 0.001
            exact.go((k + 1) * 0.001)
        assert time != 20.0
        assert added.outputs() == pytest.approx(exact.outputs(), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("start", [-50.0, 0.1, 1234.5])
def test_start_time_moves_times_and_nothing_else(start):
    with Drive(PLANT, SLOW) as zero, Drive(PLANT, SLOW, start=start) as moved:
        assert moved.get("last_stop_time") == start
        for k in range(1, 90):
            zero.go(k * 0.1)
            moved.go(start + k * 0.1)
            here, there = zero.named(), moved.named()
            for name in ("last_stop_time", "last_release_time"):
                assert there.pop(name) - start == pytest.approx(here.pop(name), abs=1e-9)
            assert there == pytest.approx(here, rel=1e-9, abs=1e-8)
        assert zero.get("slip_count") == 3
