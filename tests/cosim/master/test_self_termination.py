"""An FMU that ends itself ends the run as well: normally, with its rows, and with its name."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from typer.testing import CliRunner

from cosim import (
    Component,
    Connection,
    Constant,
    Method,
    Result,
    RunOptions,
    Scenario,
    SlaveError,
    System,
    co_simulate,
    load_scenario,
    simulate,
    stream,
)
from cosim.cli.app import app
from cosim.errors import EndRequestError
from cosim.run.job import Job, run_job
from cosim.system.signals import FloatArray, Signal
from tests.cosim.fakes import FakeSlave, describe

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("no_leftovers")]

REASON = "nothing is left to drill at 0.5 s"
WAYS: dict[str, dict[str, Any]] = {
    "jacobi": {},
    "gauss-seidel": {"algorithm": "gauss-seidel"},
    "implicit": {"algorithm": "implicit"},
    "halving": {"algorithm": "implicit", "on_failure": "halve"},
    "tolerance": {"tolerance": 1e-3},
    "isolated": {"isolate": True},
    "isolated tolerance": {"isolate": True, "tolerance": 1e-3},
}


@pytest.fixture
def probe(make_probe: Callable[..., Path]) -> Path:
    """A probe whose output fits its own input."""
    return make_probe(replace={'<Real unit="rad"/>': '<Real unit="rad/s"/>'})


def chain(probe: Path, ender: str = "ending", at: float = 0.5, **times: float) -> Scenario:
    """Couple a component that ends itself into a circle with one that would go on."""
    components = (Component(ender, probe, {"fail_at": at}), Component("other", probe))
    connections = [(f"{ender}.integral", "other.u"), ("other.integral", f"{ender}.u")]
    system = System(components, tuple(Connection(*ends) for ends in connections), {})
    return Scenario("test", system, **{"stop_time": 2.0, "step_size": 0.1, **times})


@pytest.mark.parametrize("way", WAYS)
def test_the_run_ends_with_all_rows_before_and_the_name_of_the_one_that_ended_it(probe: Path, way: str) -> None:
    result = simulate(chain(probe), **WAYS[way])
    assert result.record["ended"] == {"component": "ending", "time": 0.5, "reason": REASON}
    assert result.time[0] == 0.0
    assert result.time[-1] == pytest.approx(0.5, abs=1e-12)
    whole = simulate(chain(probe, at=9.0), **WAYS[way])
    assert "ended" not in whole.record
    for name in ("ending.integral", "other.integral"):
        assert result[name].tolist() == whole[name][: result.time.size].tolist()


@pytest.mark.parametrize("compiled", [True, False])
def test_both_loops_end_at_the_last_common_point_and_tell_when_within_the_step(probe: Path, compiled: bool) -> None:
    components = (Component("first", probe), Component("ending", probe, {"fail_at": 0.53}))
    system = System(components, (), {"first.u": Constant(2.0)})
    scenario = Scenario("test", system, stop_time=2.0, step_size=0.1, method=Method(compiled=compiled))
    result = simulate(scenario)
    assert result.time.tolist() == [0.1 * k for k in range(6)]
    assert result["first.integral"].size == 6
    assert result.record["steps"] == 5
    assert result.record["ended"]["time"] == 0.53


def test_one_that_does_not_tell_when_has_ended_at_the_communication_point(probe: Path) -> None:
    result = simulate(chain(probe, "ending-mute", 0.53))
    assert result.record["ended"]["time"] == result.time[-1] == 0.5


def test_with_steps_that_are_taken_back_the_end_is_approached_by_smaller_ones(probe: Path) -> None:
    for options in ({"tolerance": 1e-3}, {"algorithm": "implicit", "on_failure": "halve"}):
        result = simulate(chain(probe, at=0.53), **options)
        assert 0.53 - 0.1 / 512 < result.time[-1] <= 0.53
        assert result.record["ended"]["time"] == 0.53


@pytest.mark.parametrize("way", WAYS)
def test_an_end_in_the_first_step_leaves_the_values_after_initialisation(probe: Path, way: str) -> None:
    result = simulate(chain(probe, at=0.0), **WAYS[way])
    assert result.time.tolist() == [0.0]
    assert result.record["ended"]["time"] == 0.0


@pytest.mark.parametrize("csv", [True, False])
@pytest.mark.parametrize("steps", [20, 20000])
def test_a_streamed_run_ends_alike_and_is_complete(probe: Path, tmp_path: Path, steps: int, csv: bool) -> None:
    scenario = chain(probe, stop_time=0.1 * steps, at=0.05 * steps)
    kept = simulate(scenario)
    streamed = stream(scenario, tmp_path / "run", csv=csv)
    assert streamed.record["ended"] == kept.record["ended"]
    assert streamed.time[-1] == kept.time[-1]
    assert not (tmp_path / "run" / "checkpoint.npz").exists()
    if csv:
        kept.to_csv(tmp_path / "kept.csv")
        assert (tmp_path / "run" / "trajectory.csv").read_bytes() == (tmp_path / "kept.csv").read_bytes()


def test_the_command_line_names_the_end_and_exits_with_0(probe: Path, tmp_path: Path) -> None:
    (tmp_path / "run.toml").write_text(
        f'stop_time = 2.0\nstep_size = 0.1\n[components.ending]\nfmu = "{probe.as_posix()}"\n'
        "parameters = { fail_at = 0.5 }\n"
    )
    for extra in ([], ["--stream"], ["--isolate"]):
        folder = tmp_path / "-".join(["out", *extra])
        done = CliRunner().invoke(app, ["run", str(tmp_path / "run.toml"), "--output", str(folder), *extra])
        assert done.exit_code == 0, done.output
        assert f"ending asked to end the simulation at t = 0.50 s: {REASON}" in done.output
        manifest = json.loads((folder / "manifest.json").read_text())
        assert manifest["variants"][0]["ended"] == {"component": "ending", "time": 0.5, "reason": REASON}


class Ending(FakeSlave):
    """Ends itself where a condition on the end of the step holds."""

    def __init__(self, ends: Callable[..., bool], compute: Callable[..., Sequence[float]], **options: Any) -> None:
        super().__init__(compute, **options)
        self.ends = ends

    def advance(self, size: float) -> Sequence[float]:
        inputs = [self.values[name] + size * self.rates[name] for name in self.values]
        if self.ends(self.time, *inputs):
            raise EndRequestError(self.name, self.time - size, "enough", self.time - size)
        return super().advance(size)


def loop_of(ends: Callable[..., bool], kind: type[Ending] = Ending, **settings: Any) -> Result:
    """Close x = t / 2 + y / 2, y = x: so x = t."""
    first = FakeSlave(lambda t, y: [t / 2 + y / 2], {"y": 0.0}, ("x",), name="first")
    second = kind(ends, lambda t, x: [x], inputs={"x": 0.0}, outputs=("y",), name="second")
    ends_of = [("first.x", "second.x"), ("second.y", "first.y")]
    system = System(
        (Component("first", "first.fmu"), Component("second", "second.fmu")),
        tuple(Connection(*each) for each in ends_of),
    )
    slaves = {"first": first, "second": second}
    return co_simulate(system, slaves, stop_time=1.0, step_size=0.125, method=Method("implicit", **settings))


def test_a_trial_that_ends_a_component_is_no_end_if_values_agree_elsewhere() -> None:
    result = loop_of(lambda t, x: x > 1.0 or x < t - 0.1)
    assert "ended" not in result.record
    np.testing.assert_allclose(result["second.y"], result.time, atol=1e-8)


def test_an_end_that_every_trial_meets_ends_the_run() -> None:
    result = loop_of(lambda t, x: t > 0.5)
    assert result.record["ended"] == {"component": "second", "time": 0.5, "reason": "enough"}
    assert result.time.tolist() == [0.0, 0.125, 0.25, 0.375, 0.5]


def test_an_end_beside_a_jump_is_the_end_and_not_a_loop_without_a_solution() -> None:
    result = loop_of(lambda t, x: x > 0.55)
    assert result.record["ended"]["component"] == "second"
    assert result.time[-1] == 0.5


class Final(Ending):
    """Ends itself, and cannot be brought back from there."""

    ended = False

    def advance(self, size: float) -> Sequence[float]:
        self.ended = True
        out = super().advance(size)
        self.ended = False
        return out

    def restore(self, slot: int) -> None:
        if self.ended:
            raise SlaveError(self.name, self.time, "fmi2SetFMUstate", "fmi2Error", "it is over")
        super().restore(slot)


@pytest.mark.parametrize("settings", [{}, {"on_failure": "halve"}, {"tolerance": 0.5}], ids=str)
def test_one_that_cannot_be_brought_back_from_its_end_ends_the_run_all_the_same(settings: dict[str, Any]) -> None:
    for ends in (lambda t, x: t > 0.5, lambda t, x: x > 0.52):
        result = loop_of(ends, Final, **settings)
        assert result.record["ended"]["component"] == "second"
        assert result.time[-1] == pytest.approx(0.5, abs=0.021)


def test_an_end_in_a_later_trial_has_the_last_word_where_nothing_can_be_tried_after_it() -> None:
    result = loop_of(lambda t, x: x > 0.1, Final)
    assert result.record["ended"] == {"component": "second", "time": 0.0, "reason": "enough"}
    assert result.time.tolist() == [0.0]


def test_a_discarded_step_without_an_end_is_an_error_as_before(probe: Path) -> None:
    with pytest.raises(SlaveError, match=r"fmi2DoStep returned fmi2Discard: the probe gave up at 0\.5 s") as caught:
        simulate(chain(probe, "failing"))
    assert not isinstance(caught.value, EndRequestError)


def test_one_that_nothing_depends_on_and_cannot_go_back_ends_a_run_with_a_tolerance_too() -> None:
    source = FakeSlave(lambda t: [t], name="source")
    description = describe({"u": 0.0}, ("y",), can_save_state=False)
    sink = Ending(lambda t, u: t > 0.5, lambda t, u: [u], description=description, name="sink")
    system = System(
        (Component("source", "source.fmu"), Component("sink", "sink.fmu")), (Connection("source.y", "sink.u"),)
    )
    method = Method("jacobi", tolerance=0.1)
    result = co_simulate(system, {"source": source, "sink": sink}, stop_time=1.0, step_size=0.25, method=method)
    assert result.record["ended"]["component"] == "sink"
    assert result.time[-1] == 0.5


class Dip(Signal):
    """Fall below what the plant takes, where no breakpoint shows it before the run."""

    kind = "dip"
    breakpoints = ()

    def values(self, times: FloatArray) -> NDArray[np.generic]:
        return np.where((times > 1.0) & (times < 2.0), 97347.0 - 2e5 * (times - 1.0), 97347.0)

    def left_values(self, times: FloatArray) -> NDArray[np.generic]:
        return self.values(times)

    def slopes(self, times: FloatArray) -> FloatArray:
        return np.zeros(times.shape)


@pytest.mark.parametrize("isolate", [False, True])
def test_a_step_that_an_fmu_of_this_project_refuses_ends_no_run_normally(isolate: bool) -> None:
    """The library of pythonfmu says of every step that is refused that the FMU wants no more of them."""
    scenario = load_scenario("stick-slip")
    inputs = {**scenario.system.inputs, "plant.WOB": Dip()}
    ending = replace(scenario, system=replace(scenario.system, inputs=inputs), stop_time=3.0)
    with pytest.raises(SlaveError, match="WOB is -") as refused:
        simulate(ending, packaging="python", isolate=isolate)
    assert not isinstance(refused.value, EndRequestError)


def test_a_run_that_ends_in_its_first_step_has_no_measures_and_no_traceback(probe: Path, tmp_path: Path) -> None:
    system = System(
        (Component("plant", "DrillstringNeutral"), Component("ending", probe, {"fail_at": 0.005})),
        (),
        {"plant.Omega": Constant(10.0), "plant.WOB": Constant(97347.0), "ending.u": Constant(0.0)},
    )
    job = Job(Scenario("test", system, 1.0, 0.01), RunOptions())
    manifest = run_job(job, tmp_path / "run", lambda label, part: None)
    assert manifest.variants[0].run.coupling.ended is not None
    assert manifest.variants[0].findings.measures is None
