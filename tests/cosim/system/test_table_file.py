"""Tables from CSV files: what they say is taken, what they leave open is said or refused."""

from __future__ import annotations

import logging
import math
from pathlib import Path

import pytest

from cosim import co_simulate
from cosim.errors import ScenarioError, SystemDefinitionError
from cosim.system.description import Unit, Variable
from cosim.system.field_units import field_unit, in_declared_units
from cosim.system.method import Method
from cosim.system.signals import Ramp, Table
from cosim.system.structure import Component, System
from cosim.system.table_file import read_table
from tests.cosim.fakes import RAD_PER_S, FakeSlave, describe

NEWTON = Unit("N", (1, 1, -2, 0, 0, 0, 0, 0))


@pytest.fixture
def written(tmp_path: Path):
    def write(text: str, encoding: str = "utf-8") -> Path:
        path = tmp_path / "data.csv"
        path.write_bytes(text.encode(encoding))
        return path

    return write


def driven(table: Table, unit: Unit | None) -> Table:
    """Return what a table becomes at an input that declares a unit."""
    system = System((Component("plant", "fake"),), inputs={"plant.u": table})
    described = describe({"u": 0.0}, ["y"], units={"u": unit} if unit else None)
    signal = in_declared_units(system, {"plant": described}).inputs["plant.u"]
    assert isinstance(signal, Table)
    return signal


# rpm by 2 pi / 60, lbf and ft by NIST SP 811, degF by its definition.
@pytest.mark.parametrize(
    ("header", "value", "declared", "expected"),
    [
        ("Rotary Speed (rpm)", 120.0, RAD_PER_S, 4.0 * math.pi),
        ("RPM [RPM]", 60.0, RAD_PER_S, 2.0 * math.pi),
        ("WOB (klbf)", 10.0, NEWTON, 44482.216152605),
        ("WOB (KLBF)", 10.0, NEWTON, 44482.216152605),
        ("WOB (kN)", 97.347, NEWTON, 97347.0),
        ("ROP (ft/hr)", 100.0, Unit("m/s", (0, 1, -1, 0, 0, 0, 0, 0)), 100.0 * 0.3048 / 3600.0),
        ("Temp (degF)", 212.0, Unit("degC", (0, 0, 0, 0, 1, 0, 0, 0), 1.0, 273.15), 100.0),
        ("Torque (ft-lbf)", 1000.0, Unit("N.m", (1, 2, -2, 0, 0, 0, 0, 0)), 1355.8179483314),
        ("speed (rad/s)", 3.0, RAD_PER_S, 3.0),
        ("WOB (klbf)", 10.0, Unit("kN"), 44.482216152605),
    ],
)
def test_values_in_units_of_the_field_reach_the_input_in_its_own(
    written, header: str, value: float, declared: Unit, expected: float
) -> None:
    table = read_table(written(f"time,{header}\n0,{value}\n5,{value}\n"))
    assert driven(table, declared).points == pytest.approx((expected, expected), rel=1e-12)


def test_a_difference_of_temperatures_is_converted_without_an_offset(written) -> None:
    table = read_table(written("time,dT (degF)\n0,9\n"))
    kelvin = Unit("K", (0, 0, 0, 0, 1, 0, 0, 0))
    difference = Variable("u", 0, "Real", "input", unit=kelvin, start="0", relative=True)
    system = System((Component("plant", "fake"),), inputs={"plant.u": table})
    found = in_declared_units(system, {"plant": describe(extra=(difference,))}).inputs["plant.u"]
    assert isinstance(found, Table)
    assert found.points == pytest.approx((5.0,), rel=1e-15)


def test_the_master_steps_with_converted_values(written) -> None:
    path = written("time (min),Rotary Speed (rpm)\n0,60\n1,60\n")
    system = System((Component("plant", "fake"),), inputs={"plant.u": read_table(path)})
    slave = FakeSlave(lambda t, u: [u], description=describe({"u": 0.0}, ["y"], units={"u": RAD_PER_S}))
    result = co_simulate(system, {"plant": slave}, stop_time=1.0, step_size=0.5)
    assert result["plant.u"].tolist() == pytest.approx([2.0 * math.pi] * 3, rel=1e-15)


