"""Number and kind of workers change no bit, and a worker that dies costs nothing that is done."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cosim import InputError, RunError, open_sweep, sweep
from cosim.sweeps.workers import crew, dispatch
from tests.cosim.sweeps.measuring import Deadly, Hungry, Last
from tests.cosim.sweeps.test_store import content

ROOT = Path(__file__).parents[3]
GRID = {"plant.Omega": "4:16:13", "plant.WOB": "2e4:1e5:3"}


def run(path: Path, **changes: Any) -> Any:
    given: dict[str, Any] = {"grid": GRID, "measures": Last(), "workers": 2, "stop_time": 6.0, **changes}
    return sweep("stick-slip", path, **given)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of sweeps that this process has run alone, by branch."""
    folder = tmp_path_factory.mktemp("whole")
    for branch in ("rest", "down"):
        run(folder / branch, branch=branch, workers=1)
    return folder


def test_workers_of_any_executor_find_the_same_bits(tmp_path: Path, whole: Path) -> None:
    folder = os.getcwd()
    with ThreadPoolExecutor(2) as executor:
        run(tmp_path / "s.zarr", executor=(executor, 2))
    assert content(tmp_path / "s.zarr") == content(whole / "rest")
    # which several threads have had to do with at once
    assert (os.getcwd(), logging.root.manager.disable) == (folder, 0)


def test_too_little_memory_at_a_point_is_its_message(tmp_path: Path, whole: Path) -> None:
    found = run(tmp_path / "s.zarr", measures=Hungry(slower=0.05), workers=1)
    slow = open_sweep(whole / "rest")["bit_speed"].values < 0.05
    assert 0 < slow.sum() < slow.size
    assert (found["failed"].values == slow).all()
    assert set(found["message"].values[slow]) == {"there is not enough memory"}


@pytest.mark.slow
@pytest.mark.parametrize("branch", ["rest", "down"])
def test_processes_find_the_same_bits(tmp_path: Path, whole: Path, branch: str) -> None:
    run(tmp_path / "s.zarr", branch=branch)
    assert content(tmp_path / "s.zarr") == content(whole / branch)


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_nothing(tmp_path: Path, whole: Path) -> None:
    found = run(tmp_path / "s.zarr", measures=Deadly(slower=0.05, mark=tmp_path / "killed"))
    assert (tmp_path / "killed").exists()
    assert not found["failed"].values.any()
    assert (found["energy"].values == open_sweep(whole / "rest")["energy"].values).all()


@pytest.mark.slow
def test_a_point_that_kills_its_worker_fails_and_the_rest_goes_on(tmp_path: Path, whole: Path) -> None:
    grid = {"plant.Omega": [4.0, 10.0, 12.0, 14.0, 16.0], "plant.WOB": [1e5]}
    found = run(tmp_path / "s.zarr", grid=grid, measures=Deadly(slower=0.05))
    energy = open_sweep(whole / "rest")["energy"].sel({"plant.Omega": grid["plant.Omega"], "plant.WOB": [1e5]}).values
    slow = open_sweep(whole / "rest")["bit_speed"].sel({"plant.Omega": grid["plant.Omega"], "plant.WOB": [1e5]}) < 0.05
    assert 0 < int(slow.sum()) < slow.size
    assert (found["failed"].values == slow.values).all()
    assert (found["energy"].values[~slow.values] == energy[~slow.values]).all()
    assert all(text.startswith("a worker process died of it: ") for text in found["message"].values[slow.values])


class Broken(ThreadPoolExecutor):
    """Lose all that is handed in."""

    def submit(self, *args: Any, **kwargs: Any) -> Any:
        raise crew.BrokenExecutor("the machine is gone")


def test_an_executor_that_breaks_ends_the_sweep_with_a_sentence(tmp_path: Path, whole: Path) -> None:
    with Broken(1) as executor, pytest.raises(RunError, match=r"^the executor is broken: the machine is gone$"):
        run(tmp_path / "s.zarr", executor=(executor, 1))
    assert np.isnan(open_sweep(tmp_path / "s.zarr")["failed"].values).all()
    run(tmp_path / "s.zarr", workers=1)
    assert content(tmp_path / "s.zarr") == content(whole / "rest")


def test_a_number_of_workers_that_makes_no_sense_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^-1 workers were asked for; expected 0, for one on each p"):
        run(tmp_path / "s.zarr", workers=-1)


def free_port() -> int:
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        return listening.getsockname()[1]


@pytest.mark.slow
@pytest.mark.parametrize("address", ["tcp://127.0.0.1:{port}", "nonsense://x", "tcp://no.such.host.invalid:1"])
def test_a_scheduler_that_is_not_there_is_named(tmp_path: Path, address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crew, "PATIENCE", 0.5)
    address = address.format(port=free_port())
    with pytest.raises(InputError) as refused:
        run(tmp_path / "s.zarr", scheduler=address)
    assert str(refused.value).startswith(f"{address}: no Dask scheduler answers there: ")


