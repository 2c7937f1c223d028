"""Every refusal is a sentence that names component, variable, expected and actual."""

from __future__ import annotations

import logging

import pytest

from cosim import Component, Connection, Constant, Step, System, ramp
from cosim.errors import SspError, SystemDefinitionError
from cosim.scenario.ssp.parameters import Given
from cosim.system.compatibility import check_system
from cosim.system.description import Description, Unit, Variable

SPEED = Unit("rad/s", (0, 0, -1, 0, 0, 0, 0, 1))
RPM = Unit("rpm", (0, 0, -1, 0, 0, 0, 0, 1), factor=0.10471975511965977)
FORCE = Unit("N", (1, 1, -2, 0, 0, 0, 0, 0))
FORM = {"printed": 1, "tracking": 2}

PLANT = Description(
    "Plant",
    "Plant",
    "{1}",
    (
        Variable("WOB", 0, "Real", "input", unit=FORCE, start="1", minimum=0.0),
        Variable("Omega", 1, "Real", "input", unit=SPEED, start=None),
        Variable("gate", 2, "Boolean", "input", start="false"),
        Variable("bit_speed", 3, "Real", "output", unit=SPEED),
        Variable("rpm", 4, "Real", "output", unit=RPM),
        Variable("plain", 5, "Real", "output"),
        Variable("slips", 6, "Integer", "output"),
        Variable("L", 7, "Real", "parameter", "fixed", unit=Unit("m"), start="1172", minimum=1.0, maximum=1e5),
        Variable("cells", 8, "Integer", "parameter", "fixed", start="0", minimum=0.0),
        Variable("form", 9, "Enumeration", "parameter", "fixed", start="1", items=FORM),
        Variable("on", 10, "Boolean", "parameter", "fixed", start="true"),
        Variable("name", 11, "String", "parameter", "fixed", start=""),
        Variable("derived", 12, "Real", "calculatedParameter", "fixed", "calculated"),
        Variable("label", 13, "String", "input", "discrete", start=""),
        Variable("c_b", 14, "Real", "parameter", "tunable", start="0.03", minimum=0.0),
    ),
)
OTHER = {"plant": PLANT, "law": PLANT}


def check(connections=(), inputs=None, plant=None, law=None):
    inputs = {"plant.Omega": Constant(1.0), "law.Omega": Constant(1.0), **(inputs or {})}
    for connection in connections:
        inputs.pop(connection.target, None)
    components = (Component("plant", "a.fmu", plant or {}), Component("law", "b.fmu", law or {}))
    return check_system(System(components, tuple(connections), inputs), OTHER)


@pytest.mark.parametrize(
    ("source", "target", "message"),
    [
        ("plant.bit_sped", "law.Omega", r"plant: Plant has no variable 'bit_sped'; did you mean 'bit_speed'\?"),
        ("plant.L", "law.Omega", r"plant\.L has causality parameter; expected output"),
        ("plant.bit_speed", "law.rpm", r"law\.rpm has causality output; expected input"),
        ("plant.slips", "law.Omega", r"plant\.slips is Integer; expected Real"),
        ("plant.bit_speed", "law.WOB", r"the source is in rad/s \(= s\^-1 rad\); expected N \(= kg m s\^-2\)"),
    ],
)
def test_a_connection_that_does_not_fit_is_refused(source: str, target: str, message: str) -> None:
    with pytest.raises(SystemDefinitionError, match=message):
        check([Connection(source, target)])


