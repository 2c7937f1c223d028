"""The driller's commands over time: held values, a step, a ramp, or a table, and references that go with them."""

from __future__ import annotations

from ctypes import byref, c_double, c_int
from pathlib import Path

import numpy as np
import pytest

from models.plant.friction import Friction, torque_on_bit
from models.plant.parameters import DrillstringParameters
from tests.oracle import OracleParameters
from tests.plant import theory
from tests.plant.drive import Drive
from tests.plant.fmi import must

PACKAGINGS = ("native", "python")
ROTATION = ("Omega", "speed_ref", "bit_speed_ref")
PAPER = OracleParameters()
ROWS = "time,speed,WOB\n0,0,0\n2,10,50000\n2,4,60000\n5,4,90000\n"


def derivative(program: Drive, name: str) -> float:
    """Return the first derivative of an output at the communication point."""
    value = c_double()
    must(
        program,
        program.call("GetRealOutputDerivatives", program.references([name]), 1, (c_int * 1)(1), byref(value)),
    )
    return value.value


def asked(start_values: dict, times: list[float], packaging: str, start: float = 0.0) -> list[tuple[float, float]]:
    """Return rotation and weight at the start and at times."""
    pairs = []
    with Drive("DrillingProgram", start_values, packaging, start) as program:
        for time in (start, *times):
            if time > start:
                program.go(time)
            seen = program.named()
            assert seen["Omega"] == seen["speed_ref"] == seen["bit_speed_ref"]
            pairs.append((seen["Omega"], seen["WOB"]))
    return pairs


@pytest.fixture
def table(tmp_path: Path) -> Path:
    file = tmp_path / "program.csv"
    file.write_text(ROWS)
    return file


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_nothing_set_asks_for_the_inputs_of_figure_2(packaging):
    assert asked({}, [0.5, 100.0], packaging) == [(10.0, 97347.0)] * 3


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_step_is_right_after_its_time_and_at_it(packaging):
    start = {"speed_final": 20.0, "speed_start": 1.5, "WOB_final": 3e4, "WOB_start": 2.0}
    pairs = asked(start, [1.0, 1.4999, 1.5, 1.9999, 2.0, 50.0], packaging)
    assert [omega for omega, _ in pairs] == [10.0, 10.0, 10.0, 20.0, 20.0, 20.0, 20.0]
    assert [weight for _, weight in pairs] == [97347.0] * 5 + [3e4] * 2


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_step_is_not_missed_by_the_rounding_of_added_up_times(packaging):
    with Drive("DrillingProgram", {"speed_final": 20.0, "speed_start": 0.8}, packaging) as program:
        time = 0.0
        for _ in range(8):
            must(program, program.step(time, 0.1))
            time += 0.1
        assert time < 0.8
        assert program.get("Omega") == 20.0


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_ramp_is_a_straight_line_between_its_ends(packaging):
    start = {
        "speed_initial": 2.0, "speed_final": 12.0, "speed_start": 1.0, "speed_duration": 4.0,
        "WOB_initial": 8e4, "WOB_final": 0.0, "WOB_start": -1.0, "WOB_duration": 4.0,
    }  # fmt: skip
    times = [0.5, 1.0, 2.0, 3.5, 5.0, 9.0]
    pairs = np.array(asked(start, times, packaging))
    times = np.array([0.0, *times])
    assert pairs[:, 0] == pytest.approx(np.interp(times, [1.0, 5.0], [2.0, 12.0]), rel=1e-15)
    assert pairs[:, 1] == pytest.approx(np.interp(times, [-1.0, 3.0], [8e4, 0.0]), rel=1e-15)


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_table_is_straight_between_rows_jumps_where_two_share_a_time_and_keeps_the_last(packaging, table):
    times = [0.5, 1.0, 1.9999, 2.0, 3.0, 4.5, 5.0, 80.0]
    pairs = np.array(asked({"table": str(table)}, times, packaging))
    assert pairs[:, 0] == pytest.approx([0.0, 2.5, 5.0, 9.9995, 4.0, 4.0, 4.0, 4.0, 4.0], rel=1e-14)
    assert pairs[:, 1] == pytest.approx([0, 12500, 25000, 49997.5, 6e4, 7e4, 8.5e4, 9e4, 9e4], rel=1e-14)


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_table_holds_its_first_row_before_its_time(packaging, table):
    assert asked({"table": str(table)}, [-1.0], packaging, start=-3.0) == [(0.0, 0.0)] * 2


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_table_takes_the_place_of_both_changes(packaging, table):
    start = {"table": str(table), "speed_final": 33.0, "WOB_final": 1.0}
    assert asked(start, [9.0], packaging)[-1] == (4.0, 9e4)


