"""Laws of the master, on slaves that are lambdas."""

from __future__ import annotations

import numpy as np
import pytest

from cosim import Component, Connection, Constant, InputError, Method, SlaveError, Step, System, co_simulate, ramp
from cosim.system.description import Variable
from tests.cosim.fakes import FakeSlave, describe


def system(*names: str, connections: tuple[Connection, ...] = (), inputs=None, **parameters) -> System:
    components = tuple(Component(name, f"{name}.fmu", parameters.get(name, {})) for name in names)
    return System(components, connections, inputs or {})


def clock() -> FakeSlave:
    """Puts out the time."""
    return FakeSlave(lambda t: [t])


def delay_line() -> FakeSlave:
    """Puts out its input."""
    return FakeSlave(lambda t, u: [u], {"u": 0.0})


CHAIN = (Connection("clock.y", "follower.u"),)


def test_row_zero_is_the_start_and_every_other_row_is_labelled_by_the_end_of_its_step() -> None:
    result = co_simulate(system("clock"), {"clock": clock()}, stop_time=1.0, step_size=0.1)
    assert result.time.tolist() == [k * 0.1 for k in range(11)]
    assert result["clock.y"] == pytest.approx(result.time, abs=1e-15)


def test_steps_begin_at_exact_communication_points() -> None:
    slave = clock()
    co_simulate(system("clock"), {"clock": slave}, start_time=3.0, stop_time=4.0, step_size=0.1)
    assert slave.steps == [(3.0 + k * 0.1, 0.1) for k in range(10)]


def test_jacobi_passes_values_from_the_beginning_of_the_step() -> None:
    slaves = {"clock": clock(), "follower": delay_line()}
    result = co_simulate(system("clock", "follower", connections=CHAIN), slaves, stop_time=1.0, step_size=0.125)
    assert result["follower.y"][1:].tolist() == result["clock.y"][:-1].tolist()
    assert result["follower.u"].tolist() == result["follower.y"].tolist()


def test_gauss_seidel_passes_values_from_the_end_of_the_step_to_later_components() -> None:
    slaves = {"clock": clock(), "follower": delay_line()}
    coupled = system("clock", "follower", connections=CHAIN)
    result = co_simulate(coupled, slaves, stop_time=1.0, step_size=0.125, method=Method("gauss-seidel"))
    assert result["follower.y"].tolist() == result["clock.y"].tolist()


def test_gauss_seidel_passes_values_from_the_beginning_to_earlier_components_of_a_given_order() -> None:
    slaves = {"clock": clock(), "follower": delay_line()}
    coupled = system("clock", "follower", connections=CHAIN)
    method = Method("gauss-seidel", order=("follower", "clock"))
    result = co_simulate(coupled, slaves, stop_time=1.0, step_size=0.125, method=method)
    assert result["follower.y"][1:].tolist() == result["clock.y"][:-1].tolist()
    assert result.record["order"] == ["follower", "clock"]
    assert result.names == ("clock.y", "follower.y", "follower.u")


def test_gauss_seidel_steps_by_default_what_is_depended_on_first() -> None:
    slaves = {"follower": delay_line(), "clock": clock()}
    coupled = system("follower", "clock", connections=CHAIN)
    result = co_simulate(coupled, slaves, stop_time=1.0, step_size=0.125, method=Method("gauss-seidel"))
    assert result["follower.y"].tolist() == result["clock.y"].tolist()


def test_an_order_that_leaves_out_or_invents_a_component_is_refused() -> None:
    slaves = {"clock": clock(), "follower": delay_line()}
    coupled = system("clock", "follower", connections=CHAIN)
    for order, message in [
        (("clock",), "order is clock; expected each of clock, follower once"),
        (("clock", "folower"), "order: there is no component 'folower'; did you mean 'follower'"),
    ]:
        with pytest.raises(InputError, match=message):
            co_simulate(coupled, slaves, stop_time=1.0, step_size=0.5, method=Method("gauss-seidel", order))


def test_jacobi_does_not_depend_on_the_order_of_components() -> None:
    connections = (Connection("a.y", "b.u"), Connection("b.y", "a.u"))
    runs = []
    for order in (("a", "b"), ("b", "a")):
        slaves = {
            "a": FakeSlave(lambda t, u: [np.cos(t) - 0.5 * u], {"u": 0.0}),
            "b": FakeSlave(lambda t, u: [u * u - t], {"u": 0.0}),
        }
        runs.append(co_simulate(system(*order, connections=connections), slaves, stop_time=1.0, step_size=0.1))
    for name in ("a.y", "b.y", "a.u", "b.u"):
        assert runs[0][name][-1] == pytest.approx(runs[1][name][-1], rel=1e-12)


def test_no_output_is_read_between_setting_and_stepping() -> None:
    journal: list[tuple[str, str]] = []
    slaves = {name: FakeSlave(lambda t, u: [u], {"u": 0.0}, journal=journal, name=name) for name in ("first", "second")}
    connections = (Connection("first.y", "second.u"), Connection("second.y", "first.u"))
    for algorithm in ("jacobi", "gauss-seidel"):
        journal.clear()
        coupled = system("first", "second", connections=connections)
        co_simulate(coupled, slaves, stop_time=1.0, step_size=0.25, method=Method(algorithm))
        for name in slaves:
            calls = [call for slave, call in journal if slave == name]
            stepping = calls[calls.index("exit") + 1 :]
            assert stepping == ["read"] + ["write", "step", "read"] * 4 + ["terminate"]


