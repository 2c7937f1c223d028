"""Inputs that go on along their derivatives within a step: exactly, and within the next step only."""

from __future__ import annotations

from ctypes import byref, c_double, c_int

import numpy as np
import pytest

from fmu_src.fmus import MODELS
from tests.oracle import Program
from tests.plant.drive import PLANT, RANGE, Drive, follow
from tests.plant.fmi import DISCARD, ERROR, OK, Instance, must
from tests.plant.programs import PAPER

TURNING = {"WOB": 31649.0, "initial_speed": 8.768644096751, "initial_torque": 2462.7}
STICKING = {"WOB": 60000.0}
RAMPS = {
    "up, turning": (TURNING, 10.0, 0.7),
    "down, turning": (TURNING, 10.0, -0.3),
    "up, sticking": (STICKING, 4.0, 0.7),
}


def ramped(start: dict[str, float], begin: float, slope: float, step: float, count: int) -> list[dict[str, float]]:
    """Return the outputs after each step, the drive set with its derivative before it."""
    rows = []
    with Drive(PLANT, start | {"Omega": begin}) as plant:
        for k in range(count):
            plant.put(Omega=begin + slope * plant.time)
            must(plant, plant.set_slopes(Omega=slope))
            plant.go((k + 1) * step)
            rows.append(plant.named())
    return rows


def staircase(start: dict[str, float], begin: float, slope: float, step: float, count: int) -> np.ndarray:
    """Return the bit speed after each step, the drive held at what it is in the middle of it."""
    speeds = []
    with Drive(PLANT, start | {"Omega": begin}) as plant:
        for k in range(count):
            plant.put(Omega=begin + slope * (k + 0.5) * step)
            plant.go((k + 1) * step)
            speeds.append(plant.get("bit_speed"))
    return np.array(speeds)


@pytest.mark.parametrize("ramp", RAMPS)
def test_a_ramp_in_long_steps_is_the_ramp_in_short_ones(ramp):
    long = ramped(*RAMPS[ramp], step=1.0, count=20)
    short = ramped(*RAMPS[ramp], step=0.25, count=80)[3::4]
    for one, other in zip(long, short, strict=True):
        for name in set(one) - set(RANGE):
            assert one[name] == pytest.approx(other[name], rel=1e-12, abs=1e-7), name
    if ramp == "up, sticking":
        assert long[-1]["slip_count"] == 3


