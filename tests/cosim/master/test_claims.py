"""What a run says of closure, error and energy is what was measured, and what was not is named."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from cosim import Method, Result
from cosim.master.observation import LateWatch
from cosim.recording.record import Window
from cosim.report.statement import statement
from cosim.run.report import CouplingReport
from cosim.system.description import Unit, Variable
from cosim.system.structure import Connection
from tests.cosim.fakes import FakeSlave, LinearSlave, describe
from tests.cosim.master.test_energy_residual import NEWTON, SPEED
from tests.cosim.master.test_implicit import LOOP, run, system

IMPLICIT = Method("implicit")


def discretely(slave: FakeSlave, *names: str) -> FakeSlave:
    """Declare variables discrete, or all of them, as some exporters do."""
    variables = [
        replace(variable, variability="discrete") if not names or variable.name in names else variable
        for variable in slave.description.variables
    ]
    slave.description = replace(slave.description, variables=tuple(variables))
    return slave


def said(result: Result) -> str:
    """Return what the command line says of the coupling."""
    return "\n".join(statement(CouplingReport.from_record(result.record)))


def oscillator(**units: Mapping[str, Unit]) -> dict[str, FakeSlave]:
    """A mass and a spring with a damper, all of whose variables are declared discrete."""
    mass = LinearSlave([[0.0]], [[1.0]], [[1.0]], start=[1.0], units=units.get("mass"))
    spring = LinearSlave([[0.0]], [[1.0]], [[-4.0]], [[-0.2]], units=units.get("spring"))
    mass.description = replace(mass.description, feedthrough={})  # which is to say that everything feeds through
    return {"a": discretely(mass), "b": discretely(spring)}


OSCILLATOR = system("ab", "b.y0>a.u0 a.y0>b.u0")


def test_a_loop_through_discrete_values_is_said_not_to_be_closed_with_its_largest_difference() -> None:
    result = run(OSCILLATOR, oscillator(), IMPLICIT, 2.0, 0.05)
    assert result.record["loops"]
    for source, target in (("b.y0", "a.u0"), ("a.y0", "b.u0")):
        apart = np.abs(result[source] - result[target])[1:]
        found = result.record["not_iterated"][f"{source} -> {target}"]
        assert found["loop"] in result.record["loops"]
        assert found["largest_difference"] == apart.max() > 0.01
        assert found["time"] == result.time[1 + np.argmax(apart)]
        assert f"{source} and {target} differ by {apart.max():.3g} at most" in said(result)
    assert "not closed, as discrete values in it are not iterated" in said(result)
    assert "closed in every step" not in said(result)


def test_the_same_loop_of_continuous_values_is_closed_and_said_to_be() -> None:
    slaves = {
        "a": FakeSlave(lambda t, u: [t - 2.0 * u], {"u": 0.0}),
        "b": FakeSlave(lambda t, u: [u], {"u": 0.0}),
    }
    result = run(LOOP, slaves)
    assert "not_iterated" not in result.record
    assert "closed in every step, to 1e-09 of the values" in said(result)
    assert np.abs(result["a.y"] - result["b.u"]).max() < 1e-8


def test_discrete_values_in_a_loop_that_never_change_do_not_open_it() -> None:
    constant = discretely(FakeSlave(lambda t, u: [3.0], {"u": 0.0}))
    result = run(LOOP, {"a": constant, "b": FakeSlave(lambda t, u: [u], {"u": 0.0})})
    assert [each["largest_difference"] for each in result.record["not_iterated"].values()] == [0.0, 0.0]
    assert "discrete ones in it, which are not iterated, agreed at the end of every step" in said(result)


def test_a_discrete_value_outside_of_loops_is_said_to_be_a_step_late() -> None:
    flag = Variable("flag", 7, "Boolean", "output", "discrete")
    on = Variable("on", 8, "Boolean", "input", "discrete", start="false")
    slaves = {
        "a": FakeSlave(lambda t: [t, t > 0.3], description=describe((), ("y",), extra=(flag,))),
        "b": FakeSlave(lambda t, on: [t], description=describe({}, ("y",), extra=(on,))),
    }
    result = run(system("ab", "a.flag>b.on"), slaves)
    assert result.record["not_iterated"] == {"a.flag -> b.on": {"loop": None, "largest_difference": 1.0, "time": 0.375}}
    assert "a step late: at the end of a step a.flag and b.on differ by 1 at most (t = 0.375 s)" in said(result)
    assert "not_iterated" not in run(system("ab", "a.flag>b.on"), slaves, Method("jacobi")).record


def test_the_account_of_what_is_late_goes_on_from_where_it_was() -> None:
    slaves = oscillator()
    descriptions = {name: slave.description for name, slave in slaves.items()}
    connections = [Connection("a.y0", "b.u0"), Connection("b.y0", "a.u0")]
    run(OSCILLATOR, slaves, IMPLICIT, 1.0, 0.125)
    blocks = {name: slave.block for name, slave in slaves.items()}
    watch, after = (LateWatch(connections, (), descriptions) for _ in range(2))
    watch.take(Window(0, np.arange(4.0), blocks, {}))
    assert watch.summary()["a.y0 -> b.u0"]["largest_difference"] > 0.0
    after.restore(watch.summary())
    assert after.summary() == watch.summary()


@pytest.mark.parametrize("algorithm", ["jacobi", "implicit"])
def test_an_error_of_nothing_but_discrete_values_is_unknown_and_not_0(algorithm: str) -> None:
    result = run(OSCILLATOR, oscillator(), Method(algorithm, tolerance=1e-6), 1.0, 0.125)
    estimate = result.record["error_estimate"]
    assert (estimate["largest"], estimate["mean"]) == (None, None)
    assert sorted(estimate["not_estimated"]["discrete"]) == ["a.y0", "b.y0"]
    assert "coupling.error_estimate" not in result
    assert "error of the coupling unknown" in said(result)
    assert "estimated error" not in said(result)
    for name in ("a.y0", "b.y0"):
        assert name in said(result).splitlines()[-1]


def test_what_an_estimate_leaves_out_is_named_beside_it() -> None:
    slaves = {
        "s": FakeSlave(lambda t: [np.sin(3.0 * t), round(t)], outputs=("y", "n")),
        "a": FakeSlave(lambda t, u, n: [u + n], {"u": 0.0, "n": 0.0}),
        "z": FakeSlave(lambda t, u: [u], description=describe({"u": 0.0}, ("y",), can_save_state=False)),
    }
    discretely(slaves["s"], "n")
    result = run(system("saz", "s.y>a.u s.n>a.n a.y>z.u"), slaves, Method(tolerance=1e-2))
    estimate = result.record["error_estimate"]
    assert estimate["largest"] > 0.0
    assert estimate["not_estimated"] == {"discrete": ["s.n"], "components": ["a", "z"]}
    assert "error not estimated of s.n (discrete), nor of a, z (passes on nothing that is compared)" in said(result)


def test_an_estimate_that_covers_all_names_nothing() -> None:
    slaves = {
        "a": FakeSlave(lambda t, u: [t - 0.5 * u], {"u": 0.0}),
        "b": FakeSlave(lambda t, u: [u], {"u": 0.0}),
    }
    result = run(LOOP, slaves, Method(tolerance=1e-2))
    assert result.record["error_estimate"]["not_estimated"] == {"discrete": [], "components": []}
    assert "not estimated" not in said(result)


def test_energy_of_a_bond_with_discrete_values_is_told_with_what_it_assumes() -> None:
    units = {"mass": {"u0": NEWTON, "y0": SPEED}, "spring": {"u0": SPEED, "y0": NEWTON}}
    result = run(OSCILLATOR, oscillator(**units), Method("jacobi"), 1.0, 0.01)
    (account,) = result.record["energy_residual"].values()
    assert sorted(account["discrete"]) == ["a.u0", "a.y0", "b.u0", "b.y0"]
    assert "went on straight lines, not in steps" in said(result)
    smooth = {name: continuously(slave) for name, slave in oscillator(**units).items()}
    (account,) = run(OSCILLATOR, smooth, Method("jacobi"), 1.0, 0.01).record["energy_residual"].values()
    assert "discrete" not in account


def continuously(slave: FakeSlave) -> FakeSlave:
    """Declare all variables continuous."""
    variables = tuple(replace(variable, variability="continuous") for variable in slave.description.variables)
    slave.description = replace(slave.description, variables=variables)
    return slave