def test_one_missing_unit_is_allowed_with_a_warning(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        check([Connection("plant.plain", "law.Omega")])
    assert "plant.plain -> law.Omega: cannot tell whether no unit and rad/s" in caplog.text


def test_an_unconnected_input_without_start_value_is_refused() -> None:
    system = System((Component("plant", "a.fmu"),))
    with pytest.raises(SystemDefinitionError, match=r"plant\.Omega is not connected and has no start value"):
        check_system(system, {"plant": PLANT})


def test_an_input_has_one_source() -> None:
    components = (Component("plant", "a.fmu"), Component("law", "b.fmu"))
    twice = (Connection("plant.bit_speed", "law.Omega"), Connection("law.bit_speed", "law.Omega"))
    with pytest.raises(SystemDefinitionError, match=r"law\.Omega is driven by plant\.bit_speed and by law\.bit_speed"):
        System(components, twice)
    with pytest.raises(SystemDefinitionError, match=r"law\.Omega is driven by a signal and by plant\.bit_speed"):
        System(components, twice[:1], {"law.Omega": Constant(1.0)})
    with pytest.raises(
        SystemDefinitionError, match=r"law\.Omega is driven by plant\.bit_speed; its value cannot be set"
    ):
        check([twice[0]], law={"Omega": 3.0})


def test_an_unknown_component_is_refused_with_the_nearest() -> None:
    with pytest.raises(
        SystemDefinitionError, match=r"plent\.Omega: there is no component 'plent'; did you mean 'plant'"
    ):
        System((Component("plant", "a.fmu"),), inputs={"plent.Omega": Constant(1.0)})


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("LL", 1.0, "plant: Plant has no variable 'LL'"),
        ("bit_speed", 1.0, r"plant\.bit_speed is an output; expected a parameter"),
        ("derived", 1.0, r"plant\.derived is a calculatedParameter"),
        ("L", -5, r"plant\.L is -5 m; expected a finite number >= 1 and <= 100000 m"),
        ("L", float("nan"), r"plant\.L is nan m; expected a finite number"),
        ("WOB", -1.0, r"plant\.WOB is -1 N; expected a finite number >= 0 N"),
        ("L", True, r"plant\.L is true; expected a number"),
        ("L", "long", r"plant\.L is 'long'; expected a number"),
        ("cells", 1.5, r"plant\.cells is 1\.5; expected an integer"),
        ("cells", 2**31, r"plant\.cells is 2147483648; expected a finite number >= 0 and <= 2147483647"),
        ("on", 1, r"plant\.on is 1; expected true or false"),
        ("name", 1, r"plant\.name is 1; expected a string"),
        ("form", "printd", r"plant\.form is 'printd'; expected one of 'printed' \(1\), 'tracking' \(2\)"),
        ("form", 3, r"plant\.form is 3; expected one of"),
    ],
)
def test_a_start_value_that_does_not_fit_is_refused(name: str, value, message: str) -> None:
    with pytest.raises(SystemDefinitionError, match=message):
        check(plant={name: value})


def test_start_values_take_the_type_of_their_variable() -> None:
    values = check(plant={"L": 1000, "cells": 3, "form": "tracking", "on": False, "name": "x", "WOB": 7})["plant"]
    assert {variable.name: value for variable, value in values.items()} == {
        "L": 1000.0, "cells": 3, "form": 2, "on": False, "name": "x", "WOB": 7.0
    }  # fmt: skip
    assert all(type(v) is float for variable, v in values.items() if variable.type == "Real")


@pytest.mark.parametrize(
    ("target", "signal", "message"),
    [
        (
            "plant.bit_speed",
            Constant(1.0),
            "has causality output; a signal drives an input or a tunable parameter only",
        ),
        ("plant.L", Constant(1.0), "is a fixed parameter; a signal drives an input or a tunable parameter only"),
        ("plant.derived", Constant(1.0), "has causality calculatedParameter; a signal drives an input or a tunable"),
        ("plant.gate", ramp(0, 1, 0, 1), "is Boolean; a ramp drives Real variables only"),
        ("plant.c_b", Step(1.0, -2.0, 0.5), "is -2; expected a finite number >= 0"),
        ("plant.c_c", Constant(1.0), r"has no variable 'c_c'; did you mean 'c_b'\?"),
        ("plant.gate", Constant(1.0), "is 1.0; expected true or false"),
        ("plant.WOB", Constant(-1.0), "is -1 N; expected a finite number >= 0"),
        ("plant.WOB", Step(1.0, -2.0, 0.5), "is -2 N; expected a finite number >= 0"),
        ("plant.label", Constant(1.0), "is 1.0; expected a string"),
    ],
)
def test_a_signal_that_does_not_fit_is_refused(target: str, signal, message: str) -> None:
    with pytest.raises(SystemDefinitionError, match=message):
        check(inputs={target: signal})


def test_a_value_replaces_a_signal_but_not_a_connection() -> None:
    base = System((Component("plant", "a.fmu"),), inputs={"plant.Omega": Step(1.0, 2.0, 3.0)})
    assert base.with_values({"plant.Omega": 5.0}).inputs["plant.Omega"] == Constant(5.0)
    assert base.with_values({"plant.L": 5.0}).components[0].parameters == {"L": 5.0}
    assert base.inputs["plant.Omega"] == Step(1.0, 2.0, 3.0), "the original stays as it is"


def test_a_parameter_is_driven_or_set_and_not_both() -> None:
    assert check(inputs={"plant.c_b": Step(0.03, 2.0, 0.5)})["plant"] == {}
    with pytest.raises(
        SystemDefinitionError, match=r"plant\.c_b is driven by a signal; its value cannot be set as well"
    ):
        check(inputs={"plant.c_b": Step(0.03, 2.0, 0.5)}, plant={"c_b": 1.0})


KELVIN = Unit("K", (0, 0, 0, 0, 1, 0, 0, 0))
CELSIUS = Unit("degC", (0, 0, 0, 0, 1, 0, 0, 0), offset=273.15)


def ends(source: Variable, target: Variable, **options: bool) -> None:
    """Check a connection between two variables."""
    descriptions = {"a": Description("A", "A", "{1}", (source,)), "b": Description("B", "B", "{2}", (target,))}
    components = (Component("a", "a.fmu"), Component("b", "b.fmu"))
    check_system(System(components, (Connection("a.y", "b.u", **options),)), descriptions)