@contextmanager
def started(*arguments: str, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Run a part of Dask, as one would by hand."""
    command = [sys.executable, "-m", "dask", *arguments, "--no-dashboard"]
    with open(folder / f"{arguments[0]}-{time.monotonic_ns()}.log", "wb") as log:
        process = subprocess.Popen(
            command, stdout=log, stderr=log, cwd=folder, env=os.environ | {"PYTHONPATH": str(ROOT)}
        )
        try:
            yield process
        finally:
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """Give the address of a scheduler on loopback, and its two workers."""
    folder = tmp_path_factory.mktemp("dask")
    address = f"tcp://127.0.0.1:{free_port()}"
    with ExitStack() as stack:
        port = address.rpartition(":")[2]
        stack.enter_context(started("scheduler", "--host", "127.0.0.1", "--port", port, folder=folder))
        worker = ("worker", address, "--nthreads", "1", "--no-nanny", "--local-directory", str(folder))
        yield address, [stack.enter_context(started(*worker, folder=folder)) for _ in range(2)]


def wait_for_workers(address: str, count: int) -> None:
    from distributed import Client

    with Client(address, timeout=60, set_as_default=False) as client:
        client.wait_for_workers(count, timeout=60)


@pytest.mark.slow
def test_a_cluster_finds_the_same_bits_and_a_worker_that_is_killed_costs_nothing(
    tmp_path: Path, whole: Path, cluster: tuple[str, list[subprocess.Popen[bytes]]], monkeypatch: pytest.MonkeyPatch
) -> None:
    address, workers = cluster
    wait_for_workers(address, 2)
    run(tmp_path / "s.zarr", scheduler=address)
    assert content(tmp_path / "s.zarr") == content(whole / "rest")

    monkeypatch.setattr(dispatch, "TARGET", 0.0)  # one by one, so that there is time to kill
    killed = threading.Event()

    def kill(said: str, part: float) -> None:
        if part > 0.3 and not killed.is_set():
            killed.set()
            os.kill(workers[0].pid, signal.SIGKILL)

    run(tmp_path / "again.zarr", scheduler=address, progress=kill)
    assert killed.is_set()
    assert content(tmp_path / "again.zarr") == content(whole / "rest")


class Torn(crew.Here):
    """Lose the third reply as the executor of a cluster does whose worker dies meanwhile."""

    count = 0

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
        future = super().submit(fn, *args, **kwargs)
        self.count += 1
        return torn(future.result()) if self.count == 3 else future


def torn(reply: Any) -> Future[Any]:
    """Hand a reply on as Dask does, whose worker is gone by the time it looks."""
    from distributed.cfexecutor import _cascade_future

    async def fetched(*, raiseit: bool) -> Any:
        assert not raiseit
        return reply

    async def hand_on() -> None:
        await _cascade_future(SimpleNamespace(_result=fetched, status="lost"), future)

    future = Future[Any]()
    asyncio.run(hand_on())
    return future


def test_a_reply_whose_worker_is_gone_before_it_is_looked_at_comes_again(
    tmp_path: Path, whole: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    @contextmanager
    def cluster(address: str) -> Iterator[crew.Crew]:
        yield crew.Crew(Torn(), 1, is_torn=crew.reply_was_torn, outlives=True, where=f"a worker of {address}")

    monkeypatch.setattr(crew, "dask_cluster", cluster)
    monkeypatch.setattr(dispatch, "TARGET", 0.0)
    run(tmp_path / "s.zarr", scheduler="here")
    assert content(tmp_path / "s.zarr") == content(whole / "rest")


@pytest.mark.slow
def test_a_cluster_of_another_version_is_refused(
    tmp_path: Path, cluster: tuple[str, list[subprocess.Popen[bytes]]], monkeypatch: pytest.MonkeyPatch
) -> None:
    wait_for_workers(cluster[0], 1)
    monkeypatch.setattr(crew, "versions", lambda: {"drillstring-cosim": "9.9"})
    with pytest.raises(InputError, match=r"drillstring-cosim is \S+ at tcp://\S+, and 9\.9 here; expected the same$"):
        run(tmp_path / "s.zarr", scheduler=cluster[0])


def run_script(folder: Path, text: str) -> subprocess.CompletedProcess[str]:
    (folder / "script.py").write_text(text)
    command = [sys.executable, "script.py"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=240)


@pytest.mark.slow
def test_workers_do_not_run_the_script_of_the_sweep_again(tmp_path: Path) -> None:
    text = """
import cosim
print("begun")
found = cosim.sweep("stick-slip", "s.zarr", grid={"plant.WOB": [1e4, 2e4]}, stop_time=20.0, workers=2)
print(found["failed"].values)
"""
    done = run_script(tmp_path, text)
    assert (done.returncode, done.stdout, done.stderr) == (0, "begun\n[0. 0.]\n", "")


OF_ITS_OWN = """
import cosim

def weight(bit_speed: float) -> float:
    return 2e4 + abs(bit_speed)

if {condition}:
    grid = {{"plant.Omega": [8.0, 9.0]}}
    found = cosim.sweep("wob-law", "s.zarr", grid=grid, components={{"law": weight}}, stop_time=20.0, workers=2)
    print(found["failed"].values)
"""


@pytest.mark.slow
def test_workers_import_a_script_whose_functions_they_call(tmp_path: Path) -> None:
    done = run_script(tmp_path, OF_ITS_OWN.format(condition='__name__ == "__main__"'))
    assert (done.returncode, done.stdout, done.stderr) == (0, "[0. 0.]\n", "")


@pytest.mark.slow
def test_workers_that_cannot_even_start_end_the_sweep(tmp_path: Path) -> None:
    done = run_script(tmp_path, OF_ITS_OWN.format(condition="True"))  # each worker would run the sweep anew
    assert done.returncode == 1
    *others, last = done.stderr.splitlines()
    assert last.startswith("cosim.errors.RunError: a worker process cannot start: A process in the process pool was")
    assert last.endswith(
        "; workers import the script whose functions they are to call; expected all else that it does under "
        'if __name__ == "__main__":, or the functions in a module of their own'
    )
    assert done.stderr.count("Traceback") == 1
    assert any(line.startswith("error: workers import the script") for line in others)
    assert np.isnan(open_sweep(tmp_path / "s.zarr")["failed"].values).all()
