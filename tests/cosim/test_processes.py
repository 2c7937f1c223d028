"""Processes that share work end with the one that has started them, however that ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BEGIN = """
import os, signal, threading, time
from cosim.processes import end_pool, processors, without_main, worker_pool

signal.signal(signal.SIGINT, signal.default_int_handler)
pool = worker_pool(1)
with without_main():
    print(pool.submit(os.getpid).result(), flush=True)
"""
INTERRUPTED = """
wait = pool.shutdown

def shutdown(**how):
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    wait(**how)

pool.shutdown = shutdown
pool.submit(exec, "import pathlib, time; pathlib.Path('begun').touch(); time.sleep(60)")
while not os.path.exists("begun"):
    time.sleep(0.05)
"""


def run_script(folder: Path, text: str) -> subprocess.CompletedProcess[str]:
    (folder / "script.py").write_text(text)
    command = [sys.executable, "script.py"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=50)


def is_gone(pid: int) -> bool:
    """Wait up to ten seconds for the end of a process."""
    for _ in range(100):
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL")
def test_workers_end_with_a_parent_that_is_killed(tmp_path: Path) -> None:
    done = run_script(tmp_path, f"{BEGIN}os.kill(os.getpid(), signal.SIGKILL)\n")
    assert done.returncode == -signal.SIGKILL
    assert is_gone(int(done.stdout))


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no SIGINT to a single process")
def test_an_interrupt_while_workers_are_waited_for_ends_them(tmp_path: Path) -> None:
    done = run_script(tmp_path, f"{BEGIN}{INTERRUPTED}end_pool(pool)\n")  # which would wait for a minute
    assert done.stderr.splitlines()[-1] == "KeyboardInterrupt"
    assert is_gone(int(done.stdout))


@pytest.mark.skipif(sys.platform == "win32", reason="Windows sends no SIGINT to a single process")
def test_a_second_interrupt_leaves_the_first_its_say(tmp_path: Path) -> None:
    text = f"""{BEGIN}{INTERRUPTED}
try:
    try:
        raise KeyboardInterrupt("the first")
    finally:
        end_pool(pool)
except KeyboardInterrupt as error:
    print(error)
"""
    done = run_script(tmp_path, text)
    assert (done.returncode, done.stdout.splitlines()[1:], done.stderr) == (0, ["the first"], "")


def test_a_daemon_is_told_that_it_may_start_no_workers(tmp_path: Path) -> None:
    text = """
import multiprocessing
from cosim.errors import InputError
from cosim.processes import processors, worker_pool

def told(workers):
    try:
        worker_pool(workers)
    except InputError as error:
        return processors(), str(error)

if __name__ == "__main__":
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        print(*pool.apply(told, (3,)), sep=": ")
"""
    done = run_script(tmp_path, text)
    assert done.stdout == (
        "1: 3 workers are to start in a process that is a daemon of multiprocessing, as those of a Pool are, and may "
        "start none; expected 1 worker, or a concurrent.futures.ProcessPoolExecutor around it\n"
    )