def test_a_unit_of_another_kind_is_refused(written) -> None:
    table = read_table(written("time,WOB (klbf)\n0,10\n"))
    with pytest.raises(SystemDefinitionError, match=r"^plant\.u is a table, in klbf \(= .*\); expected rad/s"):
        driven(table, RAD_PER_S)
    table = read_table(written("time,WOB (bananas)\n0,10\n"))
    with pytest.raises(
        SystemDefinitionError, match="a table, and bananas is no unit known here; expected one that is, or N"
    ):
        driven(table, NEWTON)


def test_milli_and_mega_are_never_taken_for_each_other() -> None:
    mega = field_unit("MPa")
    assert mega is not None
    assert mega.factor == 1e6
    assert field_unit("mPa") is None
    assert field_unit("Kn") is None


def test_a_second_row_of_the_header_gives_the_units_of_times_and_values(written) -> None:
    path = written("Elapsed Time,Hookload,WOB\n(min),(klbf),(kN)\n0,250,10\n2,251,20\n")
    assert read_table(path, "WOB") == Table((0.0, 120.0), (10.0, 20.0), "kN")
    assert read_table(path, "Hookload").unit == "klbf"


def test_a_row_of_ones_is_no_row_of_units(written) -> None:
    assert read_table(written("time,WOB\n1,1\n2,3\n")) == Table((1.0, 2.0), (1.0, 3.0))


def test_what_the_user_says_of_the_unit_holds_before_what_the_name_says(written) -> None:
    path = written("time,WOB (klbf)\n0,2\n")
    assert read_table(path, unit="kN") == Table((0.0,), (2.0,), "kN")
    assert read_table(path, factor=1e3) == Table((0.0,), (2e3,))
    assert read_table(path, "WOB", unit="N", factor=1e3) == Table((0.0,), (2e3,), "N")


def test_a_file_without_a_header_is_refused_and_loses_no_row(written) -> None:
    with pytest.raises(ScenarioError, match=r"data\.csv, line 1: there are only numbers; expected the names"):
        read_table(written("0,10\n1,20\n2,30\n"))


def test_a_name_that_is_there_twice_is_refused(written) -> None:
    with pytest.raises(ScenarioError, match=r"data\.csv, line 1: column 'WOB' is there 2 times"):
        read_table(written("time,WOB,WOB\n0,1,2\n"), "WOB")
    with pytest.raises(ScenarioError, match=r"line 1: column 'WOB' may be 'WOB \(kN\)' and 'WOB \(klbf\)'"):
        read_table(written("time,WOB (kN),WOB (klbf)\n0,1,2\n"), "WOB")


def test_the_time_is_found_wherever_it_is(written) -> None:
    assert read_table(written("WOB,depth,Time\n5,100,0\n6,100,1\n"), "WOB") == Table((0.0, 1.0), (5.0, 6.0))
    assert read_table(written("WOB,clock\n5,0\n6,1\n"), time="clock") == Table((0.0, 1.0), (5.0, 6.0))
    with pytest.raises(ScenarioError, match=r"'time' and 'Elapsed Time' may both be the time"):
        read_table(written("time,Elapsed Time,WOB\n0,0,1\n"), "WOB")


def test_a_first_column_that_is_not_called_time_must_rise_and_is_told(
    written, caplog: pytest.LogCaptureFixture
) -> None:
    with pytest.raises(ScenarioError, match=r"line 3: no column is called time, and the first, 'WOB', does not rise"):
        read_table(written("WOB,speed\n5,0\n4,1\n"))
    assert read_table(written("seconds,speed\n0,1\n1,2\n")) == Table((0.0, 1.0), (1.0, 2.0))
    assert "taken as follows: the time is in the first column, 'seconds'" in caplog.text


