"""An FMU that declares that it can return to an earlier state, and cannot, is refused; others notice nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from cosim import Component, Connection, Constant, Method, Result, Scenario, System, co_simulate, simulate, stream
from cosim.cli.app import app
from cosim.errors import SlaveError, SystemDefinitionError
from cosim.master import rollback
from tests.cosim.fakes import FakeSlave, LinearSlave

pytestmark = pytest.mark.usefixtures("no_leftovers")

DECLARES = r"cannot return to an earlier state, although it declares so \(canGetAndSetFMUstate is true\): "
REPEATED = r"from the same state, the step from t = 0\.00 s to 0\.10 s gave "
WAYS: tuple[dict[str, Any], ...] = ({"tolerance": 1e-3}, {"algorithm": "implicit"}, {"isolate": True, "tolerance": 0.1})


@pytest.fixture
def probe(make_probe: Callable[..., Path]) -> Path:
    """A probe whose output fits an input of its own that has no effect."""
    return make_probe(replace={'<Real unit="rad"/>': '<Real unit="rpm"/>'})


def circle(probe: Path, first: str, stop_time: float = 1.0) -> Scenario:
    """Couple two components, so that each has to return whichever the way."""
    connections = (Connection(f"{first}.integral", "other.v"), Connection("other.integral", f"{first}.v"))
    components = (Component(first, probe), Component("other", probe))
    inputs = {f"{first}.u": Constant(2.0), "other.u": Constant(3.0)}
    return Scenario("test", System(components, connections, inputs), stop_time=stop_time, step_size=0.1)


@pytest.mark.parametrize("way", WAYS, ids=str)
@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("forgetting", REPEATED + r"integral = 0\.2, and then 0\.4"),
        ("counting", REPEATED + r"n_next = \d+, and then \d+"),
        ("stateless", r"fmi2SetFMUstate returned fmi2Error at t = 0\.00 s"),
    ],
)
def test_a_lie_is_refused_by_name_before_any_row(
    probe: Path, tmp_path: Path, name: str, what: str, way: dict[str, Any]
) -> None:
    with pytest.raises(SystemDefinitionError, match=rf"^{name} \(Probe\) {DECLARES}{what}$"):
        simulate(circle(probe, name), **way)
    with pytest.raises(SystemDefinitionError, match=DECLARES):
        stream(circle(probe, name), tmp_path / "run", csv=True, **way)
    assert not (tmp_path / "run").exists()


def test_the_command_line_exits_as_for_any_lack_of_a_capability(probe: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.toml"
    file.write_text(
        f'stop_time = 1.0\nstep_size = 0.1\n[components.forgetting]\nfmu = "{probe.as_posix()}"\n'
        '[inputs]\n"forgetting.u" = 2.0\n'
    )
    done = CliRunner().invoke(app, ["run", str(file), "--output", str(tmp_path / "out"), "--tolerance", "1e-3"])
    assert done.exit_code == 2
    assert "forgetting (Probe) cannot return to an earlier state, although it declares so" in done.output
    assert not (tmp_path / "out").exists()


def test_without_steps_taken_back_no_state_is_asked_of_anybody(probe: Path) -> None:
    for name in ("forgetting", "counting", "stateless"):
        assert simulate(circle(probe, name))[f"{name}.integral"][-1] == pytest.approx(2.0, rel=1e-12)


def both(run: Callable[[], Result], monkeypatch: pytest.MonkeyPatch) -> tuple[Result, Result]:
    """Run with the trial and without."""
    tried = run()
    monkeypatch.setattr(rollback, "try_states", lambda *_: None)
    return tried, run()


@pytest.mark.parametrize("way", WAYS, ids=str)
def test_an_honest_fmu_gives_the_same_bits_with_the_trial_and_without(
    probe: Path, way: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    tried, untried = both(lambda: simulate(circle(probe, "first"), **way), monkeypatch)
    assert tried.names == untried.names
    for name in ("time", *tried.names):
        assert tried[name].tobytes() == untried[name].tobytes()


@pytest.mark.slow
@pytest.mark.parametrize("interpolates", [True, False])
def test_a_linear_loop_gives_the_same_bits_with_the_trial_and_without(
    interpolates: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run() -> Result:
        options: dict[str, Any] = {"can_interpolate_inputs": interpolates}
        mass = LinearSlave([[0.0]], [[1.0]], [[1.0]], start=[1.0], **options)
        spring = LinearSlave([[0.0]], [[1.0]], [[-10.0]], [[-0.5]], **options)
        parts = (Component("mass", "mass.fmu"), Component("spring", "spring.fmu"))
        system = System(parts, (Connection("mass.y0", "spring.u0"), Connection("spring.y0", "mass.u0")))
        method = Method("implicit", tolerance=1e-3)
        return co_simulate(system, {"mass": mass, "spring": spring}, stop_time=1.0, step_size=0.1, method=method)

    tried, untried = both(run, monkeypatch)
    for name in ("time", *tried.names):
        assert tried[name].tobytes() == untried[name].tobytes()


class Delaying(FakeSlave):
    """Puts out what it was given a step before, and does not save that: a delay line that is lost."""

    line = 0.0

    def advance(self, size: float) -> list[float]:
        del size
        out, self.line = self.line, self.values["u"] + 1.0
        return [out]


def alone(slave: FakeSlave, tolerance: float = 0.1) -> Result:
    source = FakeSlave(lambda t: [t], name="source")
    parts = (Component("source", "source.fmu"), Component("slave", "slave.fmu"))
    system = System(parts, (Connection("source.y", "slave.u"),))
    method = Method(tolerance=tolerance)
    return co_simulate(system, {"source": source, "slave": slave}, stop_time=1.0, step_size=0.1, method=method)


def test_a_delay_line_that_is_not_restored_is_noticed() -> None:
    with pytest.raises(SystemDefinitionError, match=rf"^slave \(Fake\) {DECLARES}{REPEATED}y = 0\.0, and then 1\.0$"):
        alone(Delaying(lambda t, u: [0.0], {"u": 0.0}))


def test_a_step_that_is_discarded_shows_nothing_and_is_tried_smaller() -> None:
    class Small(FakeSlave):
        def step(self, time: float, size: float) -> None:
            if size > 0.05:
                raise SlaveError(self.name, time, "fmi2DoStep", "fmi2Discard", "too large")
            super().step(time, size)

    result = alone(Small(lambda t, u: [u], {"u": 0.0}), 0.9)
    assert np.diff(result.time).max() <= 0.05


def test_a_step_that_is_discarded_the_second_time_only_is_a_lie() -> None:
    class Once(FakeSlave):
        def step(self, time: float, size: float) -> None:
            if self.steps:
                raise SlaveError(self.name, time, "fmi2DoStep", "fmi2Discard", "not again")
            super().step(time, size)

    with pytest.raises(SystemDefinitionError, match=DECLARES + r".* was taken, and then discarded$"):
        alone(Once(lambda t, u: [u], {"u": 0.0}))
