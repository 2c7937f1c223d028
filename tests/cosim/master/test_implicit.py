"""Laws of the implicit algorithm, on slaves that are lambdas and linear systems."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from scipy.linalg import expm

from cosim import Component, Connection, Constant, Method, SlaveError, Step, System, co_simulate, ramp
from cosim.errors import LoopError, RunError, SystemDefinitionError
from cosim.report.statement import statement
from cosim.run.report import CouplingReport
from cosim.system.description import Variable
from tests.cosim.fakes import FakeSlave, LinearSlave, describe

IMPLICIT = Method("implicit")


def system(names: str, arrows: str = "", inputs=None) -> System:
    """Components by one letter each, connections written ``a.y>b.u``."""
    connections = tuple(Connection(*arrow.split(">")) for arrow in arrows.split())
    return System(tuple(Component(name, f"{name}.fmu") for name in names), connections, inputs or {})


def run(coupled: System, slaves, method: Method = IMPLICIT, stop: float = 1.0, step: float = 0.125):
    return co_simulate(coupled, slaves, stop_time=stop, step_size=step, method=method)


LOOP = system("ab", "b.y>a.u a.y>b.u")


@pytest.mark.parametrize("gain", [0.5, -0.9, -3.0, 1.7, 40.0])
def test_an_algebraic_loop_of_any_gain_is_closed_at_every_communication_point(gain: float) -> None:
    slaves = {
        "a": FakeSlave(lambda t, u: [math.sin(t) + gain * u], {"u": 0.0}),
        "b": FakeSlave(lambda t, u: [u + 1.0], {"u": 0.0}),
    }
    result = run(LOOP, slaves)
    assert result["a.y"] == pytest.approx((np.sin(result.time) + gain) / (1.0 - gain), rel=1e-8)
    assert result["a.u"] == pytest.approx(result["b.y"], rel=1e-8)
    assert result["coupling.iterations"].max() <= 3
    assert result.record["iterations"]["most"] <= 3
    assert result.record["unsolved"]["steps"] == 0


def test_jacobi_and_gauss_seidel_diverge_where_the_gain_exceeds_one() -> None:
    for algorithm in ("jacobi", "gauss-seidel"):
        slaves = {
            "a": FakeSlave(lambda t, u: [1.0 - 3.0 * u], {"u": 0.0}),
            "b": FakeSlave(lambda t, u: [u], {"u": 0.0}),
        }
        result = run(LOOP, slaves, Method(algorithm))
        assert result.record["initialisation"]["settled"] is False
        assert abs(result["a.y"][-1]) > 100.0


def test_two_loops_with_several_unknowns_close_together() -> None:
    coupled = system("abc", "b.y>a.u c.y>a.v a.y>b.u a.z>c.u c.y>b.v")
    slaves = {
        "a": FakeSlave(lambda t, u, v: [2.0 * u - v + t, u + 3.0 * v], {"u": 0.0, "v": 0.0}, ("y", "z")),
        "b": FakeSlave(lambda t, u, v: [1.0 - u + 0.5 * v], {"u": 0.0, "v": 0.0}),
        "c": FakeSlave(lambda t, u: [0.7 * u - 2.0], {"u": 0.0}),
    }
    result = run(coupled, slaves)
    # a.y = 2 b - c + t; a.z = b + 3 c; b = 1 - a.y + c / 2; c = 0.7 a.z - 2
    for row, time in enumerate(result.time):
        matrix = np.array([[1.0, 0.0, -2.0, 1.0], [0.0, 1.0, -1.0, -3.0], [1.0, 0.0, 1.0, -0.5], [0.0, -0.7, 0.0, 1.0]])
        exact = np.linalg.solve(matrix, [time, 0.0, 1.0, -2.0])
        found = [result[name][row] for name in ("a.y", "a.z", "b.y", "c.y")]
        assert found == pytest.approx(exact, rel=1e-8)


MASS, STIFFNESS, DAMPING = 1.0, 10.0, 0.5


def oscillator(**options):
    """A mass that is given a force, and a spring and damper that are given its speed."""
    mass = LinearSlave([[0.0]], [[1.0 / MASS]], [[1.0]], start=[1.0], **options)
    spring = LinearSlave([[0.0]], [[1.0]], [[-STIFFNESS]], [[-DAMPING]], **options)
    return {"a": mass, "b": spring}


OSCILLATOR = system("ab", "b.y0>a.u0 a.y0>b.u0")


def exact_speed(times: np.ndarray) -> np.ndarray:
    matrix = np.array([[-DAMPING / MASS, -STIFFNESS / MASS], [1.0, 0.0]])
    return np.array([(expm(time * matrix) @ [1.0, 0.0])[0] for time in times])


def errors(method: Method, sizes=(0.02, 0.01, 0.005, 0.0025), **options) -> np.ndarray:
    found = []
    for size in sizes:
        result = run(OSCILLATOR, oscillator(**options), method, 2.0, size)
        found.append(np.abs(result["a.y0"] - exact_speed(result.time)).max())
    return np.array(found)


def order(found: np.ndarray) -> float:
    """Fit the order over step sizes that halve."""
    return -float(np.polyfit(np.arange(found.size), np.log2(found), 1)[0])


def test_inputs_on_straight_lines_give_second_order_and_held_ones_first() -> None:
    assert order(errors(IMPLICIT, can_interpolate_inputs=True)) == pytest.approx(2.0, abs=0.1)
    assert order(errors(IMPLICIT)) == pytest.approx(1.0, abs=0.15)
    assert order(errors(Method("gauss-seidel"))) == pytest.approx(1.0, abs=0.15)


def test_a_component_outside_of_loops_is_stepped_once_with_final_inputs() -> None:
    coupled = system("sabr", "s.y>a.v b.y>a.u a.y>b.u b.y>r.u")
    slaves = {
        "s": FakeSlave(lambda t: [t], description=describe(outputs=("y",), can_save_state=False)),
        "a": FakeSlave(lambda t, u, v: [v - 2.0 * u], {"u": 0.0, "v": 0.0}),
        "b": FakeSlave(lambda t, u: [u], {"u": 0.0}),
        "r": FakeSlave(lambda t, u: [u], description=describe({"u": 0.0}, ("y",), can_save_state=False)),
    }
    result = run(coupled, slaves)
    assert [len(slaves[name].steps) for name in "sr"] == [8, 8]
    assert len(slaves["a"].steps) > 8
    assert result["r.y"] == pytest.approx(result.time / 3.0, abs=1e-9)
    assert result["r.u"].tolist() == result["b.y"].tolist()


def test_every_repetition_begins_from_the_same_state_with_inputs_set_anew() -> None:
    journal: list[tuple[str, str]] = []
    slaves = {
        "a": FakeSlave(lambda t, u: [t - 2.0 * u], {"u": 0.0}, name="a", journal=journal),
        "b": FakeSlave(lambda t, u: [u], {"u": 0.0}, name="b", journal=journal),
    }
    run(LOOP, slaves)
    for name, slave in slaves.items():
        calls = [call for slave_name, call in journal if slave_name == name]
        stepping = calls[calls.index("exit") + 2 :]
        assert stepping[0] == "save 0"
        for before, call, after in zip(stepping, stepping[1:], stepping[2:], strict=False):
            if call == "step":
                assert (before, after) == ("write", "read")
            if call == "write":
                assert before in ("save 0", "restore 0")
        begins = [time for time, _ in slave.steps]
        assert begins == sorted(begins)


def test_an_fmu_in_a_loop_that_cannot_return_is_refused_by_name_before_anything_is_called() -> None:
    slaves = {
        "a": FakeSlave(lambda t, u: [u], {"u": 0.0}),
        "b": FakeSlave(lambda t, u: [u], description=describe({"u": 0.0}, ("y",), can_save_state=False)),
    }
    message = r"repeats the steps of a and b, but b \(Fake\) cannot return to an earlier state"
    with pytest.raises(SystemDefinitionError, match=message):
        run(LOOP, slaves)
    assert slaves["a"].calls == slaves["b"].calls == []


def test_values_that_do_not_change_continuously_hold_what_they_are_at_the_beginning() -> None:
    flag = Variable("flag", 7, "Boolean", "output", "discrete")
    on = Variable("on", 8, "Boolean", "input", "discrete", start="false")
    slaves = {
        "a": FakeSlave(lambda t, u, on: [5.0 if on else t - u], description=describe({"u": 0.0}, ("y",), extra=(on,))),
        "b": FakeSlave(lambda t, u: [u, u > 0.3], description=describe({"u": 0.0}, ("y",), extra=(flag,))),
    }
    result = run(system("ab", "b.y>a.u a.y>b.u b.flag>a.on"), slaves)
    assert result["a.on"][1:].tolist() == result["b.flag"][:-1].tolist()
    first = int(np.argmax(result["b.flag"]))
    assert result.time[first] == 0.625
    assert result["a.y"][: first + 1] == pytest.approx(result.time[: first + 1] / 2.0, abs=1e-9)
    assert result["a.y"][first + 1 :].tolist() == [5.0] * (result.time.size - first - 1)


def integrator(**options) -> LinearSlave:
    """Its output is the integral of its input, and feeds nothing through."""
    return LinearSlave([[0.0]], [[1.0]], [[1.0]], can_interpolate_inputs=True, **options)


def test_a_jump_that_feeds_through_is_not_smeared_over_a_step() -> None:
    slaves = {"g": FakeSlave(lambda t, u: [3.0 * u], {"u": 0.0}), "i": integrator()}
    coupled = system("gi", "g.y>i.u0", {"g.u": Step(1.0, 2.0, at=0.5)})
    result = run(coupled, slaves)
    assert result["i.y0"] == pytest.approx(3.0 * result.time + 3.0 * np.maximum(result.time - 0.5, 0.0), rel=1e-12)
    assert result["g.u"].tolist() == [1.0] * 5 + [2.0] * 4


def test_what_a_flag_switches_at_once_is_not_smeared_either() -> None:
    flag = Variable("flag", 7, "Boolean", "output", "discrete")
    on = Variable("on", 8, "Boolean", "input", "discrete", start="false")
    slaves = {
        "f": FakeSlave(lambda t: [t >= 0.5], description=describe({}, (), extra=(flag,))),
        "g": FakeSlave(lambda t, on: [4.0 if on else 1.0], description=describe({}, ("y",), extra=(on,))),
        "i": integrator(),
    }
    result = run(system("fgi", "f.flag>g.on g.y>i.u0"), slaves)
    assert result["i.y0"] == pytest.approx(result.time + 3.0 * np.maximum(result.time - 0.5, 0.0), rel=1e-12)


def test_a_source_that_jumps_and_tells_its_derivative_is_followed_exactly() -> None:
    def program(t: float):
        return [2.0 * t if t < 0.5 else 7.0 - t]

    source = FakeSlave(program, description=describe(outputs=("y",), output_derivative_order=1))
    result = run(
        system("sgi", "s.y>g.u g.y>i.u0"),
        {"s": source, "g": FakeSlave(lambda t, u: [u], {"u": 0.0}), "i": integrator()},
    )
    t = result.time
    later = np.maximum(t - 0.5, 0.0)
    exact = np.where(t < 0.5, t**2, 0.25 + 7.0 * later - (t**2 - 0.25) / 2.0)
    # Through g, which holds its input, the value on the line after the jump is that at the end of the step.
    assert result["i.y0"] == pytest.approx(exact, abs=0.125**2)
    direct = run(system("si", "s.y>i.u0"), {"s": source, "i": integrator()})
    assert direct["i.y0"] == pytest.approx(exact, abs=1e-6)


def test_a_ramp_is_followed_to_its_end_by_components_that_hold() -> None:
    slaves = {"g": FakeSlave(lambda t, u: [3.0 * u], {"u": 0.0}), "i": integrator()}
    result = run(system("gi", "g.y>i.u0", {"g.u": ramp(0.0, 1.0, 0.0, 1.0)}), slaves)
    assert result["g.y"] == pytest.approx(3.0 * result.time, rel=1e-12)
    assert result["i.y0"] == pytest.approx(1.5 * result.time**2, rel=1e-12)


def jumping(t: float, u: float):
    """Put out 1 or -1, opposed to the input, from 0.3 s on."""
    return [0.5 * u if t < 0.3 else (1.0 if u < 0.25 else -1.0)]


def test_a_loop_without_a_solution_ends_the_run_with_time_variables_and_residual() -> None:
    slaves = {"a": FakeSlave(jumping, {"u": 0.0}), "b": FakeSlave(lambda t, u: [u], {"u": 0.0})}
    with pytest.raises(LoopError) as caught:
        run(LOOP, slaves)
    error = caught.value
    assert error.time == 0.25
    assert set(error.variables) == {"a.u", "a.y", "b.u", "b.y"}
    assert error.residual == pytest.approx(0.75, abs=0.01)
    assert str(error).startswith("t = 0.25 s: a.u -> a.y -> b.u -> b.y -> a.u has no solution: where a.u passes 0.25, ")
    assert "b.y jumps from 1 to -1" in str(error)
    assert isinstance(error, RunError)


def test_a_loop_without_a_solution_at_the_start_says_so() -> None:
    slaves = {"a": FakeSlave(lambda t, u: [u + 1.0], {"u": 0.0}), "b": FakeSlave(lambda t, u: [u], {"u": 0.0})}
    with pytest.raises(LoopError, match=r"t = 0\.00 s: .* does not close: no solution was found"):
        run(LOOP, slaves)
    assert "step" not in slaves["a"].calls


def test_a_run_that_goes_on_explicitly_tells_how_often_it_had_to(caplog: pytest.LogCaptureFixture) -> None:
    slaves = {"a": FakeSlave(jumping, {"u": 0.0}), "b": FakeSlave(lambda t, u: [u], {"u": 0.0})}
    result = run(LOOP, slaves, Method("implicit", on_failure="explicit"))
    assert result.time.size == 9
    assert result.record["unsolved"] == {"steps": 6, "first": 0.25, "largest_residual": pytest.approx(1.25, abs=0.6)}
    assert caplog.text.count("has no solution") == 1
    trials = int(re.findall(r"least residual of (\d+) trials", caplog.text)[0])
    assert result["coupling.iterations"][3] == trials + 1
    # Gauss-Seidel from there on: the input is what came back in the step before.
    assert result["a.u"][3:].tolist() == result["b.y"][2:-1].tolist()


def blow_up() -> dict[str, FakeSlave]:
    """x' = 1 + x^2 by the implicit Euler method, with the rate computed by another component.

    The exact solution is tan(t). A step from x to x + h (1 + X^2) has a solution only while h < 1 / (4 x + 4 h).
    """
    euler = FakeSlave(lambda t, u: [0.0], {"u": 1.0})
    euler.x = 0.0

    def advance(size: float):
        euler.x += size * euler.values["u"]
        return [euler.x]

    euler.advance, euler.state = advance, lambda: euler.x
    euler.set_state = lambda state: setattr(euler, "x", state)
    return {"a": euler, "b": FakeSlave(lambda t, u: [1.0 + u * u], {"u": 0.0})}


def test_halving_finds_the_steps_in_which_there_is_a_solution() -> None:
    with pytest.raises(LoopError, match="does not close"):
        run(LOOP, blow_up(), stop=1.25)
    result = run(LOOP, blow_up(), Method("implicit", on_failure="halve"), stop=1.25)
    assert result.record["rejected"] > 0
    assert set(np.arange(11) * 0.125) <= set(result.time)
    sizes = np.diff(result.time)
    assert sizes[0] == 0.125
    assert sizes.min() < 0.125
    assert result["a.y"][-1] > math.tan(1.25)
    x = result["a.y"]
    assert x[1:] == pytest.approx(x[:-1] + sizes * (1.0 + x[1:] ** 2), rel=1e-7)


def test_halving_comes_to_an_end() -> None:
    slaves = {"a": FakeSlave(jumping, {"u": 0.0}), "b": FakeSlave(lambda t, u: [u], {"u": 0.0})}
    with pytest.raises(LoopError, match="has no solution"):
        run(LOOP, slaves, Method("implicit", on_failure="halve"))
    assert min(size for _, size in slaves["a"].steps) == 0.125 / 1024


def test_a_discarded_trial_is_tried_nearer_to_what_was_taken() -> None:
    def picky(t: float, u: float):
        if u > 1.2:
            raise SlaveError("a", t, "fmi2DoStep", "fmi2Discard", "too much")
        return [0.4 + t + 0.4 * u * u]

    slaves = {"a": FakeSlave(picky, {"u": 0.0}), "b": FakeSlave(lambda t, u: [0.8 * u], {"u": 0.0})}
    result = run(LOOP, slaves, stop=0.25)
    u = result["a.u"]
    assert u == pytest.approx(0.8 * (0.4 + result.time + 0.4 * u * u), rel=1e-8)


@pytest.mark.parametrize("status", ["fmi2Discard", "fmi2Error"])
def test_a_step_that_is_refused_whatever_is_tried_is_the_components_error(status: str) -> None:
    def refusing(t: float, u: float):
        if t > 0.4:
            raise SlaveError("a", t, "fmi2DoStep", status, "no more")
        return [0.5 * u]

    slaves = {"a": FakeSlave(refusing, {"u": 0.0}), "b": FakeSlave(lambda t, u: [u], {"u": 0.0})}
    with pytest.raises(SlaveError, match=f"a at t = 0.50 s: fmi2DoStep returned {status}: no more"):
        run(LOOP, slaves)


def test_trials_stay_within_the_declared_bounds() -> None:
    u = Variable("u", 0, "Real", "input", start="1", minimum=0.0, maximum=2.0)
    tried: list[float] = []

    def gain(t: float, u: float):
        tried.append(u)
        return [3.0 - 50.0 * (u - 1.0)]

    bounded = FakeSlave(gain, description=describe({}, ("y",), extra=(u,)))
    result = run(LOOP, {"a": bounded, "b": FakeSlave(lambda t, u: [u], {"u": 0.0})})
    assert result["a.u"] == pytest.approx(53.0 / 51.0, rel=1e-9)
    assert 0.0 <= min(tried) <= max(tried) <= 2.0


def test_rounding_of_time_never_leads_an_input_past_its_bound() -> None:
    """An FMU that keeps its own time knows the size of a step as a difference of times, and so another slope."""
    u = Variable("u", 0, "Real", "input", start="1", minimum=0.0, maximum=2.0)
    reached: list[float] = []

    class Clocked(FakeSlave):
        begin = 1000.0

        def advance(self, size: float):
            reached.append(self.values["u"] + (self.time - self.begin) * self.rates["u"])
            self.begin = self.time
            return [0.0]

    limited = Clocked(lambda t, u: [0.0], description=describe({}, ("y",), extra=(u,), can_interpolate_inputs=True))
    slaves = {"a": FakeSlave(lambda t: [2.0 if round(1000.0 * t) % 2 else 0.0]), "b": limited}
    coupled = system("ab", "a.y>b.u")
    co_simulate(coupled, slaves, start_time=1000.0, stop_time=1000.5, step_size=1e-3, method=IMPLICIT)
    assert len(reached) == 500
    assert 0.0 <= min(reached) <= max(reached) <= 2.0
    assert reached[0] == pytest.approx(2.0, abs=1e-8)


def test_a_value_with_a_limit_active_is_told_as_the_limits_and_not_as_a_solution() -> None:
    limit = Variable("limit_active", 7, "Boolean", "output", "discrete")

    def limited(t: float, u: float):
        wanted = 4.0 * t + 0.5 * u
        return [min(wanted, 3.0), wanted > 3.0]

    slaves = {
        "a": FakeSlave(limited, description=describe({"u": 0.0}, ("y",), extra=(limit,))),
        "b": FakeSlave(lambda t, u: [u], {"u": 0.0}),
    }
    result = run(LOOP, slaves)
    assert result["a.y"] == pytest.approx(np.minimum(8.0 * result.time, 3.0), abs=1e-8)
    assert result.record["guards"] == {"a.limit_active": {"points": 5, "first": 0.5, "last": 1.0}}
    (loop, *_, guard) = statement(CouplingReport.from_record(result.record))
    assert loop.endswith("where a.limit_active is on, by the value of that guard or limit and not by a solution")
    assert guard.startswith("a.limit_active is on at 5 communication points from t = 0.50 s to 1.00 s")


def test_an_input_that_nothing_changes_needs_no_repetition() -> None:
    slaves = {"a": FakeSlave(lambda t, u: [0.5 * u], {"u": 0.0}), "b": FakeSlave(lambda t, u: [u], {"u": 0.0})}
    coupled = system("ab", "b.y>a.u a.y>b.u")
    result = run(coupled, slaves)
    assert result["coupling.iterations"][1:].tolist() == [1] * 8
    undriven = run(system("a", inputs={"a.u": Constant(1.0)}), {"a": FakeSlave(lambda t, u: [u], {"u": 0.0})})
    assert undriven["a.y"].tolist() == [1.0] * 9