def test_a_guess_is_a_warning_and_what_was_said_is_not(written, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO, "cosim")
    read_table(written("time,WOB (klbf)\n0,10\n"))
    read_table(written("time,WOB (klbf)\n0,10\n"), unit="klbf")
    assert [record.levelno for record in caplog.records] == [logging.WARNING, logging.INFO]
    assert "the unit of 'WOB (klbf)' is klbf, as its name says" in caplog.text


def test_clock_times_are_counted_from_the_first(written) -> None:
    stamped = "Date Time,WOB\n2024-03-01T23:59:59.5Z,1\n2024-03-02T00:00:00Z,2\n2024-03-02 01:00:01+01:00,3\n"
    assert read_table(written(stamped)) == Table((0.0, 0.5, 1.5), (1.0, 2.0, 3.0))
    assert read_table(written("time,WOB\n12:00:00,1\n12:01:00,2\n")) == Table((0.0, 60.0), (1.0, 2.0))
    with pytest.raises(ScenarioError, match="line 3: 'noon' is not a time by ISO 8601"):
        read_table(written("time,WOB\n12:00:00,1\nnoon,2\n"))
    with pytest.raises(ScenarioError, match=r"line 3: .* not both with a time zone"):
        read_table(written("time,WOB\n2024-03-01T00:00:00,1\n2024-03-01T00:00:01Z,2\n"))


@pytest.mark.parametrize("gap", ["", "NaN", "null", "-999.25", "-999.2500"])
def test_gaps_are_refused_held_or_bridged(written, gap: str) -> None:
    path = written(f"time,WOB\n0,1\n1,{gap}\n2,5\n")
    with pytest.raises(ScenarioError, match=r"data\.csv, line 3: '.*' is not a number; gaps = "):
        read_table(path)
    assert read_table(path, gaps="hold") == Table((0.0, 1.0, 2.0), (1.0, 1.0, 5.0))
    assert read_table(path, gaps="interpolate") == Table((0.0, 2.0), (1.0, 5.0))


def test_a_gap_of_las_is_one_with_a_comma_too(written) -> None:
    path = written("time;WOB\n0;1\n1;-999,2500\n2;5\n")
    assert read_table(path, decimal=",", gaps="hold") == Table((0.0, 1.0, 2.0), (1.0, 1.0, 5.0))


def test_separator_and_decimal_are_those_of_the_file(written) -> None:
    path = written("Zeit;WOB\n0,5;1,25\n1,5;2,5\n")
    assert read_table(path, time="Zeit", decimal=",") == Table((0.5, 1.5), (1.25, 2.5))
    with pytest.raises(ScenarioError, match=r"line 2: '0,5' is not a number; decimal = \",\" reads it"):
        read_table(path, time="Zeit")
    assert read_table(written("time\tWOB\n0\t1\n")) == Table((0.0,), (1.0,))
    assert read_table(written("time|WOB\n0|1\n"), separator="|") == Table((0.0,), (1.0,))


