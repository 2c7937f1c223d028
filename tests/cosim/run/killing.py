"""Runs that are killed at random moments and gone on with, in processes that are forked from one that is warm.

`python -m tests.cosim.run.killing KILLS [SEED]` does it until so many have died.
"""

from __future__ import annotations

import logging
import os
import random
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import matplotlib.backends.backend_agg  # pyright: ignore  # noqa: F401  # loaded before processes are forked
import numcodecs  # pyright: ignore  # noqa: F401
import xarray  # noqa: F401

from cosim import RunOptions, load_scenario
from cosim.provenance import commit
from cosim.run.job import Job
from cosim.run.options import Streaming
from tests.cosim.run.jobs import go_on, outcome

WAYS = {
    f"{store}, {algorithm}{', isolated' if isolated else ''}": (store == "csv", algorithm, isolated)
    for store in ("zarr", "csv")
    for algorithm in ("jacobi", "implicit")
    for isolated in (False, True)
}
MOST_IN_A_RUN = 4


@dataclass
class Killed:
    """How many runs were killed, and what was wrong."""

    kills: int
    runs: int
    wrong: list[str]


def job_of(way: str) -> Job:
    """A job of both variants of a scenario with a loop, with as many checkpoints as there are windows."""
    csv, algorithm, isolated = WAYS[way]
    steps = 0.02 if isolated or algorithm == "implicit" else 0.002
    options = RunOptions(algorithm=algorithm, step_size=steps, stop_time=8.0, on_failure="explicit", isolate=isolated)
    few = {"*": 0, "plant.bit_*": 1, "law.*": 3}
    return Job(load_scenario("dissipative-law"), options, ("tracking",), Streaming(few, csv, 0.02), "dissipative-law")


def forked(work: Callable[[], None], errors: Path) -> int:
    """Do some work in a process of its own, whose number is returned."""
    child = os.fork()
    if child:
        return child
    code = 1
    try:
        os.setsid()
        logging.disable(logging.WARNING)
        work()
        code = 0
    except BaseException:
        errors.write_text(traceback.format_exc(), encoding="utf-8")
    finally:
        os._exit(code)


def ended(child: int) -> int:
    """Wait for a process; return how it ended."""
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def finished(work: Callable[[], None], errors: Path) -> float:
    """Do some work to its end in a process of its own; return how long that took."""
    began = time.monotonic()
    if ended(forked(work, errors)):
        raise AssertionError(errors.read_text(encoding="utf-8"))
    return time.monotonic() - began


def killed(job: Job, folder: Path, truth: Path, took: float, rng: random.Random, errors: Path) -> int:
    """Run a job, kill it some times, and compare it with one that was not; return how often it was killed."""
    kills = 0
    while True:
        child = forked(lambda: go_on(job, folder), errors)
        if kills < MOST_IN_A_RUN:
            time.sleep(rng.uniform(0.0, took))
            os.kill(child, signal.SIGKILL)
        code = ended(child)
        if code == -signal.SIGKILL:
            kills += 1
            continue
        if code:
            raise AssertionError(errors.read_text(encoding="utf-8"))
        finished(lambda: outcome(folder).assert_same(outcome(truth)), errors)
        return kills


def kill(count: int, seed: int, place: Path) -> Killed:
    """Kill runs in all ways by turns, until so many have died."""
    commit()  # asked for once, before processes are forked: a checkout may move on meanwhile
    rng, found, took = random.Random(seed), Killed(0, 0, []), dict[str, float]()
    names = list(WAYS)
    while found.kills < count:
        way = names[found.runs % len(names)]
        job, truth, errors = job_of(way), place / f"{way} truth", place / "errors"
        if way not in took:
            took[way] = finished(lambda job=job, truth=truth: go_on(job, truth), errors)
        folder = place / "run"
        found.runs += 1
        try:
            found.kills += killed(job, folder, truth, took[way], rng, errors)
        except AssertionError as error:
            found.wrong.append(f"{way}: {error}")
            found.kills += 1
        shutil.rmtree(folder, ignore_errors=True)
    return found


def main() -> None:
    """Kill as many as asked for, and write what came of it."""
    count, seed = int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as folder:
        tempfile.tempdir = folder
        found = kill(count, seed, Path(folder))
    sys.stdout.write("\n".join([*found.wrong, f"{found.kills} kills of {found.runs} runs, {len(found.wrong)} wrong\n"]))
    sys.exit(bool(found.wrong))


if __name__ == "__main__":
    main()
