"""No value reaches a component that is neither its start value, the user's nor a source's."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from cosim import Component, Connection, Constant, Method, System, co_simulate
from tests.cosim.fakes import FakeSlave

ALGORITHMS = [Method("jacobi"), Method("gauss-seidel"), Method("implicit"), Method("jacobi", tolerance=0.1)]
ORDERS = [("source", "sink"), ("sink", "source")]


class Wary(FakeSlave):
    """Keeps whatever its inputs are set to."""

    def write(self, row: int) -> None:
        super().write(row)
        self.given = {*getattr(self, "given", set[float]()), *self.values.values()}


def system(order: Sequence[str], connections: Sequence[tuple[str, str]], **inputs: float) -> System:
    signals = {name.replace("_", "."): Constant(value) for name, value in inputs.items()}
    parts = tuple(Component(name, "fake") for name in order)
    return System(parts, tuple(Connection(*ends) for ends in connections), signals)


@pytest.mark.parametrize("method", ALGORITHMS, ids=str)
@pytest.mark.parametrize("order", ORDERS)
def test_a_sink_sees_its_start_value_and_those_of_its_source_alone(order: tuple[str, ...], method: Method) -> None:
    source = Wary(lambda t: [5.0 + t], name="source")
    sink = Wary(lambda t, u: [1.0 / u], {"u": 7.0}, name="sink")
    slaves = {name: {"source": source, "sink": sink}[name] for name in order}
    result = co_simulate(system(order, [("source.y", "sink.u")]), slaves, stop_time=1.0, step_size=0.5, method=method)
    assert all(value == 7.0 or 5.0 <= value <= 6.0 for value in sink.given)
    assert result["sink.y"][0] == 1.0 / 5.0


@pytest.mark.parametrize("method", ALGORITHMS, ids=str)
@pytest.mark.parametrize("order", ORDERS)
def test_components_of_a_loop_begin_with_their_start_values(order: tuple[str, ...], method: Method) -> None:
    """x = 8 / y and y = (x + 2) / 2, from y = 4: x = 2, y = 2, x = 4, ... never 8 / 0; the solution is x = 3.123."""
    source = Wary(lambda t, u: [8.0 / u], {"u": 4.0}, name="source")
    sink = Wary(lambda t, u: [(u + 2.0) / 2.0], {"u": 4.0}, name="sink")
    slaves = {name: {"source": source, "sink": sink}[name] for name in order}
    loop = system(order, [("source.y", "sink.u"), ("sink.y", "source.u")])
    result = co_simulate(loop, slaves, stop_time=1.0, step_size=0.5, method=method)
    assert result["source.y"][0] == pytest.approx(17.0**0.5 - 1.0, rel=1e-6)
    assert 0.0 not in source.given | sink.given


@pytest.mark.parametrize("method", ALGORITHMS, ids=str)
def test_a_signal_of_the_user_is_there_before_the_first_output_is_read(method: Method) -> None:
    sink = Wary(lambda t, u: [1.0 / u], {"u": 7.0}, name="sink")
    result = co_simulate(system(("sink",), (), sink_u=4.0), {"sink": sink}, stop_time=1.0, step_size=0.5, method=method)
    assert set(result["sink.y"]) == {0.25}
    assert sink.given <= {7.0, 4.0}
