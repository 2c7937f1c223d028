"""Get workers: a pool of processes on this machine, a Dask cluster, or any executor that is given.

All of them are executors of the standard library to those that hand out work. What differs is how to tell that a worker
is gone, and whether there can be others in its place.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from importlib import import_module
from multiprocessing import current_process
from typing import Any

from cosim.errors import InputError, require
from cosim.processes import end_pool, processors, without_main, worker_pool
from cosim.provenance import versions
from cosim.sweeps.workers.work import BatchReply

PATIENCE = 10.0
"""Seconds to wait for an answer of a scheduler."""
_COMPARED = ("python", "dask", "distributed", "cloudpickle", "msgpack", "numpy")
_MOST_WORKERS = 4096
_UNGUARDED = (
    "workers import the script whose functions they are to call; expected all else that it does under "
    'if __name__ == "__main__":, or the functions in a module of their own'
)


@dataclass
class Crew:
    """Those who do the work.

    Attributes
    ----------
    executor : Executor
        Takes the work.
    workers : int
        How many there are.
    lost : tuple of type
        Exceptions of work whose worker is gone.
    renew : callable or None
        Returns another executor in place of one that is broken.
    came_up : callable
        Tells whether any worker has been ready for work, since the executor was got or renewed.
    is_torn : callable
        Tells of any other error whether it stands for a reply that was lost with its worker on the way.
    outlives : bool
        Whether the executor itself goes on where a worker is gone.
    where : str
        Who they are, in messages.
    advice : str
        What else is said where none of them can start.
    """

    executor: Executor
    workers: int
    lost: tuple[type[BaseException], ...] = (BrokenExecutor,)
    renew: Callable[[], Executor] | None = None
    came_up: Callable[[], bool] = lambda: True
    is_torn: Callable[[BaseException], bool] = lambda error: False
    outlives: bool = False
    where: str = "the executor"
    advice: str = ""


class Here(Executor):
    """Do all work at once, in this process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Do it."""
        future = Future[Any]()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # as any executor hands it on
            future.set_exception(error)
        return future


@contextmanager
def process_pool(workers: int, most: int, *, of_main: bool = False) -> Generator[Crew]:
    """Start processes on this machine, no more than can have work: for 0 as many as there are processors.

    1 is this process itself. Others import the script that is run, as Python's own pools do, only where what they work
    with is of it.
    """
    if not 0 <= workers <= _MOST_WORKERS:
        raise InputError(f"{workers} workers were asked for; expected 0, for one on each processor, to {_MOST_WORKERS}")
    number = max(1, min(workers or processors(), most))
    if workers == 1:
        yield Crew(Here(), 1, where="this process")
        return
    current: list[ProcessPoolExecutor] = []
    ready: list[Future[None]] = []

    def begin() -> ProcessPoolExecutor:
        for broken in current:
            broken.shutdown(wait=False, cancel_futures=True)
        with nullcontext() if of_main else without_main():
            current[:] = [worker_pool(number)]
            ready[:] = [current[0].submit(_get_ready) for _ in range(number)]
        return current[0]

    def came_up() -> bool:
        return any(each.done() and not each.cancelled() and each.exception() is None for each in ready)

    try:
        advice = f"; {_UNGUARDED}" if of_main else ""
        yield Crew(begin(), number, renew=begin, came_up=came_up, where="a worker process", advice=advice)
    finally:
        for pool in current:
            end_pool(pool)


def refuse_in_import() -> None:
    """End this process with a sentence if it is a worker that is importing the script of its parent, which sweeps."""
    if getattr(current_process(), "_inheriting", False):  # as multiprocessing itself tells
        raise SystemExit(f"error: {_UNGUARDED}")


def _get_ready() -> None:
    """Import in a worker what it works with, before there is work."""
    import_module("cosim.sweeps.workers.work")


@contextmanager
def dask_cluster(address: str) -> Generator[Crew]:
    """Join a Dask cluster.

    Raises
    ------
    InputError
        If there is no scheduler, it has no workers, or others are of other versions.
    """
    distributed = require("distributed", extra="dask", purpose="a sweep on a cluster")
    try:
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"{address}: no Dask scheduler answers there: {reason}") from error
    try:
        _refuse_others(client, address)
        threads = sum(client.nthreads().values())
        lost = (distributed.scheduler.KilledWorker,)
        executor = client.get_executor(pure=False)
        yield Crew(executor, threads, lost, is_torn=reply_was_torn, outlives=True, where=f"a worker of {address}")
    finally:
        client.close(timeout=PATIENCE)


def reply_was_torn(error: BaseException) -> bool:
    """Tell whether the worker of a reply was gone before the executor of a cluster had looked at it.

    It fetches a reply, then looks how the work went, and takes the reply for an error where that is not finished any
    more (distributed 2026.8, cfexecutor.py); taking it apart is what fails.
    """
    return isinstance(error, TypeError) and f"non-iterable {BatchReply.__name__} " in str(error)


def _refuse_others(client: Any, address: str) -> None:
    """Refuse a cluster that would not compute the same: of other packages, or of another version of this one."""
    if not client.nthreads():
        raise InputError(
            f"{address}: the scheduler has no workers; expected one at least, as of: dask worker {address}"
        )
    told: dict[str, Any] = client.get_versions(check=False)
    here = told["client"]["packages"]
    for place, found in (("the scheduler", told["scheduler"]), *told["workers"].items()):
        for name in _COMPARED:
            packages: dict[str, Any] = found["packages"] if found else {}
            there = packages.get(name)
            needed = name not in ("numpy",) or place != "the scheduler"  # which computes nothing
            if needed and _release(name, there) != _release(name, here[name]):
                raise InputError(
                    f"{address}: {name} is {there or 'missing'} at {place}, and {here[name]} here; expected the same"
                )
    ours = versions()["drillstring-cosim"]
    try:
        found = client.run(product_version)
    except Exception as error:  # whatever a worker raises that lacks the package
        raise InputError(f"{address}: workers cannot import drillstring-cosim: {error}") from error
    for place, there in found.items():
        if there != ours:
            raise InputError(f"{address}: drillstring-cosim is {there} at {place}, and {ours} here; expected the same")


def _release(name: str, version: Any) -> Any:
    """Return what of a version has to be the same."""
    return str(version).split(".")[:2] if name == "python" else version


def product_version() -> str:
    """Return the version of this package, where it is called."""
    return versions()["drillstring-cosim"]
