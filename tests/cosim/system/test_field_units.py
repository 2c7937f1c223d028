"""Numbers with units: one meaning wherever a number may stand, and a sentence where they have none.

Factors are those of NIST SP 811 (2008), Appendix B, exact.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cosim import Component, InputError, Ramp, Step, System, Table, load_scenario, simulate
from cosim.errors import ScenarioError
from cosim.system.description import Description, Unit, Variable
from cosim.system.field_units import in_declared_units, in_unit, quantity, shown_in

SPEED = Unit("rad/s", (0, 0, -1, 0, 0, 0, 0, 1))
FORCE = Unit("N", (1, 1, -2, 0, 0, 0, 0, 0))
HEAT = Unit("K", (0, 0, 0, 0, 1, 0, 0, 0))
VARIABLES = (
    Variable("Omega", 0, "Real", "input", start="0", unit=SPEED),
    Variable("WOB", 1, "Real", "parameter", "fixed", start="0", unit=FORCE),
    Variable("T", 2, "Real", "parameter", "fixed", start="0", unit=HEAT),
    Variable("dT", 3, "Real", "parameter", "fixed", start="0", unit=HEAT, relative=True),
    Variable("plain", 4, "Real", "parameter", "fixed", start="0"),
    Variable("own", 5, "Real", "parameter", "fixed", start="0", unit=Unit("turns/day")),
    Variable("label", 6, "String", "parameter", "fixed", start=""),
)
KNOWN = {"a": Description("A", "A", "{1}", VARIABLES)}
BASE = System((Component("a", "a.fmu"),))


def read(name: str, text: str) -> object:
    system = in_declared_units(BASE.with_values({f"a.{name}": text}), KNOWN)
    return system.components[0].parameters.get(name)


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("WOB", "20 klbf", 20.0 * 4448.2216152605),
        ("WOB", "20klbf", 20.0 * 4448.2216152605),
        ("WOB", "-.5e1 kN", -5000.0),
        ("WOB", "97347 N", 97347.0),
        ("WOB", "20 KLBF", 20.0 * 4448.2216152605),
        ("T", "20 degC", 293.15),
        ("dT", "20 degC", 20.0),
        ("own", "3 turns/day", 3.0),
    ],
)
def test_a_number_with_a_unit_is_in_the_unit_of_its_variable(name: str, text: str, value: float) -> None:
    assert read(name, text) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["120 rpm", "12 klbf"])
def test_a_string_variable_keeps_its_text(text: str) -> None:
    assert read("label", text) == text


@pytest.mark.parametrize("text", ["120", "rpm", "", "1e5", "-3", "1 2 rpm", "nan", "inf", "--1 rpm", "1.2.3"])
def test_what_is_no_number_with_a_unit_is_none(text: str) -> None:
    assert quantity(text) is None


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("WOB", "120 rpm", "a.WOB is '120 rpm', in rpm (= 0.10471975511966 s^-1 rad); expected N (= kg m s^-2)"),
        ("WOB", "2 klfb", "a.WOB is '2 klfb', and klfb is no unit known here; expected one that is, or N"),
        ("plain", "2 N", "a.plain is '2 N', but declares no unit; expected a number alone"),
        (
            "own",
            "2 rpm",
            "a.own is '2 rpm', and it is not known what turns/day is; expected a value in it, alone",
        ),
    ],
)
def test_a_unit_that_does_not_fit_is_refused(name: str, text: str, sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        read(name, text)
    assert str(refused.value) == sentence


@pytest.mark.parametrize(
    ("text", "unit", "sentence"),
    [
        ("5 rpm", "", "x is '5 rpm', but has no unit; expected a number alone"),
        ("five", "", "x is 'five'; expected a number"),
        ("five", "N", "x is 'five'; expected a number, with a unit or in N"),
        ("5 rpm", "turns/day", "x is '5 rpm', and it is not known what turns/day is; expected a value in it, alone"),
    ],
)
def test_a_number_that_cannot_be_brought_into_a_unit_is_a_sentence(text: str, unit: str, sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        in_unit(text, unit, "x")
    assert str(refused.value) == sentence


def test_a_number_in_a_unit_that_nobody_knows_is_taken_as_it_is() -> None:
    assert [in_unit(text, "turns/day", "x") for text in ("5", "5 turns/day")] == [5.0, 5.0]
    assert in_unit("2 min", "s", "x") == 120.0


def test_signals_are_read_level_by_level() -> None:
    signals = {
        "step": Step("60 rpm", "120 rpm", 5.0),
        "ramp": Ramp(60.0, 120.0, 1.0, 2.0, "rpm"),
        "table": Table((0.0, 1.0), (60.0, 120.0), "rpm"),
    }
    turn = math.pi / 30.0
    for kind, signal in signals.items():
        (found,) = in_declared_units(replace(BASE, inputs={"a.Omega": signal}), KNOWN).inputs.values()
        assert found.values(np.array([0.0, 10.0])).tolist() == [60 * turn, 120 * turn], kind


SCENARIO = """
stop_time = "0.1 min"
step_size = "10 ms"
[components.plant]
fmu = "DrillstringNeutral"
parameters = {{ L = "3845.1443569553803 ft" }}
[inputs]
"plant.WOB" = "21.884476183927518 klbf"
"plant.Omega" = {omega}
"""


@pytest.mark.parametrize(
    "omega",
    [
        '{ kind = "ramp", initial = "60 rpm", final = "120 rpm", start = "1 s", duration = "3 s" }',
        '{ kind = "ramp", initial = 60, final = 120, start = 1, duration = 3, unit = "rpm" }',
        '{ kind = "table", points = [[1, 60], [4, 120]], unit = "rpm" }',
    ],
)
def test_a_scenario_in_units_of_the_field_is_the_one_in_si(omega: str, tmp_path: Path) -> None:
    path = tmp_path / "field.toml"
    path.write_text(SCENARIO.format(omega=omega), encoding="utf-8")
    found = simulate(path)
    assert found.time[-1] == 6.0
    assert found["plant.Omega"][-1] == pytest.approx(4.0 * math.pi, rel=1e-15)
    assert found["plant.WOB"][0] == pytest.approx(97347.0, rel=1e-15)
    assert found.record["components"]["plant"]["parameters"]["L"] == pytest.approx(1172.0, rel=1e-15)
    assert "unit" not in found.record["inputs"]["plant.Omega"]


def test_a_ramp_in_units_without_duration_is_a_step(tmp_path: Path) -> None:
    path = tmp_path / "field.toml"
    omega = '{ kind = "ramp", initial = "60 rpm", final = "120 rpm", start = 1, duration = 0 }'
    path.write_text(SCENARIO.format(omega=omega), encoding="utf-8")
    assert simulate(path).record["inputs"]["plant.Omega"] == {
        "kind": "step", "before": 60 * (math.pi / 30), "after": 120 * (math.pi / 30), "at": 1.0
    }  # fmt: skip


@pytest.mark.parametrize(
    ("omega", "sentence"),
    [
        ('{ kind = "ramp", initial = "60 rpm", final = 120, start = 1, duration = 3 }', "in the units 'rpm', none"),
        ('{ kind = "ramp", initial = "6 rpm", final = "1 Hz", start = 1, duration = 3 }', "in the units 'rpm', 'Hz'"),
        ('{ kind = "ramp", initial = "fast", final = 120, start = 1, duration = 3 }', "'fast'; expected a number"),
        ('{ kind = "step", before = 1, after = 2, at = "1 rpm" }', r"at is '1 rpm', in rpm .*; expected s"),
    ],
)
def test_a_signal_whose_units_make_no_sense_is_refused(omega: str, sentence: str, tmp_path: Path) -> None:
    path = tmp_path / "field.toml"
    path.write_text(SCENARIO.format(omega=omega), encoding="utf-8")
    with pytest.raises((ScenarioError, InputError), match=sentence):
        load_scenario(path)


@pytest.mark.parametrize(
    ("unit", "units", "shown"),
    [
        ("N", "si", "kN"),
        ("rad/s", "si", "rad/s"),
        ("rad/s", "metric", "rpm"),
        ("N", "metric", "kN"),
        ("m", "field", "ft"),
    ],
)
def test_units_are_shown_as_people_know_them(unit: str, units: str, shown: str) -> None:
    assert shown_in(unit, units)[0] == shown


def test_units_that_are_not_known_are_shown_as_they_are() -> None:
    assert shown_in("turns/day", "field") == ("turns/day", 1.0)
