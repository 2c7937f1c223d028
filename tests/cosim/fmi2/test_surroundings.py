"""FMUs in the master's own process that change what all share there: it is put back, and said."""

from __future__ import annotations

import ctypes
import locale
import os
import signal
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cosim import Component, Constant, Scenario, System, simulate
from cosim.cli.app import app
from cosim.errors import SlaveError
from cosim.fmi2.surroundings import Surroundings

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the misdeeds are those of Linux")

MISDEEDS = {
    "round_up": "the mode of floating-point arithmetic",
    "leave_folder": "the working folder",
    "take_signals": "the handling of signals",
    "block_signals": "which signals are blocked",
    "speak_otherwise": "the locale",
}
PLACES = {
    "instantiate": "while it was loaded and instantiated",
    "step": "at t = 0.00 s or in the steps after it",
    "free": "while it was freed",
}
C = ctypes.CDLL(None)


def state() -> tuple[object, ...]:
    """What the misdeeds change, read by other ways than the product does where there is another."""
    ignored = Path("/proc/self/status").read_text().partition("SigIgn:")[2].split()[0]
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    return C.fegetround(), Path("/proc/self/cwd").readlink(), ignored, mask, locale.setlocale(locale.LC_ALL)


def scenario(fmu: Path, *names: str) -> Scenario:
    system = System(
        tuple(Component(name, fmu) for name in names), inputs={f"{name}.u": Constant(0.1) for name in names}
    )
    return Scenario("misdeeds", system, stop_time=1.0, step_size=0.1)


@pytest.fixture
def tidy():
    """Put back what a failing test has left, the mask of files included, which nobody looks at."""
    mask = os.umask(0o22)
    os.umask(mask)
    with Surroundings("a test").kept("as a whole"):
        yield
    os.umask(mask)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("misdeed", MISDEEDS)
def test_what_an_fmu_changes_is_put_back_and_said(
    misdeeds: Path, tidy: None, misdeed: str, place: str, caplog: pytest.LogCaptureFixture
) -> None:
    before = state()
    simulate(scenario(misdeeds, f"{place}__{misdeed}"))
    assert state() == before
    (told,) = [record.getMessage() for record in caplog.records if record.name == "cosim.surroundings"]
    assert told.startswith(f"{place}__{misdeed} changed {MISDEEDS[misdeed]} of this process {PLACES[place]}")


def test_what_an_fmu_does_as_it_is_loaded_changes_no_numbers_of_another(misdeeds: Path, tidy: None) -> None:
    alone = simulate(scenario(misdeeds, "other"))
    beside = simulate(scenario(misdeeds, "instantiate__round_up", "other"))
    assert beside["other.y"].tobytes() == alone["other.y"].tobytes()
    assert beside["instantiate__round_up.y"].tobytes() == alone["other.y"].tobytes()


def test_who_may_have_changed_something_in_a_step_is_told(
    misdeeds: Path, tidy: None, caplog: pytest.LogCaptureFixture
) -> None:
    simulate(scenario(misdeeds, "step__round_up", "other"))
    assert "one of step__round_up, other changed the mode of floating-point arithmetic" in caplog.text


def test_what_is_changed_before_a_failure_is_put_back_as_well(
    misdeeds: Path, tidy: None, caplog: pytest.LogCaptureFixture
) -> None:
    before = state()
    with pytest.raises(SlaveError):
        simulate(scenario(misdeeds, "step__round_up", "step__illegal_status"))
    assert state() == before
    assert "changed the mode of floating-point arithmetic" in caplog.text


def test_what_others_change_between_turns_is_left_as_it_is(
    misdeeds: Path, tidy: None, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    simulate(scenario(misdeeds, "other"), progress=lambda _: os.chdir(tmp_path))
    assert Path.cwd() == tmp_path
    assert not caplog.records


def test_signals_of_runtimes_that_fmus_bring_are_left_alone(caplog: pytest.LogCaptureFixture) -> None:
    former = signal.getsignal(signal.SIGUSR2)
    with Surroundings("law").kept("now"):
        C.signal(signal.SIGUSR2, 1)
    assert "SigIgn" in (status := Path("/proc/self/status").read_text())
    assert int(status.partition("SigIgn:")[2].split()[0], 16) >> (signal.SIGUSR2 - 1) & 1
    assert not caplog.records
    signal.signal(signal.SIGUSR2, former)


def test_an_fmu_that_changes_nothing_is_not_blamed(misdeeds: Path, caplog: pytest.LogCaptureFixture) -> None:
    simulate(scenario(misdeeds, "other"))
    assert not caplog.records


def test_results_are_where_they_were_asked_for_whatever_folder_an_fmu_goes_to(
    misdeeds: Path, tidy: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    name = "step__leave_folder"
    (tmp_path / "misdeeds.toml").write_text(
        f'stop_time = 1.0\nstep_size = 0.1\n[components.{name}]\nfmu = "{misdeeds}"\n[inputs]\n"{name}.u" = 0.1\n'
    )
    told = CliRunner().invoke(app, ["run", "misdeeds.toml", "--output", "results"])
    assert told.exit_code == 0, told.output
    assert {"trajectory.csv", "manifest.json"} <= {path.name for path in (tmp_path / "results").iterdir()}


def test_flags_that_any_operation_may_raise_are_left_alone(caplog: pytest.LogCaptureFixture) -> None:
    inexact = 0x20
    with Surroundings("law").kept("now"):
        C.feraiseexcept(inexact)
    assert not caplog.records
