"""Start the process of an isolated FMU and see to its end: python -m cosim.fmi2.isolation.keeper MASTER NOTE.

On Linux there are two processes. One keeps, the other works: the keeper adopts what its descendants leave behind, in
whatever session, and ends all of it with the worker or when the master is gone. It ends as the worker did, so that the
master sees what happened to the FMU. The worker dies with the keeper. Elsewhere there is the worker alone.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import time
from types import FrameType
from typing import NoReturn

from cosim.fmi2.isolation.family import Family

_DEATH_SIGNAL, _SUBREAPER = 1, 36
"""PR_SET_PDEATHSIG and PR_SET_CHILD_SUBREAPER of prctl(2)."""


_PATIENCE, _LOOK = 1.0, 0.002


class _EndError(Exception):
    """Told to end, by the master or because that is gone."""


def main() -> None:
    """Become a keeper and a worker, and work."""
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if sys.platform == "linux":
        _divide(int(sys.argv[1]))
    from cosim.fmi2.isolation.worker import work

    work(sys.argv[2])


def _divide(master: int) -> None:
    """Keep what is done after this function returned, which it does in the worker alone."""
    both = (signal.SIGTERM, signal.SIGHUP)
    signal.pthread_sigmask(signal.SIG_BLOCK, both)
    _control(_SUBREAPER, 1)
    keeper = os.getpid()
    worker = os.fork()
    if worker:
        _keep(worker, master)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, both)
    _control(_DEATH_SIGNAL, signal.SIGKILL)
    if os.getppid() != keeper:
        os._exit(1)


def _keep(worker: int, master: int) -> NoReturn:
    """Wait for the worker to end or to be ended, and end with it and all that it has left."""

    def end(number: int, _: FrameType | None) -> None:
        # SIGHUP comes when the thread that started this process ends as well
        if number == signal.SIGTERM or os.getppid() != master:
            raise _EndError

    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.dup2(nothing, 1)  # the worker's end of the channel, which is to be closed when that ends
    code = 1
    try:
        signal.signal(signal.SIGTERM, end)
        signal.signal(signal.SIGHUP, end)
        _control(_DEATH_SIGNAL, signal.SIGHUP)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGTERM, signal.SIGHUP))
        if os.getppid() == master:
            code = _ended(worker)
    except _EndError:
        pass
    signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGTERM, signal.SIGHUP))
    _end_all()
    if code < 0:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, signal.valid_signals())
        if -code not in (signal.SIGKILL, signal.SIGSTOP):
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    os._exit(code if code >= 0 else 1)


def _ended(worker: int) -> int:
    """Wait for the worker, and bury others meanwhile; return its exit code, a signal negative."""
    while True:
        process, status = os.waitpid(-1, 0)
        if process == worker and not os.WIFSTOPPED(status):  # which one that asks to be traced is at times
            return os.waitstatus_to_exitcode(status)


def _end_all() -> None:
    """End all descendants and bury them, until there are none."""
    family = Family(os.getpid())
    while True:
        family.end(_PATIENCE)
        try:
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        except ChildProcessError:
            return
        time.sleep(_LOOK)


def _control(what: int, value: int) -> None:
    """Call prctl(2) for this process."""
    ctypes.CDLL(None).prctl(ctypes.c_int(what), ctypes.c_ulong(value), 0, 0, 0)


if __name__ == "__main__":
    main()
