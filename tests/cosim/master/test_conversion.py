"""Values that connections convert: units, factors and offsets, tables; alike in every algorithm, loop and process."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim import (
    Component,
    Connection,
    Constant,
    Method,
    Scenario,
    Step,
    System,
    co_simulate,
    load_scenario,
    ramp,
    simulate,
)
from cosim.errors import InputError, ScenarioError, SystemDefinitionError
from cosim.scenario.container import container_files
from cosim.system.conversion import Conversion, conversion_of, unit_conversion
from cosim.system.description import Unit
from tests.cosim.fakes import FakeSlave, LinearSlave, describe

pytestmark = pytest.mark.usefixtures("no_leftovers")

Maker = Callable[..., Path]
RPM = 30.0 / math.pi
ALGORITHMS: list[dict[str, Any]] = [
    {}, {"algorithm": "gauss-seidel"}, {"algorithm": "implicit"}, {"tolerance": 1e-3},
    {"algorithm": "implicit", "tolerance": 1e-3}, {"isolate": True},
]  # fmt: skip
CHOOSING = {
    'causality="input" variability="discrete"><Integer start="0"/>':
        'causality="input" variability="discrete"><Enumeration declaredType="Mode" start="1"/>',
    'causality="output" variability="discrete"><Integer/>':
        'causality="output" variability="discrete"><Enumeration declaredType="Mode"/>',
}  # fmt: skip


def chain(fmu: Path, *connections: Connection, **inputs: Any) -> Scenario:
    """Two probes of which the first drives the second."""
    driven = {connection.target for connection in connections}
    signals = {"a.u": Constant(3.0), "b.u": Constant(0.0), "b.v": Constant(0.0), "a.v": Constant(0.0)}
    signals |= {f"a.{name}": signal for name, signal in inputs.items()}
    kept = {name: signal for name, signal in signals.items() if name not in driven}
    return Scenario("chain", System((Component("a", fmu), Component("b", fmu)), connections, kept), 1.0, 0.25)


@pytest.mark.parametrize("options", ALGORITHMS)
@pytest.mark.parametrize(
    ("connection", "expected"),
    [
        (Connection("a.u_seen", "b.v"), 3.0 * RPM),
        (Connection("a.u_seen", "b.v", unconverted=True), 3.0),
        (Connection("a.u_seen", "b.u", factor=-2.5, offset=1.0), -6.5),
        (Connection("a.u_seen", "b.v", factor=2.0, offset=10.0), 6.0 * RPM + 10.0),
        (Connection("a.u_seen", "b.v", factor=2.0, offset=10.0, unconverted=True), 16.0),
    ],
)
def test_numbers_arrive_in_the_unit_of_the_input_times_factor_plus_offset(
    probe: Path, options: dict[str, Any], connection: Connection, expected: float
) -> None:
    result = simulate(chain(probe, connection), **options)
    assert result[connection.target][-1] == pytest.approx(expected, rel=1e-14)
    assert result["a.u_seen"][-1] == 3.0


@pytest.mark.parametrize("options", ALGORITHMS)
@pytest.mark.parametrize(
    ("connection", "inputs", "replaced", "expected"),
    [
        (Connection("a.not_flag", "b.flag", table={True: False}), {"flag": Constant(False)}, {}, False),
        (Connection("a.not_flag", "b.flag", table={True: False, False: True}), {"flag": Constant(True)}, {}, True),
        (Connection("a.n_next", "b.n", table={4: 40, 8: -1}), {"n": Constant(3)}, {}, 40),
        (Connection("a.n_next", "b.n", table={4: 40, 8: -1}), {"n": Constant(5)}, {}, 6),
        (Connection("a.n_next", "b.n", table={"slow": "fast"}), {"n": Constant("slow")}, CHOOSING, 2),
        (Connection("a.n_next", "b.n", table={5: "slow", "nowhere": "fast"}), {"n": Constant("slow")}, CHOOSING, 2),
    ],
)
def test_a_table_gives_what_it_lists_and_leaves_the_rest(
    make_probe: Maker,
    options: dict[str, Any],
    connection: Connection,
    inputs: dict[str, Any],
    replaced: dict[str, str],
    expected: bool | int,
) -> None:
    result = simulate(chain(make_probe(replace=replaced), connection, **inputs), **options)
    assert result[connection.target][-1] == expected


def test_items_are_converted_by_name(make_probe: Maker) -> None:
    """The probe adds its mode, 1, to what it is given: 4 becomes 5, which is fast."""
    fmu = make_probe(replace={**CHOOSING, '<Item name="slow" value="1"/>': '<Item name="slow" value="4"/>'})
    connection = Connection("a.n_next", "b.n", table={"fast": "slow"})
    scenario = chain(fmu, connection, n=Constant("slow"))
    system = scenario.system.with_values({"a.mode": "slow", "b.mode": "slow"})
    result = simulate(replace(scenario, system=system.with_values({"a.mode": 4})))
    assert (result["a.n_next"][-1], result["b.n"][-1]) == (8, 8)
    scenario = chain(fmu, Connection("a.n_next", "b.n", table={"fast": "slow"}), n=Constant("slow"))
    result = simulate(scenario)  # without a value the mode of the probe is 1
    assert (result["a.n_next"][-1], result["b.n"][-1]) == (5, 4)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_both_loops_convert_to_the_same_bits(probe: Path, algorithm: str) -> None:
    connections = (
        Connection("a.u_seen", "b.v", factor=1.0 / 3.0, offset=0.1),
        Connection("a.integral", "b.u", factor=0.7, unconverted=True),
        Connection("a.n_next", "b.n", table={4: 9}),
        Connection("a.not_flag", "b.flag", table={True: False}),
    )
    scenario = chain(probe, *connections, u=ramp(0.0, 3.0, 0.2, 0.5), n=Step(3, 5, 0.5), flag=Step(True, False, 0.5))
    scenario = replace(scenario, step_size=0.01)
    loops = [simulate(replace(scenario, method=Method(algorithm, compiled=compiled))) for compiled in (True, False)]
    assert [result.record["step_loop"] for result in loops] == ["compiled", "python"]
    for name, values in loops[0].columns.items():
        assert values.tobytes() == loops[1].columns[name].tobytes(), name
    assert {9, 6} <= set(loops[0]["b.n"].tolist())
    late = 1 if algorithm == "jacobi" else 0
    given = loops[0]["a.integral"][: -late or None]
    assert loops[0]["b.u"][late:].tolist() == (0.7 * given + 0.0).tolist()


CONVERTED = System(
    (Component("mass", "m.fmu"), Component("spring", "s.fmu")),
    (Connection("spring.y0", "mass.u0", factor=3.0), Connection("mass.y0", "spring.u0", factor=2.0, offset=0.5)),
)
WITH_GAINS = System(
    (*CONVERTED.components, Component("up", "g.fmu"), Component("down", "g.fmu")),
    (
        Connection("spring.y0", "up.u"),
        Connection("up.y", "mass.u0"),
        Connection("mass.y0", "down.u"),
        Connection("down.y", "spring.u0"),
    ),
)


def parts(**options: Any) -> dict[str, FakeSlave]:
    """An oscillator of a mass and a spring, and the gains that do what the connections do."""
    gain = describe({"u": 0.0}, ("y",), can_interpolate_inputs=True)
    return {
        "mass": LinearSlave([[0.0]], [[0.5]], [[1.0]], start=[1.0], **options),
        "spring": LinearSlave([[0.0]], [[1.0]], [[-4.0]], **options),
        "up": FakeSlave(lambda t, u: [3.0 * u], description=gain),
        "down": FakeSlave(lambda t, u: [2.0 * u + 0.5], description=gain),
    }


def only(system: System, slaves: Mapping[str, FakeSlave]) -> dict[str, FakeSlave]:
    return {part.name: slaves[part.name] for part in system.components}


# held inputs are of first order: their steps shrink with the tolerance itself, and a small one takes long
@pytest.mark.parametrize(("tolerance", "interpolates"), [(None, False), (None, True), (1e-2, False), (1e-4, True)])
@pytest.mark.slow
def test_a_loop_is_closed_through_a_factor_as_through_a_gain(tolerance: float | None, interpolates: bool) -> None:
    method = Method("implicit", tolerance=tolerance, iteration_tolerance=1e-12)
    size = {"stop_time": 2.0, "step_size": 0.02, "method": method}
    converted, with_gains = (
        co_simulate(system, only(system, parts(can_interpolate_inputs=interpolates)), **size)
        for system in (CONVERTED, WITH_GAINS)
    )
    if tolerance is None:
        for name in ("mass.y0", "spring.y0", "mass.u0", "spring.u0"):
            assert converted[name] == pytest.approx(with_gains[name], abs=1e-9), name
    # m x'' = -3 k (2 x + t / 2) with m = 2, k = 4 from x' = 1: an oscillation about a slope of -1/4.
    omega = math.sqrt(12.0)
    exact = -0.25 + 1.25 * np.cos(omega * converted.time)
    worst = np.abs(converted["mass.y0"] - exact).max()
    # held inputs damp it, by exp(-omega^2 h t / 2): 0.27 of 1.25 after 2 s of 20 ms
    assert worst < (0.27 if not interpolates else 3e-3)


def test_gauss_seidel_passes_a_factor_on_as_a_gain_in_between_does() -> None:
    method = Method("gauss-seidel", order=("mass", "spring"))
    longer = Method("gauss-seidel", order=("mass", "down", "spring", "up"))
    size = {"stop_time": 1.0, "step_size": 0.125}
    converted = co_simulate(CONVERTED, only(CONVERTED, parts()), method=method, **size)
    # the gain behind the spring is stepped after it, so that the mass gets as old a value either way
    with_gains = co_simulate(WITH_GAINS, only(WITH_GAINS, parts()), method=longer, **size)
    for name in ("mass.y0", "spring.y0", "mass.u0", "spring.u0"):
        assert converted[name].tolist() == with_gains[name].tolist(), name


def test_what_an_output_promises_by_its_derivative_is_converted_too() -> None:
    source = FakeSlave(lambda t: [t * t], description=describe({}, ("y",), output_derivative_order=1))
    sink = FakeSlave(lambda t, u: [u], description=describe({"u": 0.0}, ("y",), can_interpolate_inputs=True))
    system = System(
        (Component("a", "a.fmu"), Component("b", "b.fmu")), (Connection("a.y", "b.u", factor=-3.0, offset=7.0),)
    )
    slaves = {"a": source, "b": sink}
    result = co_simulate(system, slaves, stop_time=1.0, step_size=0.25, method=Method("implicit", tolerance=0.9))
    # where a step began at t, the input went along -3 (t^2 + 2 t dt) + 7, and is recorded as it was at the end
    sizes, begins = np.diff(result.time), result.time[:-1]
    assert result["b.u"][1:] == pytest.approx(7.0 - 3.0 * (begins**2 + 2.0 * begins * sizes), abs=1e-5)
    assert set(np.round(sink.slopes, 4)) >= set(np.round(-6.0 * begins, 4))


def test_the_error_of_a_step_is_that_of_the_converted_value() -> None:
    """A usual size of 1 at the source is one of 1e-6 at an input that gets a millionth, so the same steps suffice."""
    steps = []
    for factor in (1.0, 1e-6):
        nominal = describe({"u": 0.0}, ("y",), can_interpolate_inputs=True)
        variables = tuple(replace(v, nominal=factor if v.name == "u" else 1.0) for v in nominal.variables)
        sink = FakeSlave(lambda t, u: [u], description=replace(nominal, variables=variables))
        source = FakeSlave(lambda t: [math.sin(5.0 * t)], outputs=("y",))
        system = System((Component("a", "a.fmu"), Component("b", "b.fmu")), (Connection("a.y", "b.u", factor=factor),))
        method = Method(tolerance=1e-2)
        result = co_simulate(system, {"a": source, "b": sink}, stop_time=1.0, step_size=0.25, method=method)
        steps.append(result.time.tolist())
        assert result.record["error_estimate"]["largest"] <= 1e-2
    assert steps[0] == steps[1]
    assert len(steps[0]) > 20


NEWTON = Unit("N", (1, 1, -2, 0, 0, 0, 0, 0))
KILO = replace(NEWTON, name="kN", factor=1000.0)
SPEED = Unit("m/s", (0, 1, -1, 0, 0, 0, 0, 0))
PER_MINUTE = replace(SPEED, name="m/min", factor=1.0 / 60.0)
MASS, STIFFNESS = 2.0, 30.0


def oscillator(force: Unit, speed: Unit, **options: Any) -> dict[str, FakeSlave]:
    """A mass in N and m/s, and a spring in other units."""
    scale = speed.factor / force.factor
    mass = LinearSlave([[0.0]], [[1.0 / MASS]], [[1.0]], start=[1.0], units={"u0": NEWTON, "y0": SPEED}, **options)
    spring = LinearSlave([[0.0]], [[1.0]], [[-STIFFNESS * scale]], units={"u0": speed, "y0": force}, **options)
    return {"mass": mass, "spring": spring}


def coupled(**factors: float) -> System:
    connections = (
        Connection("spring.y0", "mass.u0", factor=factors.get("force", 1.0)),
        Connection("mass.y0", "spring.u0", factor=factors.get("speed", 1.0)),
    )
    return System((Component("mass", "m.fmu"), Component("spring", "s.fmu")), connections)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_an_account_of_energy_counts_power_on_both_sides_of_a_unit(algorithm: str) -> None:
    size = {"stop_time": 1.0, "step_size": 0.01, "method": Method(algorithm)}
    plain = co_simulate(coupled(), oscillator(NEWTON, SPEED), **size)
    scaled = co_simulate(coupled(), oscillator(KILO, PER_MINUTE), **size)
    assert scaled["mass.y0"] == pytest.approx(plain["mass.y0"], abs=1e-12)
    ours, theirs = (result.record["energy_residual"]["mass.u0"] for result in (scaled, plain))
    assert ours["sum"] == pytest.approx(theirs["sum"], rel=1e-9)
    assert ours["exchanged"] == pytest.approx(theirs["exchanged"], rel=1e-9)
    assert scaled.record["conversions"]["spring.y0 -> mass.u0"] == {"factor": 1000.0, "offset": 0.0}
    assert "conversions" not in plain.record


def test_a_gear_makes_no_energy_and_half_a_gear_makes_what_both_sides_lack() -> None:
    """With speed and force both times 2 a mass feels four times the stiffness; with the speed alone, work is made."""
    size = {"stop_time": 1.0, "step_size": 0.002, "method": Method("implicit")}
    made = []
    for factors in ({"speed": 2.0, "force": 2.0}, {"speed": 2.0}):
        result = co_simulate(coupled(**factors), oscillator(NEWTON, SPEED, can_interpolate_inputs=True), **size)
        kinetic = 0.5 * MASS * result["mass.y0"] ** 2
        stored = result["spring.y0"] ** 2 / (2.0 * STIFFNESS)
        gained = (kinetic + stored)[-1] - (kinetic + stored)[0]
        account = result.record["energy_residual"]["mass.u0"]
        assert account["sum"] == pytest.approx(gained, abs=0.01 * account["exchanged"])
        made.append(account["absolute"] / account["exchanged"])
    assert made[0] < 0.01 < 0.4 < made[1]


def test_ends_that_are_not_iterated_are_compared_as_they_are_converted(probe: Path) -> None:
    scenario = chain(probe, Connection("a.n_next", "b.n", table={4: 40}), n=Constant(3))
    late = simulate(scenario, algorithm="implicit").record["not_iterated"]["a.n_next -> b.n"]
    assert late["largest_difference"] in (0.0, 40.0)
    assert late["time"] in (None, 0.25)


TOML = """
stop_time = 1.0
step_size = 0.25
connections = [
    {{ from = "a.u_seen", to = "b.v", {first} }},
    {{ from = "a.n_next", to = "b.n", {second} }},
]
[components.a]
fmu = "probe.fmu"
[components.b]
fmu = "probe.fmu"
[inputs]
a.u = 3.0
a.n = 3
"""


def test_a_scenario_file_says_what_becomes_of_values(probe: Path) -> None:
    path = probe.with_name("converted.toml")
    path.write_text(TOML.format(first="factor = 2, offset = 10.0", second="table = { 4 = 40 }"), encoding="utf-8")
    result = simulate(load_scenario(path))
    assert result["b.v"][-1] == pytest.approx(6.0 * RPM + 10.0)
    assert result["b.n"][-1] == 40
    path.write_text(TOML.format(first="unconverted = true", second="table = {}"), encoding="utf-8")
    assert simulate(load_scenario(path))["b.v"][-1] == 3.0


@pytest.mark.parametrize(
    ("first", "second", "said"),
    [
        ('factor = "two"', "offset = 0", r"connections\.factor is 'two'; expected a number"),
        ("factor = inf", "offset = 0", r"a\.u_seen -> b\.v: factor is inf; expected a finite number"),
        ("table = { 1 = 2.5 }", "offset = 0", r"connections\.table\.1 is 2\.5; expected true, false, a whole number"),
        ("table = { 1 = 2 }, factor = 3", "offset = 0", r"a\.u_seen -> b\.v has a table, and a factor or offset"),
    ],
)
def test_what_makes_no_sense_in_a_file_is_named(probe: Path, first: str, second: str, said: str) -> None:
    path = probe.with_name("converted.toml")
    path.write_text(TOML.format(first=first, second=second), encoding="utf-8")
    with pytest.raises((ScenarioError, SystemDefinitionError), match=said):
        load_scenario(path)


@pytest.mark.parametrize(
    ("connection", "said"),
    [
        (
            Connection("a.u_seen", "b.u", table={1: 2}),
            r"a table is for Boolean, Integer or Enumeration; a\.u_seen is R",
        ),
        (Connection("a.n_next", "b.n", factor=2.0), r"factor and offset are for Real; a\.n_next is Integer, b\.n Int"),
        (Connection("a.not_flag", "b.flag", table={True: 2}), r"the table leads to 2; expected Boolean"),
        (Connection("a.integral", "b.u"), r"the source is in rad .*; expected rad/s"),
    ],
)
def test_what_does_not_fit_the_types_is_refused_before_the_run(probe: Path, connection: Connection, said: str) -> None:
    with pytest.raises(SystemDefinitionError, match=said):
        simulate(chain(probe, connection))


def test_a_container_passes_no_converted_values_on(probe: Path) -> None:
    scenario = chain(probe, Connection("a.u_seen", "b.v"))
    with pytest.raises(InputError, match=r"a container passes values on as they are; connection a\.u_seen -> b\.v"):
        container_files(scenario, "container", "native")


def test_a_difference_is_not_given_to_what_is_none() -> None:
    celsius = Unit("degC", (0, 0, 0, 0, 1, 0, 0, 0), offset=273.15)
    source, sink = describe({}, ("y",), units={"y": celsius}), describe({"u": 0.0}, ("z",), units={"u": celsius})
    difference = replace(source, variables=tuple(replace(variable, relative=True) for variable in source.variables))
    slaves = {
        "a": FakeSlave(lambda t: [5.0], description=difference),
        "b": FakeSlave(lambda t, u: [u], description=sink),
    }
    system = System((Component("a", "a.fmu"), Component("b", "b.fmu")), (Connection("a.y", "b.u"),))
    with pytest.raises(SystemDefinitionError, match=r"in degC \(= K\); expected degC \(= K \+ 273\.15\)"):
        co_simulate(system, slaves, stop_time=1.0, step_size=0.5)


def test_units_with_an_offset_convert_as_their_definitions_say() -> None:
    kelvin = Unit("K", (0, 0, 0, 0, 1, 0, 0, 0))
    celsius = replace(kelvin, name="degC", offset=273.15)
    fahrenheit = replace(kelvin, name="degF", factor=5.0 / 9.0, offset=459.67 * 5.0 / 9.0)
    assert Conversion(*unit_conversion(celsius, fahrenheit)).of(100.0) == pytest.approx(212.0, abs=1e-12)
    assert Conversion(*unit_conversion(fahrenheit, kelvin)).of(32.0) == pytest.approx(273.15, abs=1e-12)
    assert unit_conversion(kelvin, kelvin) == unit_conversion(None, kelvin) == (1.0, 0.0)
    descriptions = {
        "a": describe({}, ("y",), units={"y": celsius}), "b": describe({"u": 0.0}, (), units={"u": celsius})
    }  # fmt: skip
    assert conversion_of(Connection("a.y", "b.u"), descriptions) is None


@pytest.mark.parametrize("options", ALGORITHMS)
def test_an_integer_drives_an_enumeration_with_a_warning(
    make_probe: Maker, caplog: pytest.LogCaptureFixture, options: dict[str, Any]
) -> None:
    """As in systems of other tools, which count modes in one FMU and name them in another."""
    old = 'causality="input" variability="discrete"><Integer start="0"/>'
    fmu = make_probe(replace={old: CHOOSING[old]})
    scenario = chain(fmu, Connection("a.n_next", "b.n"), n=Constant("slow"))
    with caplog.at_level("WARNING", "cosim"):
        result = simulate(scenario, **options)
    assert (result["a.n_next"][-1], result["b.n"][-1]) == (2, 2)
    assert "connection a.n_next -> b.n: Integer is given to Enumeration; numbers are passed on" in caplog.text