@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_table_is_read_once(packaging, table):
    with Drive("DrillingProgram", {"table": str(table)}, packaging) as program:
        table.unlink()
        program.go(1.0)
        assert program.get("Omega") == 5.0


@pytest.mark.parametrize("speed", [-30.0, -1.0, 0.01, 1.0, 6.205186764, 10.0])
@pytest.mark.parametrize("packaging", PACKAGINGS)
def test_torque_reference_is_that_of_equations_3_and_4(packaging, speed):
    start = {"speed_final": speed, "WOB_final": 31649.0, "c_b": 15.0, "v_f": 2.0}
    parameters = OracleParameters(c_b=15.0, v_f=2.0)
    with Drive("DrillingProgram", start, packaging) as program:
        expected = theory.torque_on_bit(parameters, 31649.0, speed)
        assert program.get("bit_torque_ref") == pytest.approx(expected, rel=1e-14)


def test_torque_reference_at_rest_is_none():
    with Drive("DrillingProgram", {"speed_final": 0.0}) as program:
        assert program.get("bit_torque_ref") == 0.0
        program.go(1.0)
        assert derivative(program, "bit_torque_ref") == 0.0


def test_friction_of_the_models_is_equation_4():
    parameters = DrillstringParameters()
    coefficient = Friction.of(parameters, 1.0)
    assert coefficient.at(1.0, 0.0)[0] == pytest.approx(0.8, rel=1e-15)
    assert coefficient.at(1.0, 2.0)[0] == pytest.approx(0.5 + 0.3 * np.exp(-1.8), rel=1e-15)
    assert coefficient.at(1.0, 1e3)[0] == 0.5
    for speed in (-7.0, 3.0):
        expected = theory.torque_on_bit(PAPER, 5e4, speed)
        assert torque_on_bit(parameters, 5e4, speed) == pytest.approx(expected, rel=1e-14)
    assert torque_on_bit(parameters, 5e4, 0.0) == 0.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_output_derivatives_are_the_slopes_of_the_outputs(sign):
    start = {
        "speed_initial": sign * 2.0, "speed_final": sign * 12.0, "speed_start": 1.0, "speed_duration": 4.0,
        "WOB_initial": 8e4, "WOB_final": 2e4, "WOB_start": 2.0, "WOB_duration": 4.0, "c_b": 7.0,
    }  # fmt: skip
    h = 1e-4
    for time in (0.5, 1.5, 3.0, 5.5, 7.0):
        with Drive("DrillingProgram", start) as program:
            program.go(time - h)
            before = program.named()
            program.go(time)
            slopes = {name: derivative(program, name) for name in program.names}
            program.go(time + h)
            after = program.named()
        for name, slope in slopes.items():
            assert slope == pytest.approx((after[name] - before[name]) / (2 * h), rel=1e-6, abs=1e-6), (name, time)


def test_output_derivatives_at_a_kink_are_those_of_the_time_to_come(table):
    with Drive("DrillingProgram", {"table": str(table)}) as program:
        assert derivative(program, "Omega") == 5.0
        program.go(2.0)
        assert [derivative(program, name) for name in ROTATION] == [0.0] * 3
        assert derivative(program, "WOB") == 1e4
        program.go(5.0)
        assert derivative(program, "WOB") == 0.0


def test_plant_given_the_derivatives_follows_the_ramp():
    # what a master hands on is the program itself: work_in of both ways is the same to the order of the step
    start = {"speed_initial": 0.0, "speed_final": 12.0, "speed_duration": 6.0}
    totals = []
    for step in (0.5, 0.125):
        with Drive("DrillingProgram", start) as program, Drive("DrillstringNeutral", {"Omega": 0.0}) as plant:
            for k in range(int(8.0 / step)):
                plant.put(Omega=program.get("Omega"))
                must(plant, plant.set_slopes(Omega=derivative(program, "Omega")))
                plant.go((k + 1) * step)
                program.go((k + 1) * step)
            totals.append(plant.get("bit_angle"))
    assert totals[0] == pytest.approx(totals[1], abs=1e-6)
