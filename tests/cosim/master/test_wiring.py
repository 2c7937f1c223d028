"""The wiring of components whose variables have awkward references."""

from __future__ import annotations

import numpy as np
import pytest

from cosim import Component, Connection, Method, Step, System, co_simulate, ramp
from cosim.system import method as method_module
from cosim.system.description import Variable
from tests.cosim.fakes import FakeSlave, describe


@pytest.mark.parametrize("method", [Method(), Method("implicit"), Method(tolerance=1e-3)], ids=str)
def test_slopes_of_a_real_input_are_not_taken_for_those_of_an_integer_with_its_reference(method: Method) -> None:
    mode = Variable("mode", 0, "Integer", "input", "discrete", start="0")
    description = describe({"u": 0.0}, ("y",), can_interpolate_inputs=True, extra=(mode,))
    assert description.by_name["u"].reference == mode.reference
    slave = FakeSlave(lambda t, u, *rest: [u], description=description)
    inputs = {"one.u": ramp(0.0, 1.0, 0.0, 1.0), "one.mode": Step(0, 3, 0.5)}
    system = System((Component("one", "one.fmu"),), inputs=inputs)
    result = co_simulate(system, {"one": slave}, stop_time=1.0, step_size=0.25, method=method)
    assert result["one.mode"].tolist() == [3 if time > 0.5 else 0 for time in result.time.tolist()]
    assert result["one.u"] == pytest.approx(result.time, abs=1e-12)
    assert result["one.y"] == pytest.approx(result.time, abs=1e-12)
    assert np.unique(slave.slopes).tolist() == [1.0]


@pytest.mark.parametrize("tolerance", [None, 0.5])
def test_an_explicit_algorithm_is_added_in_one_place(monkeypatch: pytest.MonkeyPatch, tolerance: float | None) -> None:
    """One that passes on everything at once, as far as the given order allows, where Jacobi is a step behind."""
    monkeypatch.setattr(method_module, "EXPLICIT", {**method_module.EXPLICIT, "hasty": lambda source, target: 0})
    monkeypatch.setattr(method_module, "ALGORITHMS", (*method_module.ALGORITHMS, "hasty"))
    system = System((Component("clock", "c.fmu"), Component("one", "o.fmu")), (Connection("clock.y", "one.u"),))
    slaves = {"clock": FakeSlave(lambda t: [t]), "one": FakeSlave(lambda t, u: [u], {"u": 0.0})}
    method = Method("hasty", tolerance=tolerance)
    result = co_simulate(system, slaves, stop_time=1.0, step_size=0.25, method=method)
    assert result["one.y"].tolist() == result["clock.y"].tolist() == result.time.tolist()
