"""Start processes that share the work of this one."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Generator
from contextlib import contextmanager
from types import ModuleType
from typing import TYPE_CHECKING

from cosim.errors import InputError

if TYPE_CHECKING:
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing.process import BaseProcess

_MAIN = "__main__"
_swapping = threading.Lock()


def processors() -> int:
    """Return how many processors this process may use: one where it may not start others, as workers of a `Pool`."""
    if _is_daemon():
        return 1
    allowed = getattr(os, "sched_getaffinity", None)
    return len(allowed(0)) if allowed is not None else os.cpu_count() or 1


def is_of_main(content: bytes) -> bool:
    """Tell whether something that is pickled needs the script that is run; at times it says so of what does not."""
    return _MAIN.encode() in content


@contextmanager
def without_main() -> Generator[None]:
    """Let processes that `multiprocessing` starts meanwhile not import the script that is run.

    It may not be made for that: without ``if __name__ == "__main__":`` it does in each of them what it does here.
    """
    with _swapping:
        script = sys.modules[_MAIN]
        sys.modules[_MAIN] = ModuleType(_MAIN)
        try:
            yield
        finally:
            sys.modules[_MAIN] = script


def worker_pool(workers: int) -> ProcessPoolExecutor:
    """Return a pool of processes that leave signals from the keyboard to this one, and end with it if it is killed.

    Raises
    ------
    InputError
        If this process may have none, which `multiprocessing` calls a daemon.
    """
    # not at the top: most of those that import this module start no processes
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    if _is_daemon():
        raise InputError(
            f"{workers} workers are to start in a process that is a daemon of multiprocessing, as those of a Pool are, "
            "and may start none; expected 1 worker, or a concurrent.futures.ProcessPoolExecutor around it"
        )
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_begin_to_work)


def end_pool(pool: ProcessPoolExecutor) -> None:
    """End processes when they are done with what is under way; interrupted meanwhile, at once.

    What ends for an interrupt already goes on with that one, which may have more to say.
    """
    started: dict[int, BaseProcess] = dict(getattr(pool, "_processes", None) or {})
    try:
        pool.shutdown(cancel_futures=True)
    except KeyboardInterrupt as error:
        # Python 3.11 takes the thread that ends them for over now, and would wait for them for ever at its end
        for each in started.values():
            each.kill()
        if not isinstance(error.__context__, KeyboardInterrupt):
            raise


def _is_daemon() -> bool:
    """Tell whether this process is a worker that may have no workers."""
    from multiprocessing import current_process

    return current_process().daemon


def _begin_to_work() -> None:
    """Let the parent decide what becomes of Ctrl-C, which a terminal sends to its workers too; and end with it."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """Wait for the end of the process that has this one: what waits for work from it would wait for ever."""
    from multiprocessing import parent_process

    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
