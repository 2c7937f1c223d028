"""The command line end to end, on the probe FMU and on mistakes."""

from __future__ import annotations

import csv
import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner, Result

from cosim.cli.app import app

ROOT = Path(__file__).parents[3]

SCENARIO = """
title = "The probe"
stop_time = 1.0
step_size = 0.125

[components.probe]
fmu = "probe.fmu"

[inputs]
"probe.u" = 2.0
"""
LOOP = """
stop_time = 1.0
step_size = 0.125
connections = [{ from = "probe.u_seen", to = "probe.u" }]

[components.probe]
fmu = "loop.fmu"
"""
VARIANTS = """
[[variants]]
name = "plain"

[[variants]]
name = "steep"
set = { "probe.gain" = 3 }
"""


@pytest.fixture
def folder(probe: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory with a scenario of one probe."""
    (tmp_path / "probing.toml").write_text(SCENARIO)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments))


def one_sentence(result: Result) -> str:
    assert "Traceback" not in result.output
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("error: ")
    return lines[0]


def column(path: Path, name: str) -> list[float]:
    with path.open(newline="") as file:
        return [float(row[name]) for row in csv.DictReader(file)]


def test_list_names_every_scenario() -> None:
    result = run("list")
    assert result.exit_code == 0
    for name in ("stick-slip", "lower-wob", "higher-speed", "wob-law", "bit-damping", "dissipative-law"):
        assert name in result.stdout


def test_a_run_writes_trajectory_manifest_and_figure_and_says_where(folder: Path) -> None:
    result = run("run", "probing.toml")
    assert result.exit_code == 0, result.output
    out = folder / "runs" / "probing"
    assert sorted(path.name for path in out.iterdir()) == ["figure.png", "manifest.json", "trajectory.csv"]
    for path in out.iterdir():
        assert f"wrote {path.relative_to(folder)}" in result.stdout
    assert column(out / "trajectory.csv", "time") == [k * 0.125 for k in range(9)]
    assert column(out / "trajectory.csv", "probe.integral")[-1] == pytest.approx(2.0)
    assert (out / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_the_manifest_says_how_to_repeat_the_run(folder: Path) -> None:
    assert run("run", "probing.toml", "--algorithm", "gauss-seidel", "--set", "probe.gain=2").exit_code == 0
    manifest = json.loads((folder / "runs" / "probing" / "manifest.json").read_text())
    (variant,) = manifest["variants"]
    component = variant["components"]["probe"]
    assert component["sha256"] == hashlib.sha256((folder / "probe.fmu").read_bytes()).hexdigest()
    assert component["parameters"]["gain"] == 2
    assert component["parameters"]["fail_status"] == 2.0
    assert component["parameters"]["mode"] == "slow"
    assert (variant["algorithm"], variant["step_size"], variant["stop_time"]) == ("gauss-seidel", 0.125, 1.0)
    assert variant["inputs"] == {"probe.u": {"kind": "constant", "value": 2.0}}
    assert set(variant["timings"]) == {"load", "initialise", "step"}
    assert {"fmpy", "numpy", "python", "drillstring-cosim"} <= set(manifest["versions"])


def test_a_run_names_its_algebraic_loops(folder: Path, make_probe: Callable[..., Path]) -> None:
    (folder / "looping.toml").write_text(LOOP)
    make_probe("loop.fmu", replace={'<Unknown index="6" dependencies=""/>': '<Unknown index="6" dependencies="1"/>'})
    result = run("run", "looping.toml")
    assert result.exit_code == 0, result.output
    loop = "probe.u -> probe.u_seen -> probe.u"
    assert f"looping: algebraic loop {loop}: jacobi passes on values of the step before" in result.stdout
    (variant,) = json.loads((folder / "runs" / "looping" / "manifest.json").read_text())["variants"]
    assert variant["loops"] == [loop]


def test_a_run_ends_with_what_is_known_of_the_coupling(folder: Path, make_probe: Callable[..., Path]) -> None:
    (folder / "looping.toml").write_text(LOOP)
    make_probe("loop.fmu", replace={'<Unknown index="6" dependencies=""/>': '<Unknown index="6" dependencies="1"/>'})
    result = run("run", "looping.toml", "--algorithm", "implicit", "--tolerance", "1e-3")
    assert result.exit_code == 0, result.output
    for text in (
        "16 steps of at most 0.125 s (implicit)",
        "looping: algebraic loop probe.u -> probe.u_seen -> probe.u: closed in every step, to 1e-09 of the values",
        "looping: components of a loop were stepped 1.00 times a step, at most 1 time",
        "looping: estimated error 0 in a step at most, 0 on average",
        "tolerance 0.001, 0 steps rejected",
    ):
        assert text in result.stdout
    (variant,) = json.loads((folder / "runs" / "looping" / "manifest.json").read_text())["variants"]
    assert variant["unsolved"]["steps"] == 0
    assert variant["iterations"] == {"mean": 1.0, "most": 1}
    assert variant["error_estimate"]["largest"] == 0.0


def test_an_fmu_that_cannot_return_is_named_before_anything_is_started(
    folder: Path, make_probe: Callable[..., Path]
) -> None:
    (folder / "looping.toml").write_text(LOOP)
    make_probe("loop.fmu", replace={' canGetAndSetFMUstate="true"': ""})
    for option, why in (
        (("--algorithm", "implicit"), "the implicit algorithm repeats the steps of probe"),
        (("--tolerance", "1e-3"), "with a tolerance, steps are taken back"),
    ):
        result = run("run", "looping.toml", *option)
        assert result.exit_code == 2
        expected = f"error: {why}, but probe (Probe) cannot return to an earlier state (canGetAndSetFMUstate is false)"
        assert one_sentence(result) == expected
    assert not (folder / "runs").exists()
    assert run("run", "looping.toml").exit_code == 0


def test_variants_get_a_folder_each(folder: Path) -> None:
    (folder / "probing.toml").write_text(SCENARIO + VARIANTS)
    result = run("run", "probing.toml", "--output", "out")
    assert result.exit_code == 0, result.output
    out = folder / "out"
    assert sorted(path.name for path in out.iterdir()) == ["figure.png", "manifest.json", "plain", "steep"]
    assert column(out / "plain" / "trajectory.csv", "probe.integral")[-1] == pytest.approx(2.0)
    assert column(out / "steep" / "trajectory.csv", "probe.integral")[-1] == pytest.approx(6.0)
    assert run("run", "probing.toml", "--output", "out", "--variant", "steep").exit_code == 0
    assert sorted(path.name for path in out.iterdir()) == ["figure.png", "manifest.json", "trajectory.csv"]


def test_options_replace_what_the_scenario_says(folder: Path) -> None:
    result = run("run", "probing.toml", "--step-size", "0.5", "--stop-time", "2", "--set", "probe.u=3")
    assert result.exit_code == 0, result.output
    path = folder / "runs" / "probing" / "trajectory.csv"
    assert column(path, "time") == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert column(path, "probe.integral")[-1] == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["stick-slop"], "there is no scenario 'stick-slop'; did you mean 'stick-slip'?"),
        (["absent.toml"], "absent.toml: there is no such file"),
        (["probing.toml", "--set", "probe.gian=2"], "probe: Probe has no variable 'gian'; did you mean 'gain'?"),
        (["probing.toml", "--set", "probe.gain=-2"], "probe.gain is -2; expected a finite number >= 0 and <= 10"),
        (["probing.toml", "--set", "probe.gain=much"], "probe.gain is 'much'; expected a number"),
        (["probing.toml", "--set", "probe.mode=furious"], "probe.mode is 'furious'; expected one of 'slow' (1)"),
        (["probing.toml", "--set", "gain"], "--set gain: expected the form component.variable=value"),
        (["probing.toml", "--set", "gain=2"], "'gain': expected the form component.variable"),
        (["probing.toml", "--step-size", "-1"], "step size is -1 s; expected a number > 0"),
        (["probing.toml", "--step-size", "nan"], "step size is nan s; expected a finite number"),
        (["probing.toml", "--stop-time", "0"], "stop time is 0 s; expected a time after the start"),
        (["probing.toml", "--algorithm", "jacoby"], "there is no algorithm 'jacoby'; did you mean 'jacobi'?"),
        (["probing.toml", "--on-failure", "stop"], "on_failure is 'stop'; known: explicit, fail, halve"),
        (["probing.toml", "--tolerance", "0"], "tolerance is 0; expected a number > 0 and < 1"),
        (["probing.toml", "--packaging", "rust"], "there is no packaging 'rust'; known: native, python"),
        (["probing.toml", "--variant", "x"], "probing: there is no variant 'x'"),
        (["probing.toml", "--output", "probe.fmu"], "probe.fmu is a file; expected a folder"),
        (["probing.toml", "--output", "."], "holds something that is not a run"),
    ],
)
def test_a_mistake_is_one_sentence_and_exit_code_2(folder: Path, arguments: list[str], message: str) -> None:
    before = sorted(folder.iterdir())
    result = run("run", *arguments)
    assert result.exit_code == 2
    assert message in one_sentence(result)
    assert sorted(folder.iterdir()) == before


def test_a_failed_run_is_one_sentence_and_exit_code_1_and_nothing_is_written(folder: Path) -> None:
    result = run("run", "probing.toml", "--set", "probe.fail_at=0.5")
    assert result.exit_code == 1
    assert result.stderr.splitlines() == [
        "warning: probe: ready at 1.5",
        "error: probe at t = 0.50 s: fmi2DoStep returned fmi2Discard: the probe gave up at 0.5 s",
    ]
    assert not (folder / "runs").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to another process")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_leaves_nothing_behind(folder: Path, number: int) -> None:
    temporary = folder / "temporary"
    temporary.mkdir()
    before = sorted(folder.rglob("*"))
    process = subprocess.Popen(
        [sys.executable, "-m", "cosim", "run", "probing.toml", "--step-size", "1e-6", "--stop-time", "20"],
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "TMPDIR": str(temporary)},
    )
    while not list(temporary.glob("cosim-*/binaries")):
        assert process.poll() is None
        time.sleep(0.02)
    time.sleep(0.5)
    process.send_signal(number)
    _, said = process.communicate()
    assert process.returncode == 130
    assert said.strip().splitlines()[-1] == "interrupted; nothing was written"
    assert sorted(folder.rglob("*")) == before


def test_a_figure_of_something_not_recorded_is_refused_before_the_run(folder: Path) -> None:
    (folder / "probing.toml").write_text(SCENARIO + '[figure]\nsignals = ["probe.integral", "probe.integrl"]\n')
    for more in ((), ("--stream",)):
        result = run("run", "probing.toml", *more)
        assert result.exit_code == 2
        assert "figure.signals: 'probe.integrl' is not recorded; did you mean 'probe.integral'?" in one_sentence(result)
        assert not (folder / "runs").exists()


@pytest.mark.parametrize("mistake", ["gian = 2", "gain = -2", 'gain = "much"'])
def test_a_mistake_in_the_last_variant_is_told_before_the_first_is_run(folder: Path, mistake: str) -> None:
    variants = VARIANTS.replace('"probe.gain" = 3', f"probe.{mistake}")
    (folder / "probing.toml").write_text(SCENARIO + variants)
    for more in ((), ("--stream",)):
        result = run("run", "probing.toml", *more)
        assert result.exit_code == 2
        one_sentence(result)
        assert not (folder / "runs").exists()
    assert run("run", "probing.toml", "--variant", "plain").exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--stop-time", "1e-8"], [0.0, 1e-8]),
        (["--step-size", "1000"], [0.0, 1.0]),
        (["--step-size", "1e300"], [0.0, 1.0]),
        (["--step-size", "1000", "--stop-time", "1000"], [0.0, 1000.0]),
    ],
)
def test_a_step_beyond_the_run_is_one_step_of_it_and_is_told(
    folder: Path, arguments: list[str], expected: list[float]
) -> None:
    result = run("run", "probing.toml", *arguments)
    assert result.exit_code == 0, result.output
    assert column(folder / "runs" / "probing" / "trajectory.csv", "time") == expected
    assert f"1 step of {expected[-1]:g} s (jacobi)" in result.stdout
    told = f"which is longer than the run; it is run in one step of {expected[-1]:g} s"
    assert (told in result.stderr) is (expected[-1] != 1000.0)


@pytest.mark.parametrize("step", ["1e-300", "1e-17"])
def test_a_step_that_times_cannot_tell_is_refused(folder: Path, step: str) -> None:
    result = run("run", "probing.toml", "--step-size", step)
    assert result.exit_code == 2
    assert f"step size is {float(step):g} s; expected one that tells times near 1 s apart" in one_sentence(result)


@pytest.mark.parametrize("width", [20, 40, 60])
def test_a_narrow_terminal_cuts_no_number_and_no_name(
    folder: Path, width: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run("run", "probing.toml").exit_code == 0
    console = Console(width=width, file=StringIO(), force_terminal=True, no_color=True, highlight=False)
    monkeypatch.setattr("cosim.cli.terminal.new_console", lambda: console)
    monkeypatch.setattr("cosim.cli.app.new_console", lambda: console)
    assert run("run", "stick-slip", "--stop-time", "5").exit_code == 0
    assert run("list").exit_code == 0
    text = console.file.getvalue()  # pyright: ignore[reportAttributeAccessIssue]
    for number in ("20.6728", "0.675316", "4.042882", "2.5567"):
        assert number in text
    assert "dissipative-law" in text
    assert "…" not in text


def test_a_list_whose_reader_is_gone_ends_quietly() -> None:
    command = f"{sys.executable} -m cosim list | true"
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("", "")


def test_a_scenario_with_a_byte_order_mark_is_read(folder: Path) -> None:
    (folder / "probing.toml").write_text(SCENARIO, encoding="utf-8-sig")
    assert run("run", "probing.toml").exit_code == 0


@pytest.mark.skipif(sys.platform == "win32", reason="no pipe whose reader is gone")
@pytest.mark.parametrize(
    "arguments",
    [("list",), ("--help",), ("run", "--help"), ("run", "stick-slip", "--stop-time", "1", "--output", "out")],
)
def test_a_reader_that_leaves_keeps_nothing_from_being_done(arguments: tuple[str, ...], tmp_path: Path) -> None:
    """As with `cosim list | true`: the first write finds nobody, and the run is written all the same."""
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-c", "from cosim.cli.app import main; main()", *arguments]
    done = subprocess.run(
        command, stdout=writing, stderr=subprocess.PIPE, cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}
    )
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, b"")
    assert "stick-slip" not in arguments or (tmp_path / "out" / "trajectory.csv").is_file()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no disk that is always full")
def test_output_that_cannot_be_written_is_a_sentence(tmp_path: Path) -> None:
    command = [sys.executable, "-c", "from cosim.cli.app import main; main()", "list"]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            command, stdout=full, stderr=subprocess.PIPE, cwd=tmp_path, env=os.environ | {"PYTHONPATH": str(ROOT)}
        )
    assert done.returncode == 1
    assert done.stderr.decode().strip() == "error: the output cannot be written: No space left on device"


@pytest.mark.parametrize(
    ("times", "steps"),
    [
        (("--stop-time", "1", "--step-size", "0.25"), "4 steps of 0.25 s"),
        (("--stop-time", "1", "--step-size", "0.3"), "4 steps of at most 0.3 s"),
        (("--stop-time", "1e-8"), "1 step of 1e-08 s"),
    ],
)
def test_steps_are_told_as_they_were(folder: Path, times: tuple[str, ...], steps: str) -> None:
    assert f"; {steps} (jacobi) in " in run("run", "stick-slip", *times).output