@pytest.mark.parametrize("ramp", ["up, turning", "down, turning"])
def test_held_at_midpoints_the_drive_converges_to_the_ramp_at_second_order(ramp):
    # steps that are parts of the travel time: every step of the drive then meets the bit at a communication point
    parts, trips, common = (48, 96, 192, 384, 768), 27, 6
    away = PAPER.travel_time
    exact = [row["bit_speed"] for row in ramped(*RAMPS[ramp], step=away / common, count=common * trips)]
    errors = []
    for count in parts:
        speeds = staircase(*RAMPS[ramp], step=away / count, count=count * trips)
        errors.append(np.abs(speeds[count // common - 1 :: count // common] - exact).max())
    order = -np.polyfit(np.log(parts), np.log(errors), 1)[0]
    assert order == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("ramp", RAMPS)
def test_held_at_midpoints_of_half_a_millisecond_the_drive_is_as_good_as_the_ramp(ramp):
    exact = [row["bit_speed"] for row in ramped(*RAMPS[ramp], step=0.25, count=80)]
    speeds = staircase(*RAMPS[ramp], step=0.0005, count=40000)
    assert np.abs(speeds[499::500] - exact).max() <= 1e-5


def test_a_derivative_is_valid_for_the_next_step_only():
    with Drive(PLANT, {}) as plant:
        must(plant, plant.set_slopes(Omega=2.0, WOB=-1000.0))
        plant.go(0.5)
        plant.go(1.5)
        told = Program([0.0, 0.5], [10.0, 10.0], [2.0, 0.0]), Program([0.0, 0.5], [97347.0, 97347.0], [-1000.0, 0.0])
        other = follow(PAPER, *told, np.array([0.5, 1.5]))
        assert plant.outputs() == other.table[-1].tolist()
        assert (plant.get("Omega"), plant.get("WOB")) == (10.0, 97347.0)


def test_a_derivative_can_be_set_before_the_value_and_taken_back():
    rows = []
    for order in ("value first", "derivative first", "taken back"):
        with Drive(PLANT, {}) as plant:
            if order != "value first":
                must(plant, plant.set_slopes(Omega=2.0 if order == "derivative first" else 9.0))
            plant.put(Omega=11.0)
            if order != "derivative first":
                must(plant, plant.set_slopes(Omega=2.0))
            plant.go(3.0)
            rows.append(plant.outputs())
    assert rows[0] == rows[1] == rows[2]


@pytest.mark.parametrize("phase", ["instantiated", "initialization mode"])
def test_a_derivative_set_before_the_first_step_is_valid_for_it(phase):
    with Instance(PLANT) as early, Drive(PLANT, {}) as late:
        if phase == "instantiated":
            must(early, early.set_slopes(Omega=2.0))
        must(early, early.call("SetupExperiment", 0, 0.0, 0.0, 0, 0.0))
        must(early, early.call("EnterInitializationMode"))
        if phase != "instantiated":
            assert early.get("top_speed") == late.get("top_speed")
            must(early, early.set_slopes(Omega=2.0))
        must(early, early.call("ExitInitializationMode"))
        must(late, late.set_slopes(Omega=2.0))
        for end in (0.5, 1.0, 1.5, 2.0, 2.5, 3.0):
            must(early, early.step(end - 0.5, 0.5))
            late.go(end)
            assert [early.get(name) for name in late.names] == late.outputs()


def test_a_reset_forgets_derivatives():
    with Drive(PLANT, {}) as plant, Drive(PLANT, {}) as fresh:
        must(plant, plant.set_slopes(Omega=2.0))
        must(plant, plant.call("Reset"))
        must(plant, plant.initialize())
        plant.go(3.0)
        fresh.go(3.0)
        assert plant.outputs() == fresh.outputs()


def test_a_refused_step_keeps_derivatives():
    with Drive(PLANT, {}) as plant, Drive(PLANT, {}) as other:
        for fmu in (plant, other):
            must(fmu, fmu.set_slopes(Omega=2.0))
        assert plant.step(0.0, -1.0) == DISCARD
        plant.go(1.0)
        other.go(1.0)
        assert plant.outputs() == other.outputs()


def test_a_law_answers_its_inputs_as_they_are_at_the_end_of_the_step():
    with Drive("WeightOnBitLaw", {"bit_speed": 3.0}) as law:
        must(law, law.set_slopes(bit_speed=2.0))
        law.go(0.25)
        assert law.get("WOB") == 5000.0 * 3.5 + 97347.0
        assert law.get("bit_speed") == 3.0
        law.go(0.5)
        assert law.get("WOB") == 5000.0 * 3.0 + 97347.0
    with Drive("DissipativeLaw", {"form": 2, "c_b": 0.0, "bit_torque_ref": 2000.0}) as law:
        must(law, law.set_slopes(top_speed=8.0, bit_speed_ref=-4.0, bit_torque_ref=1000.0))
        law.go(1.0)
        assert law.get("Omega") == pytest.approx(6.0 + 1.5 + 0.3 * (8.0 - 6.0), rel=1e-15)


def test_a_law_takes_a_held_input_as_it_is():
    # a product of 0 and the step size, added, would make +0 of -0, and the divisor would change its sign
    with Drive("DissipativeLaw", {"top_speed": -0.0, "bit_speed_ref": 0.2}) as law:
        negative = law.get("Omega")
        must(law, law.set_slopes(bit_speed=1.0))
        law.go(1e-9)
        assert law.get("Omega") == pytest.approx(negative, rel=1e-6)


@pytest.mark.parametrize("model", MODELS)
def test_every_real_input_takes_a_derivative_of_order_one_and_nothing_else_does(model):
    with Drive(model, {}) as fmu:
        driven = {name: variable for name, variable in fmu.variables.items() if variable.causality == "input"}
        inputs = [name for name, variable in driven.items() if variable.type == "Real"]
        assert fmu.library.description.coSimulation.canInterpolateInputs == bool(inputs)
        for name, variable in fmu.variables.items():
            if name in inputs:
                assert fmu.set_slopes(**{name: 0.0}) == OK
                for order in (0, 2, -1):
                    arguments = fmu.references([name]), 1, (c_int * 1)(order), byref(c_double(1.0))
                    assert fmu.call("SetRealInputDerivatives", *arguments) == ERROR
                    assert fmu.messages[-1].text.endswith(f"the order for {name} is {order}; expected 1")
            else:
                assert fmu.set_slopes(**{name: 0.0}) == ERROR
                said = f"{name} is no input" if variable.type == "Real" else f"{name} is of type {variable.type}"
                assert fmu.messages[-1].text.endswith(said)
        fmu.go(1.0)


def test_of_several_derivatives_all_are_set_or_none():
    with Drive(PLANT, {}) as plant, Drive(PLANT, {}) as untouched:
        references = plant.references(["Omega", "c_b"])
        slopes = (c_double * 2)(5.0, 1.0)
        assert plant.call("SetRealInputDerivatives", references, 2, (c_int * 2)(1, 1), slopes) == ERROR
        assert plant.set_slopes(Omega=5.0, WOB=float("nan")) == DISCARD
        plant.go(3.0)
        untouched.go(3.0)
        assert plant.outputs() == untouched.outputs()


def test_an_input_of_a_law_must_not_leave_its_range_within_the_step():
    with Drive("WeightOnBitLaw", {"bit_speed": 3.0}) as law:
        must(law, law.set_slopes(bit_speed=1e7))
        assert law.step(0.0, 1.0) == DISCARD
        assert "bit_speed comes to 10000003 rad/s at the end of the step" in law.messages[-1].text
        assert law.step(0.0, 0.01) == OK