def test_a_byte_order_mark_is_no_part_of_a_name(written) -> None:
    assert read_table(written("WOB,time\n1,0\n2,1\n", "utf-8-sig"), "WOB") == Table((0.0, 1.0), (1.0, 2.0))


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("time,WOB\n0,1\n2,1\n1,1\n", {}, "line 4: times must not decrease"),
        ("time,WOB\n0,1\n0,2\n0,3\n", {}, "line 4: this time is given more than twice"),
        ("time,WOB\n\n\n0,1_000\n", {}, "line 4: '1_000' is not a number"),
        ("time,WOB\n0,inf\n", {}, "line 2: 'inf' is not a finite number"),
        ("time,WOB\n", {}, "there is no row below the names"),
        ("time (UTC),WOB\n0,1\n", {}, "'UTC' is no unit of time"),
        ("time,WOB\n,1\n", {}, "line 2: the time is missing"),
        ("time,WOB\n0,1\n", {"gaps": "hodl"}, "gaps is 'hodl'; did you mean 'hold'"),
        ("time,WOB\n0,1\n", {"factor": 0.0}, "factor is 0; expected"),
        ("time,WOB\n0,1\n", {"separator": "::"}, "expected one character"),
        ("time,WOB\n0,1\n", {"decimal": ",", "separator": ","}, "expected two that differ"),
        ("time,WOB\n0,1\n", {"time": "tiem"}, "there is no column 'tiem'; known: time, WOB"),
    ],
)
def test_what_cannot_be_read_is_a_sentence_with_file_and_line(written, text: str, options: dict, message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as refused:
        read_table(written(text), **options)
    assert "data.csv" in str(refused.value)


def test_a_row_with_more_cells_than_the_header_has_names_is_refused(written) -> None:
    """As of numbers with a separator of thousands: 1,000 N would be 1 N."""
    with pytest.raises(ScenarioError, match=r"data\.csv, line 3: there are 3 cells; expected 2 at most"):
        read_table(written("time,WOB\n0,900\n1,1,000\n"))
    assert read_table(written("time,WOB\n0,900,\n1,901,,\n")) == Table((0.0, 1.0), (900.0, 901.0))
    with pytest.raises(ScenarioError, match=r"line 2: '1,000' is not a number; decimal = \",\" reads it as 1$"):
        read_table(written('time,WOB\n0,"1,000"\n'))


def test_a_file_in_another_encoding_is_read_and_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = tmp_path / "data.csv"
    path.write_bytes("time,Größe (kN)\n0,1\n".encode("windows-1252"))
    assert read_table(path) == Table((0.0,), (1.0,), "kN")
    assert "the file, which is not in UTF-8, is in windows-1252; the unit of 'Größe (kN)' is kN" in caplog.text
    path.write_bytes("time,Größe (kN)\n0,1\n".encode("utf-16"))
    assert read_table(path, unit="kN", column="Größe") == Table((0.0,), (1.0,), "kN")


def test_times_in_another_unit_are_told(written, caplog: pytest.LogCaptureFixture) -> None:
    assert read_table(written("time (h),WOB\n0,1\n1,2\n")).times == (0.0, 3600.0)
    assert "the times are in h, as its name says" in caplog.text


@pytest.mark.parametrize("algorithm", ["jacobi", "implicit"])
@pytest.mark.parametrize(
    ("signal", "message"),
    [
        (Table((0.0, 1.0, 2.0), (1.0, -999.0, 1.0)), r"plant\.u at t = 1\.00 s is -999; expected a finite number >= 0"),
        (Table((0.0, 1.5), (1.0, 7.0)), r"plant\.u at t = 1\.50 s is 7; expected"),
        (Ramp(1.0, 20.0, 0.0, 10.0), r"plant\.u at t = 2\.00 s is 4\.8; expected a finite number >= 0 and <= 4"),
    ],
)
def test_a_signal_that_leaves_the_range_of_its_input_is_refused_before_the_run(
    signal: Table | Ramp, message: str, algorithm: str
) -> None:
    bounded = Variable("u", 0, "Real", "input", start="0", minimum=0.0, maximum=4.0)
    slave = FakeSlave(lambda t, u: [u], description=describe(outputs=["y"], extra=(bounded,)))
    system = System((Component("plant", "fake"),), inputs={"plant.u": signal})
    with pytest.raises(SystemDefinitionError, match=message):
        co_simulate(system, {"plant": slave}, stop_time=2.0, step_size=0.5, method=Method(algorithm))
    assert slave.steps == []


def test_what_a_table_holds_after_the_run_is_nothing_to_it_and_none_within_is_told(
    caplog: pytest.LogCaptureFixture,
) -> None:
    bounded = Variable("u", 0, "Real", "input", start="0", minimum=0.0, maximum=4.0)
    for table in (Table((0.0, 2.0, 3.0), (1.0, 2.0, -999.0)), Table((1.7e9, 1.8e9), (1.0, 2.0))):
        slave = FakeSlave(lambda t, u: [u], description=describe(outputs=["y"], extra=(bounded,)))
        system = System((Component("plant", "fake"),), inputs={"plant.u": table})
        co_simulate(system, {"plant": slave}, stop_time=2.0, step_size=0.5)
    (record,) = caplog.records
    assert record.getMessage().startswith("plant.u: the table goes from 1700000000")
    assert record.getMessage().endswith("so that nothing of it is in the run")
