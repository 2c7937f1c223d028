"""Laws of communication steps of variable size: what is kept, what is taken back, and what the estimates are worth."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np
import pytest

from cosim import InputError, Method, SlaveError, Step, co_simulate, ramp
from cosim.errors import SystemDefinitionError
from cosim.report.statement import statement
from cosim.run.report import CouplingReport
from tests.cosim.fakes import FakeSlave, LinearSlave, describe
from tests.cosim.master.test_implicit import OSCILLATOR, exact_speed, oscillator, run, system

ALGORITHMS = ("jacobi", "gauss-seidel", "implicit")


@pytest.mark.parametrize(
    ("algorithm", "tolerances"),
    [("jacobi", (1e-1, 2e-2, 4e-3)), ("gauss-seidel", (1e-1, 2e-2, 4e-3)), ("implicit", (1e-2, 1e-3, 1e-4))],
)
def test_the_error_follows_the_tolerance(algorithm: str, tolerances: tuple[float, ...]) -> None:
    found = []
    for tolerance in tolerances:
        slaves = oscillator(can_interpolate_inputs=True)
        result = run(OSCILLATOR, slaves, Method(algorithm, tolerance=tolerance), 1.0, 0.125)
        found.append(np.abs(result["a.y0"] - exact_speed(result.time)).max())
        estimates = result.record["error_estimate"]
        assert estimates["largest"] <= tolerance
        assert estimates["beyond_tolerance"] == 0
        assert found[-1] < 10.0 * tolerance
        assert result["coupling.error_estimate"].max() == pytest.approx(estimates["largest"])
    assert found[0] > 2.0 * found[1] > 4.0 * found[2]


def test_a_smaller_tolerance_costs_straight_lines_less_than_held_inputs() -> None:
    steps = {}
    for algorithm in ALGORITHMS:
        method = Method(algorithm, tolerance=1e-3)
        steps[algorithm] = run(OSCILLATOR, oscillator(can_interpolate_inputs=True), method, 2.0, 0.5).record["steps"]
    assert steps["implicit"] < 0.2 * steps["gauss-seidel"]


def test_regular_points_and_jumps_are_met_and_steps_begin_at_multiples_of_their_size() -> None:
    coupled = system("ab", "b.y0>a.u0 a.y0>b.u0", {})
    result = run(coupled, oscillator(can_interpolate_inputs=True), Method("implicit", tolerance=1e-4), 1.0, 0.25)
    assert {0.0, 0.25, 0.5, 0.75, 1.0} <= set(result.time.tolist())
    for time, size in zip(result.time[:-1], np.diff(result.time), strict=True):
        assert (time / size).is_integer()
        assert math.log2(0.25 / size).is_integer()
    slaves = {"a": LinearSlave([[-1.0]], [[1.0]], [[1.0]]), "b": FakeSlave(lambda t, u: [u], {"u": 0.0})}
    jumps = run(system("ab", "a.y0>b.u", {"a.u0": Step(0.0, 1.0, at=0.3)}), slaves, Method("jacobi", tolerance=1e-3))
    assert 0.3 in jumps.time


def test_steps_that_are_taken_back_leave_no_trace() -> None:
    method = Method("gauss-seidel", tolerance=1e-2)
    result = run(OSCILLATOR, oscillator(), method, 2.0, 0.5)
    assert result.record["rejected"] > 0
    slaves = oscillator()
    speed, force = 1.0, -0.5
    speeds, forces = [speed], [force]
    for size in np.diff(result.time):
        slaves["a"].values, slaves["a"].rates = {"u0": force}, {"u0": 0.0}
        slaves["a"].time = slaves["b"].time = 0.0
        (speed,) = slaves["a"].advance(size)
        slaves["b"].values, slaves["b"].rates = {"u0": speed}, {"u0": 0.0}
        (force,) = slaves["b"].advance(size)
        speeds.append(speed)
        forces.append(force)
    assert result["a.y0"].tolist() == speeds
    assert result["b.y0"].tolist() == forces


class DelayLine(FakeSlave):
    """Its output is its input 0.6 s ago; at the end of a step nothing shows of what the input was within it."""

    DELAY = 0.6

    def __init__(self) -> None:
        super().__init__(
            lambda t, u: [0.0],
            description=describe({"u": 0.0}, can_interpolate_inputs=True, outputs=("y",), feedthrough={"y": ()}),
        )
        self.pieces: deque[tuple[float, float, float, float]] = deque()

    def advance(self, size: float) -> Sequence[float]:
        value, rate = self.values["u"], self.rates["u"]
        self.pieces.append((self.time - size, self.time, value, rate))
        then = self.time - self.DELAY
        for begin, end, value, rate in self.pieces:
            if begin <= then <= end:
                return [value + rate * (then - begin)]
        return [0.0]

    def state(self) -> object:
        return deque(self.pieces)

    def set_state(self, state) -> None:
        self.pieces = deque(state)


def test_an_assumption_that_is_wrong_within_a_step_counts_although_nothing_shows_at_its_end() -> None:
    def slaves():
        return {"l": DelayLine(), "f": FakeSlave(lambda t, u: [math.sin(7.0 * t) + 0.3 * u], {"u": 0.0})}

    coupled = system("lf", "f.y>l.u l.y>f.u")
    fixed = run(coupled, slaves(), Method("implicit"), 2.0, 0.25)
    controlled = run(coupled, slaves(), Method("implicit", tolerance=1e-3), 2.0, 0.25)
    assert controlled.record["steps"] > 4 * fixed.record["steps"]
    times = controlled.time
    exact = sum(np.where(times >= 0.6 * k, 0.3**k * np.sin(7.0 * (times - 0.6 * k)), 0.0) for k in range(4))
    assert controlled["f.y"] == pytest.approx(exact, abs=5e-3)
    coarse = sum(np.where(fixed.time >= 0.6 * k, 0.3**k * np.sin(7.0 * (fixed.time - 0.6 * k)), 0.0) for k in range(4))
    assert np.abs(fixed["f.y"] - coarse).max() > 5e-2


def test_steps_of_the_smallest_size_are_kept_and_counted() -> None:
    def noise(*values: float) -> list[float]:
        """Return what is as good as random, but the same for the same values: else no state could be returned to."""
        return [np.random.default_rng(np.array(values).view(np.uint64)).normal()]

    slaves = {
        "a": FakeSlave(noise, {"u": 0.0}),
        "b": LinearSlave([[-1.0]], [[1.0]], [[1.0]]),
    }
    result = run(system("ab", "b.y0>a.u a.y>b.u0"), slaves, Method("gauss-seidel", tolerance=1e-6), 0.25, 0.125)
    assert np.diff(result.time).min() == 0.125 / 1024
    beyond = int((result["coupling.error_estimate"] > 1e-6).sum())
    assert result.record["error_estimate"]["beyond_tolerance"] == beyond > 100
    assert any(
        f"{beyond} of {result.record['steps']} steps beyond" in text
        for text in statement(CouplingReport.from_record(result.record))
    )
    assert result.record["error_estimate"]["largest"] > 1e-3


def test_a_component_that_cannot_return_is_stepped_when_a_step_is_kept() -> None:
    recorder = FakeSlave(lambda t, u: [u], description=describe({"u": 0.0}, ("y",), can_save_state=False))
    slaves = {**oscillator(), "r": recorder}
    coupled = system("abr", "b.y0>a.u0 a.y0>b.u0 a.y0>r.u")
    result = run(coupled, slaves, Method("gauss-seidel", tolerance=1e-2), 2.0, 0.5)
    assert result.record["rejected"] > 0
    assert [time for time, _ in recorder.steps] == result.time[:-1].tolist()
    assert result["r.y"].tolist() == result["a.y0"].tolist()


def test_what_others_depend_on_must_be_able_to_return() -> None:
    source = FakeSlave(lambda t: [t], description=describe(outputs=("y",), can_save_state=False))
    slaves = {"s": source, "r": FakeSlave(lambda t, u: [u], {"u": 0.0})}
    message = r"with a tolerance, steps are taken back, but s \(Fake\) cannot return .*canGetAndSetFMUstate is false"
    with pytest.raises(SystemDefinitionError, match=message):
        run(system("sr", "s.y>r.u"), slaves, Method("jacobi", tolerance=1e-3))
    assert source.calls == []


def test_fmus_of_fixed_step_are_refused_by_name() -> None:
    stiff = FakeSlave(lambda t, u: [u], description=describe({"u": 0.0}, ("y",), can_vary_step=False))
    with pytest.raises(SystemDefinitionError, match=r"a \(Fake\) cannot do that \(canHandleVariableComm"):
        run(system("a", "a.y>a.u"), {"a": stiff}, Method("implicit", on_failure="halve"))


def test_a_step_that_a_component_discards_is_tried_smaller() -> None:
    class Fussy(FakeSlave):
        def advance(self, size: float) -> Sequence[float]:
            if size > 0.04:
                raise SlaveError("a", self.time, "fmi2DoStep", "fmi2Discard", "too large")
            return super().advance(size)

    slaves = {"a": Fussy(lambda t, u: [t - u], {"u": 0.0}), "b": FakeSlave(lambda t, u: [u], {"u": 0.0})}
    coupled = system("ab", "b.y>a.u a.y>b.u")
    result = run(coupled, slaves, Method("implicit", tolerance=1e-2))
    assert np.diff(result.time).max() == 0.5 * 0.125 / 4
    assert result["a.y"] == pytest.approx(result.time / 2.0, abs=1e-9)
    halved = run(
        coupled, {**slaves, "a": Fussy(lambda t, u: [t - u], {"u": 0.0})}, Method("implicit", on_failure="halve")
    )
    assert np.diff(halved.time).max() == 0.125 / 4
    with pytest.raises(SlaveError, match="too large"):
        run(coupled, {**slaves, "a": Fussy(lambda t, u: [t - u], {"u": 0.0})})


def test_a_signal_is_followed_whatever_the_steps_are() -> None:
    slaves = {
        "i": LinearSlave([[0.0]], [[1.0]], [[1.0]], can_interpolate_inputs=True),
        "n": LinearSlave([[-30.0]], [[30.0]], [[1.0]]),
    }
    coupled = system("in", "i.y0>n.u0", {"i.u0": ramp(0.0, 2.0, 0.3, 0.4)})
    for algorithm in ALGORITHMS:
        result = run(coupled, slaves, Method(algorithm, tolerance=1e-2), 1.0, 0.25)
        slaves["i"].x = slaves["n"].x = np.zeros(1)
        t = result.time
        exact = np.where(t < 0.3, 0.0, np.where(t < 0.7, 2.5 * (t - 0.3) ** 2, 0.4 + 2.0 * (t - 0.7)))
        assert result["i.y0"] == pytest.approx(exact, abs=1e-12)
        assert result["i.u0"] == pytest.approx(np.interp(t, [0.3, 0.7], [0.0, 2.0]), abs=1e-12)


@pytest.mark.parametrize("value", [0.0, -1e-3, 1.0, float("nan")])
def test_a_tolerance_that_makes_no_sense_is_refused(value: float) -> None:
    with pytest.raises(InputError, match=r"tolerance is .*; expected a number > 0 and < 1"):
        Method("implicit", tolerance=value)


def test_progress_grows_to_one_in_steps_of_variable_size() -> None:
    seen: list[float] = []
    coupled, slaves = OSCILLATOR, oscillator()
    method = Method("jacobi", tolerance=1e-2)
    co_simulate(coupled, slaves, stop_time=2.0, step_size=0.01, method=method, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    assert len(seen) <= 250