def test_values_settle_before_the_first_step() -> None:
    loop = (Connection("a.y", "b.u"), Connection("b.y", "a.u"))
    slaves = {
        "a": FakeSlave(lambda t, u: [0.5 * u + 1.0], {"u": 0.0}),
        "b": FakeSlave(lambda t, u: [0.5 * u], {"u": 0.0}),
    }
    result = co_simulate(system("a", "b", connections=loop), slaves, stop_time=1.0, step_size=0.5)
    assert result["a.y"][0] == pytest.approx(4.0 / 3.0, rel=1e-15)
    assert result["b.u"][0] == result["a.y"][0]
    assert result["a.u"][0] == result["b.y"][0]
    assert result.record["initialisation"]["settled"] is True


def test_values_pass_through_a_chain_listed_backwards() -> None:
    chain = (Connection("c.y", "b.u"), Connection("b.y", "a.u"))
    slaves = {"a": delay_line(), "b": delay_line(), "c": FakeSlave(lambda t: [7.0])}
    result = co_simulate(system("a", "b", "c", connections=chain), slaves, stop_time=1.0, step_size=1.0)
    assert result["a.y"][0] == 7.0


def test_a_loop_that_does_not_settle_is_named_and_the_run_goes_on(caplog: pytest.LogCaptureFixture) -> None:
    loop = (Connection("a.y", "b.u"), Connection("b.y", "a.u"))
    slaves = {"a": FakeSlave(lambda t, u: [1.0 - u], {"u": 0.0}), "b": delay_line()}
    result = co_simulate(system("a", "b", connections=loop), slaves, stop_time=1.0, step_size=0.5)
    assert result.record["initialisation"]["settled"] is False
    assert "values at the start do not settle: b.u still changes" in caplog.text
    assert result.time.size == 3


def test_a_loop_of_gain_099_settles() -> None:
    loop = (Connection("a.y", "a.u"),)
    slaves = {"a": FakeSlave(lambda t, u: [0.99 * u + 1.0], {"u": 0.0})}
    result = co_simulate(system("a", connections=loop), slaves, stop_time=1.0, step_size=1.0)
    assert result.record["initialisation"]["settled"] is True
    assert result["a.y"][0] == pytest.approx(100.0, rel=1e-9)


def test_an_input_signal_is_held_from_the_beginning_of_each_step() -> None:
    slave = delay_line()
    coupled = system("follower", inputs={"follower.u": ramp(0.0, 1.0, 0.0, 1.0)})
    result = co_simulate(coupled, {"follower": slave}, stop_time=1.0, step_size=0.25)
    assert result["follower.y"].tolist() == [0.0, 0.0, 0.25, 0.5, 0.75]


def test_a_slope_is_passed_for_each_step_on_its_own() -> None:
    slave = FakeSlave(lambda t, u: [u], description=describe({"u": 0.0}, ("y",), can_interpolate_inputs=True))
    coupled = system("follower", inputs={"follower.u": ramp(0.0, 1.0, 0.25, 0.5)})
    result = co_simulate(coupled, {"follower": slave}, stop_time=1.0, step_size=0.25)
    assert slave.slopes == [0.0, 2.0, 2.0, 0.0]
    assert result["follower.u"].tolist() == [0.0, 0.0, 0.5, 1.0, 1.0]


def test_a_jump_takes_effect_in_the_step_that_starts_with_it() -> None:
    slave = delay_line()
    coupled = system("follower", inputs={"follower.u": Step(1.0, 2.0, at=0.3)})
    result = co_simulate(coupled, {"follower": slave}, stop_time=1.0, step_size=0.1)
    assert result["follower.y"].tolist() == [1.0] * 4 + [2.0] * 7


def test_start_values_reach_the_slave_and_undriven_inputs_the_record() -> None:
    gain = Variable("gain", 9, "Real", "parameter", start="1")
    slave = FakeSlave(lambda t, u: [u], description=describe({"u": 0.5}, ("y",), extra=(gain,)))
    result = co_simulate(system("a", a={"u": 2.0, "gain": 3}), {"a": slave}, stop_time=1.0, step_size=0.5)
    assert slave.start_values == {"u": 2.0, "gain": 3.0}
    assert result["a.u"].tolist() == [2.0, 2.0, 2.0]


def test_a_failed_step_ends_the_run_at_once() -> None:
    slave = FakeSlave(lambda t: [t], fail_at=0.5)
    with pytest.raises(SlaveError, match=r"fake at t = 0\.50 s: fmi2DoStep returned fmi2Discard: no more"):
        co_simulate(system("clock"), {"clock": slave}, stop_time=1.0, step_size=0.25)
    assert slave.steps == [(0.0, 0.25), (0.25, 0.25)]


def test_progress_grows_to_one() -> None:
    seen: list[float] = []
    co_simulate(system("clock"), {"clock": clock()}, stop_time=1.0, step_size=1e-3, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    assert len(seen) <= 250


def test_a_value_that_is_not_finite_is_reported_with_its_time(caplog: pytest.LogCaptureFixture) -> None:
    slave = FakeSlave(lambda t: [t if t < 0.6 else np.nan])
    co_simulate(system("clock"), {"clock": slave}, stop_time=1.0, step_size=0.25)
    assert "clock.y is nan from t = 0.75 s on" in caplog.text


def test_an_unknown_algorithm_is_refused_with_the_nearest() -> None:
    with pytest.raises(InputError, match="no algorithm 'gauss-seidl'; did you mean 'gauss-seidel'"):
        Method("gauss-seidl")


def test_a_result_names_what_it_holds_and_cannot_be_changed() -> None:
    result = co_simulate(system("a", inputs={"a.u": Constant(1.0)}), {"a": delay_line()}, stop_time=1.0, step_size=0.5)
    assert result.names == ("a.y", "a.u")
    with pytest.raises(InputError, match=r"'a\.Y' was not recorded; did you mean 'a\.y'\?"):
        result["a.Y"]
    with pytest.raises(ValueError, match="read-only"):
        result["a.y"][0] = 1.0
