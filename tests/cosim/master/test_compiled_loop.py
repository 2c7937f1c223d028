"""The compiled loop takes the steps that the readable one takes: the same bits, the same sentences."""

from __future__ import annotations

import itertools
import logging
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cosim import Component, Constant, Result, Scenario, SlaveError, Step, System, load_scenario, ramp, simulate
from cosim.master.compiled_loop import step_library


def run(scenario: Scenario, *, compiled: bool, **options) -> Result:
    """Run with one of the two loops, and make sure it was that one."""
    result = simulate(replace(scenario, method=replace(scenario.method, compiled=compiled)), **options)
    assert result.record["step_loop"] == ("compiled" if compiled else "python")
    return result


def probing(probe: Path, *, inputs=None, parameters=None) -> Scenario:
    system = System((Component("probe", probe, parameters or {}),), (), inputs or {})
    return Scenario("probing", system, stop_time=1.0, step_size=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize(
    ("name", "variant"),
    [
        ("stick-slip", None),
        ("wob-law", None),
        ("bit-damping", "c_b=15"),
        ("dissipative-law", "printed"),
        ("dissipative-law", "tracking"),
    ],
)
@pytest.mark.parametrize("packaging", ["native", "python"])
def test_both_loops_give_the_same_bits(name: str, variant: str | None, algorithm: str, packaging: str) -> None:
    scenario = load_scenario(name)
    options = {"variant": variant, "algorithm": algorithm, "packaging": packaging, "stop_time": 4.0}
    in_c, in_python = (run(scenario, compiled=compiled, **options) for compiled in (True, False))
    assert list(in_c.columns) == list(in_python.columns)
    for column, values in in_c.columns.items():
        assert values.tobytes() == in_python.columns[column].tobytes(), column


def test_every_type_and_every_slope_passes_both_loops_alike(probe: Path) -> None:
    inputs = {
        "probe.u": ramp(0.0, 3.0, 0.25, 0.5),
        "probe.n": Step(3, 4, at=0.5),
        "probe.flag": Step(False, True, at=0.33),
    }
    in_c, in_python = (run(probing(probe, inputs=inputs), compiled=compiled) for compiled in (True, False))
    assert in_c["probe.u_seen"].tolist() == pytest.approx(np.interp(in_c.time, [0.25, 0.75], [0.0, 3.0]), abs=1e-14)
    for column, values in in_c.columns.items():
        assert values.tobytes() == in_python.columns[column].tobytes(), column


@pytest.mark.parametrize("status", [2, 3, 4])
def test_a_failed_step_is_told_in_the_same_sentence(probe: Path, status: int) -> None:
    said: list[str] = []
    for compiled in (True, False):
        with pytest.raises(SlaveError) as caught:
            run(probing(probe, parameters={"fail_at": 0.35, "fail_status": status}), compiled=compiled)
        said.append(str(caught.value))
    assert said[0] == said[1]
    assert said[0].startswith("probe at t = 0.40 s: fmi2DoStep returned ")


def test_a_warning_does_not_end_the_run(probe: Path) -> None:
    scenario = probing(probe, inputs={"probe.u": Constant(1.0)}, parameters={"fail_at": 0.35, "fail_status": 1})
    in_c, in_python = (run(scenario, compiled=compiled) for compiled in (True, False))
    assert in_c.time.size == 11
    assert in_c["probe.integral"].tolist() == in_python["probe.integral"].tolist()


def test_without_a_compiler_steps_are_taken_in_python(
    probe: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    clock = itertools.count()
    waited = 0.0

    def fail(command: list[str], **options: object) -> None:
        nonlocal waited
        waited = 1e6
        raise subprocess.CalledProcessError(1, command, stderr="no such compiler\n")

    step_library.cache_clear()
    monkeypatch.setattr("cosim.master.compiled_loop.user_cache_path", lambda name: tmp_path / name)
    monkeypatch.setattr(subprocess, "run", fail)
    monkeypatch.setattr("cosim.master.compiled_loop.PACKAGED", tmp_path / "built")
    monkeypatch.setattr("cosim.master.co_simulation.time.perf_counter", lambda: waited + next(clock))
    try:
        with caplog.at_level(logging.WARNING):
            result = simulate(probing(probe, inputs={"probe.u": Constant(1.0)}))
    finally:
        step_library.cache_clear()
    assert (result.record["step_loop"], result.record["step_loop_reason"]) == (
        "python",
        "no such compiler",
    )
    timings = result.record["timings"]
    assert timings["initialise"] + timings["step"] < waited  # the wait for the compiler is not the run's
    assert "steps are taken in Python: no such compiler" in caplog.text
