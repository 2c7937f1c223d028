"""Do checks in processes of their own, so that an FMU that crashes or hangs takes down nothing but its process."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, cast

from cosim.check.examination.behaviour import ALONE
from cosim.check.examination.instance import CallTrace
from cosim.check.examination.worker import JOURNAL, TRACE, UNLOADING, CheckJob
from cosim.check.verdict import Outcome, Verdict, failed, noted
from cosim.fmi2.isolation.family import end_session
from cosim.fmi2.isolation.process import fault

_WAIT, _STARTUP = 0.02, 60.0
Told = Callable[[str], None]


@dataclass(frozen=True)
class CheckEnd:
    """A check that has ended, whether by itself or with its process."""

    name: str
    outcome: Outcome
    seconds: float


def run_checks(job: CheckJob, time_limit: float, tell: Told) -> list[CheckEnd]:
    """Do the checks of a job in one process, up to the one that takes the process down, if any does.

    Parameters
    ----------
    job : CheckJob
        What to do.
    time_limit : float
        For each check [s].
    tell : callable
        Told the name of each check as it begins.

    Returns
    -------
    list of CheckEnd
        In order; fewer than asked for if the process was lost, the last one saying how.
    """
    folder = Path(job.folder)
    (folder / JOURNAL).write_text("", encoding="utf-8")
    (folder / TRACE).unlink(missing_ok=True)
    (folder / "job.json").write_text(json.dumps(asdict(job)), encoding="utf-8")
    command = [sys.executable, "-m", "cosim.check.examination.worker", str(folder / "job.json")]
    with (folder / "output.txt").open("wb") as output:
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT, start_new_session=True
        )
        try:
            timed_out = _watch(process, folder, time_limit, tell)
        finally:
            end_session(process.pid)
            process.wait()
    return _ended(job, process.returncode, time_limit if timed_out else None)


def _watch(process: subprocess.Popen[bytes], folder: Path, time_limit: float, tell: Told) -> bool:
    """Wait for the process to end; return whether a check took too long."""
    seen, began, ended = 0, time.monotonic(), False
    while not ended:
        ended = process.poll() is not None
        begun = [event["check"] for event in _events(folder) if event["event"] == "begin"]
        if len(begun) > seen:
            for name in begun[seen:]:
                tell(name)
            seen, began = len(begun), time.monotonic()
        elif time.monotonic() - began > (time_limit if seen else max(time_limit, _STARTUP)):
            return not ended
        time.sleep(0.0 if ended else _WAIT)
    return False


def _events(folder: Path) -> list[dict[str, Any]]:
    """Return what the worker has said so far, but for a line it is still writing."""
    text = (folder / JOURNAL).read_text(encoding="utf-8")
    lines = text.splitlines(keepends=True)
    return [cast(dict[str, Any], json.loads(line)) for line in lines if line.endswith("\n")]


def _ended(job: CheckJob, code: int, time_limit: float | None) -> list[CheckEnd]:
    folder = Path(job.folder)
    events = _events(folder)
    ended = [_as_ended(event) for event in events if event["event"] == "end"]
    last = events[-1] if events else {"event": "begin", "check": job.checks[0]}
    if code == 0 and last["check"] == UNLOADING:
        return ended
    how = _lost(folder, code, time_limit)
    found = noted(how, "not for an FMU to survive") if last["event"] == "forgive" else failed(how)
    return [*ended, CheckEnd(last["check"], found, time_limit or 0.0)]


def _as_ended(event: dict[str, Any]) -> CheckEnd:
    names = ("found", "allowed", "done", "data")
    outcome = Outcome(Verdict(event["verdict"]), **{name: event[name] for name in names})
    return CheckEnd(event["check"], outcome, event.get("seconds", 0.0))


def _lost(folder: Path, code: int, time_limit: float | None) -> str:
    """Say how a process was lost."""
    function = CallTrace.read(folder / TRACE)
    where = f" in {function}" if function else " while it was loaded"
    if time_limit is not None:
        return f"hung{where}, stopped after {time_limit:g} s"
    if how := fault(code):
        return f"crashed{where} ({how})"
    last = _last_line(folder / "output.txt")
    return f"ended the process{where} (exit code {code})" + (f": {last}" if last else "")


def _last_line(path: Path) -> str:
    lines = path.read_text(encoding="utf-8", errors="replace").strip().splitlines()
    return lines[-1][:200] if lines else ""


def run_in_turn(job: CheckJob, time_limit: float, tell: Told) -> list[CheckEnd]:
    """Do the checks of a job, in a new process after each loss of one and before each that must begin alone.

    Parameters
    ----------
    job : CheckJob
        What to do; verdicts and plan are passed on from process to process.
    time_limit : float
        For each check [s].
    tell : callable
        Told the name of each check as it begins.
    """
    ended: list[CheckEnd] = []
    left: list[str] = list(job.checks)
    while left:
        together = 1 + next((place for place, name in enumerate(left[1:]) if name in ALONE), len(left) - 1)
        job = replace(job, checks=left[:together])
        done = run_checks(job, time_limit, tell)
        ended += done
        verdicts = job.verdicts | {each.name: each.outcome.verdict for each in done}
        plans = [each.outcome.data for each in done if each.name == "run" and each.outcome.data]
        job = replace(job, verdicts=verdicts, plan=plans[-1] if plans else job.plan)
        left = [name for name in left if name not in verdicts]
    return ended
