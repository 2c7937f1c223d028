"""An FMU that does what it should not, in a process of its own: the master gets the right numbers or a sentence."""

from __future__ import annotations

import ctypes
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from cosim import Component, Constant, Scenario, System, simulate
from cosim.errors import CosimError
from cosim.fmi2.isolation import Limits

pytestmark = [
    pytest.mark.hardening,
    pytest.mark.skipif(sys.platform != "linux", reason="the misdeeds are those of Linux"),
]

LIMITS = Limits(time=1.0, memory=200e6)
SOURCE = Path(__file__).parent / "misdeeds"
PLACES = {
    "instantiate": "while it was loaded and instantiated",
    "set": "while its inputs were set",
    "get": "while its outputs were read",
    "step": "in fmi2DoStep",
    "free": "while it was freed and unloaded",
}

CRASH = r"crashed .* \(SIG[A-Z]+\)"
ENDED = r"ended its process .* \(exit code \d+\)"
HUNG = r"hung .* and was stopped after 1 s"
NONSENSE = r"answered nonsense .* and was stopped"
CLOSED = r"closed the channel to the master .* and was stopped|" + ENDED
HELD = r"was stopped .* because it held \d+ MB of memory; expected at most 200 MB"
STATUS = r"returned .*|fmi2Instantiate failed"
NEVER = "no error"  # as the run may end before another process has begun

HARMLESS = (
    "exhaust_descriptors close_standard shout fork_and_return child_stays daemon_stays program_stays many_stay comet "
    "hang_up_on_parent adopt thread_spins put_fifos lock_up_folders round_up leave_folder take_signals block_signals "
    "speak_otherwise lower_limits log_flood log_nonsense log_a_megabyte"
)
"""Misdeeds that an FMU survives: then its numbers are the right ones."""

TOLD = {
    CRASH: "segfault do_abort kill_itself trap divide free_twice overflow_stack unmap_itself alarm_clock kill_group "
    "thread_crashes empty_files empty_files_and_crash put_fifos_and_crash put_links_and_crash kill_parent "
    "orphan_itself",
    ENDED: "exit_0 exit_3 exit_at_once exec_true fork_and_leave child_keeps_the_pipe terminate_parent",
    HUNG: "spin sleep_for_ever stop_itself deafen fault_for_ever be_traced write_half_a_frame "
    "child_keeps_the_pipe_of_a_hung_one stop_parent",
    NONSENSE: "write_garbage write_drop_by_drop surplus_frame frames_to_come claim_a_gigabyte",
    f"{NONSENSE}|{ENDED}|{HUNG}|{NEVER}": "flood_from_a_thread flood_from_a_child steal_requests hang_at_exit",
    HELD: "grow grow_and_return grow_in_a_child grow_in_many_children grow_without_descriptors grow_shared",
    CLOSED: "close_all close_all_and_sleep exec_sleep",
    STATUS: "demand_much illegal_status negative_status fatal_status pending_status",
}
FATAL = {name: expected for expected, names in TOLD.items() for name in names.split()}
MISDEEDS = [*HARMLESS.split(), *FATAL]
EVERYWHERE = (
    "segfault do_abort kill_itself free_twice overflow_stack alarm_clock kill_group thread_crashes "
    "empty_files_and_crash put_fifos_and_crash kill_parent orphan_itself exit_0 exit_3 exec_true fork_and_leave "
    "child_keeps_the_pipe sleep_for_ever stop_itself child_keeps_the_pipe_of_a_hung_one stop_parent write_garbage "
    "surplus_frame frames_to_come flood_from_a_child grow grow_in_a_child grow_without_descriptors close_all "
    "exec_sleep demand_much exhaust_descriptors fork_and_return daemon_stays comet put_fifos lock_up_folders "
    "take_signals lower_limits log_flood hang_at_exit"
)
"""Those that are tried at each place; the others at one after the other."""
CASES = [(misdeed, place) for misdeed in EVERYWHERE.split() for place in PLACES] + [
    (misdeed, [*PLACES][number % len(PLACES)])
    for number, misdeed in enumerate(name for name in MISDEEDS if name not in EVERYWHERE.split())
]


def test_every_misdeed_of_the_fmu_is_expected_to_end_somehow() -> None:
    text = (SOURCE / "misdeeds.c").read_text()
    assert set(re.findall(r"MISDEED\((\w+)\)", text)) - {"name"} == {*MISDEEDS}
    assert {*EVERYWHERE.split()} <= {*MISDEEDS}
    assert len(EVERYWHERE.split()) >= 40


def scenario(misdeeds: Path, name: str) -> Scenario:
    system = System((Component(name, misdeeds),), inputs={f"{name}.u": Constant(2.0)})
    return Scenario("misdeeds", system, stop_time=1.25, step_size=0.125)


RIGHT = [0.25 * step for step in range(11)]
"""The integral, exact in any rounding mode."""