def end(name: str, **attributes) -> Variable:
    return Variable(name, 0, "Real", "output" if name == "y" else "input", **attributes)


def test_differences_have_no_offset(caplog: pytest.LogCaptureFixture) -> None:
    ends(end("y", unit=CELSIUS, relative=True), end("u", unit=KELVIN, relative=True))
    assert caplog.text == ""
    ends(end("y", unit=CELSIUS, relative=True), end("u", unit=KELVIN))
    (record,) = caplog.records
    assert record.getMessage() == (
        "connection a.y -> b.u: the source alone is a difference; degC (= K) is passed on as one of K (= K)"
    )
    with pytest.raises(SystemDefinitionError, match=r"in degC \(= K\); expected degC \(= K \+ 273\.15\)"):
        ends(end("y", unit=CELSIUS, relative=True), end("u", unit=CELSIUS))
    with pytest.raises(SystemDefinitionError, match=r"the source is in degC \(= K \+ 273\.15\); expected K"):
        ends(end("y", unit=CELSIUS), end("u", unit=KELVIN, relative=True))
    ends(end("y", unit=CELSIUS), end("u", unit=KELVIN))


@pytest.mark.parametrize(
    ("variable", "value"), [(end("u", unit=KELVIN), 278.15), (end("u", unit=KELVIN, relative=True), 5.0)]
)
def test_a_difference_is_converted_without_offset(variable: Variable, value: float) -> None:
    assert Given(5.0, CELSIUS).for_variable("b.u", variable) == value


def test_a_unit_that_one_side_does_not_define_is_taken_by_its_name_with_one_warning(
    caplog: pytest.LogCaptureFixture,
) -> None:
    outputs = tuple(Variable(f"y{index}", index, "Real", "output", unit=Unit("rad/s")) for index in range(3))
    inputs = tuple(Variable(f"u{index}", index, "Real", "input", unit=SPEED) for index in range(3))
    descriptions = {"a": Description("A", "A", "{1}", outputs), "b": Description("B", "B", "{2}", inputs)}
    connections = tuple(Connection(f"a.y{index}", f"b.u{index}") for index in range(3))
    check_system(System((Component("a", "a.fmu"), Component("b", "b.fmu")), connections), descriptions)
    (record,) = caplog.records
    assert record.getMessage() == (
        "connection a.y0 -> b.u0: rad/s and rad/s (= s^-1 rad) are taken for the same unit, which one FMU does not "
        "define"
    )


def test_a_value_is_taken_by_the_name_of_its_unit_and_warned_of_once(caplog: pytest.LogCaptureFixture) -> None:
    told: set[str] = set()
    given = Given(5.0, Unit("rad/s"))
    assert [given.for_variable("a.u", end("u", unit=SPEED), told) for _ in range(2)] == [5.0, 5.0]
    assert given.for_variable("a.u", end("u"), told) == 5.0
    assert [record.getMessage() for record in caplog.records] == [
        "a.u is given in rad/s and taken as rad/s (= s^-1 rad) as it is"
    ]
    with pytest.raises(SspError, match=r"a\.u is given in rpm; expected rad/s"):
        Given(5.0, Unit("rpm")).for_variable("a.u", end("u", unit=SPEED))


def test_units_are_not_compared_where_values_are_passed_on_unconverted() -> None:
    with pytest.raises(SystemDefinitionError, match=r"the source is in N .*; expected rad/s"):
        ends(end("y", unit=FORCE), end("u", unit=SPEED))
    ends(end("y", unit=FORCE), end("u", unit=SPEED), unconverted=True)
    ends(end("y", unit=RPM), end("u", unit=SPEED))


def chosen(name: str, items: dict[str, int]) -> Variable:
    return Variable(name, 0, "Enumeration", "output" if name == "y" else "input", "discrete", start="1", items=items)


def test_enumerations_with_other_items_connect_with_a_warning_or_not_at_all(caplog: pytest.LogCaptureFixture) -> None:
    ends(chosen("y", FORM), chosen("u", dict(reversed(FORM.items()))))
    assert caplog.text == ""
    ends(chosen("y", FORM), chosen("u", {"printed": 1, "other": 3}))
    assert (
        "connection a.y -> b.u: the items at the source are 'printed' (1), 'tracking' (2), at the input 'printed' (1), "
        "'other' (3); numbers are passed on"
    ) in caplog.text
    ends(chosen("y", FORM), chosen("u", {}))
    assert "at the input none" in caplog.text
    with pytest.raises(SystemDefinitionError, match=r"a\.y -> b\.u: 'tracking' is 2 at the source; expected 7"):
        ends(chosen("y", FORM), chosen("u", {"printed": 1, "tracking": 7}))