SUBREAPER = 36


def adopt(whether: bool) -> None:
    """Become the parent of whatever descendants of this process leave behind, or no longer."""
    assert ctypes.CDLL(None).prctl(SUBREAPER, ctypes.c_ulong(whether), 0, 0, 0) == 0


def children() -> set[int]:
    """Return the living children of this process, and bury those that came from elsewhere."""
    tasks = Path("/proc/self/task").iterdir()
    found = {int(number) for task in tasks for number in (task / "children").read_text().split()}
    return {process for process in found if not is_buried(process)}


def is_buried(process: int) -> bool:
    """Bury a child that has ended; those that Popen knows have been waited for by then."""
    with suppress(ChildProcessError):
        return os.waitpid(process, os.WNOHANG)[0] == process
    return True


def still_there(before: set[int], patience: float = 2.0) -> set[int]:
    """Return the new children that live on; a killed one takes a moment to die on a machine that has much to do."""
    end = time.monotonic() + patience
    while (left := children() - before) and time.monotonic() < end:
        time.sleep(0.01)
    return left


@pytest.fixture
def nothing_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Fail if a process is left, in whatever session; as long as the test lasts they would come to this one."""
    before = children()
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    monkeypatch.setenv("MISDEED", str(tmp_path / "done"))
    adopt(True)
    yield
    left = still_there(before)
    while remaining := children() - before:
        for process in remaining:
            with suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
    adopt(False)
    assert not left


@pytest.mark.parametrize(("misdeed", "place"), CASES)
def test_a_misdeed_is_harmless_or_told(
    misdeeds: Path, nothing_left: None, tmp_path: Path, misdeed: str, place: str, caplog: pytest.LogCaptureFixture
) -> None:
    name = f"{place}__{misdeed}"
    result = told = None
    try:
        result = simulate(scenario(misdeeds, name), isolate=True, limits=LIMITS)
    except CosimError as error:
        told = str(error)
    assert time.time() - (tmp_path / "done").stat().st_mtime <= 2.0 * LIMITS.time
    if result is not None:
        assert result[f"{name}.y"].tolist() == RIGHT
    expected = FATAL.get(misdeed, NEVER)
    if place == "free" and told is None:
        warned = [record.getMessage() for record in caplog.records if "the FMU" in record.getMessage()]
        told = next((text for text in warned if PLACES["free"] in text), None)
        expected = NEVER if expected == STATUS else expected  # fmi2FreeInstance returns none
    if told is None:
        assert NEVER in expected
    else:
        assert name in told
        assert re.search(expected, told), told


LONG = 'stop_time = 1000.0\nstep_size = 0.001\n[components.step__{misdeed}]\nfmu = "{fmu}"\nisolate = true\n'


@pytest.mark.parametrize("misdeed", ["daemon_stays", "comet", "child_keeps_the_pipe_of_a_hung_one", "take_signals"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_nothing_is_left_when_the_master_is_interrupted_or_killed_meanwhile(
    misdeeds: Path, nothing_left: None, tmp_path: Path, misdeed: str, number: signal.Signals
) -> None:
    (tmp_path / "misdeeds.toml").write_text(LONG.format(misdeed=misdeed, fmu=misdeeds))
    command = [sys.executable, "-m", "cosim", "run", "misdeeds.toml"]
    master = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while not (tmp_path / "done").exists():
        assert master.poll() is None
        time.sleep(0.02)
    master.send_signal(number)
    if (
        "hung" in misdeed and number == signal.SIGINT
    ):  # the first waits for the end of the step, the second acts at once
        time.sleep(0.2)
        master.send_signal(number)
    assert master.wait() == (130 if number == signal.SIGINT else -number)
    began = time.monotonic()
    while children() and time.monotonic() - began < LIMITS.time:  # a keeper ends a moment after a master that is killed
        time.sleep(0.02)


@pytest.mark.parametrize("misdeed", ["segfault", "sleep_for_ever", "surplus_frame", "empty_files", "daemon_stays"])
def test_the_command_tells_of_a_misdeed_in_a_sentence(
    misdeeds: Path, nothing_left: None, tmp_path: Path, misdeed: str
) -> None:
    (tmp_path / "misdeeds.toml").write_text(
        f'stop_time = 1.25\nstep_size = 0.125\n[components.step__{misdeed}]\nfmu = "{misdeeds}"\n'
    )
    command = [sys.executable, "-m", "cosim", "run", "misdeeds.toml", "--isolate", "--time-limit", "1"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "Traceback" not in done.stderr
    if misdeed in HARMLESS.split():
        assert done.returncode == 0
    else:
        said = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
        assert done.returncode == 1
        assert re.fullmatch(rf"error: step__{misdeed} at t = 0\.25 s: the FMU ({FATAL[misdeed]})", " ".join(said))
