"""Know a process and all that has come from it: what they hold, and how to end them.

On Linux /proc tells who descends from whom, whatever session or group they have put themselves into. Elsewhere a
process is alone, or with its session.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from contextlib import suppress
from pathlib import Path

_PROCESSES = Path("/proc")
_LOOK = 0.002
_PAGE = os.sysconf("SC_PAGE_SIZE") if sys.platform == "linux" else 0
_PARENT, _STARTED = 1, 19  # of the fields after the name of the program, by proc_pid_stat(5) the 4th and 22nd of all
LISTED = (_PROCESSES / f"self/task/{os.getpid()}/children").exists()
"""Whether the kernel lists the children of a thread, which is optional (proc_pid_task_children(5))."""


class Family:
    """A process and its descendants.

    Parameters
    ----------
    head : int
        Number of the process, which is a child of this one.
    """

    def __init__(self, head: int) -> None:
        self._head, self._began = head, _started(head)
        self._seen: dict[int, str] = {}

    def look(self) -> list[int]:
        """Return all descendants, and keep in mind who they are."""
        if not self._began or _started(self._head) != self._began:  # it has ended; its number may be another's by now
            return []
        found = _descendants(self._head)
        for process in found:
            if process not in self._seen:
                self._seen[process] = _started(process)
        return found

    def held(self) -> int:
        """Return the bytes of memory that all descendants hold; pages that several hold count for each."""
        return sum(map(_resident, self.look()))

    def shared_out(self) -> int:
        """Return the same with pages that several hold divided among them, which takes the system longer."""
        return sum(map(_proportional, self.look()))

    def end(self, patience: float) -> bool:
        """End all descendants, and those that were seen before and are nobody's any more; tell whether none is left.

        Parameters
        ----------
        patience : float
            How long to go on, as new ones may come while others end, s.
        """
        until = time.monotonic() + patience
        while found := {*self.look(), *self._left_behind()}:
            for process in found:
                with suppress(ProcessLookupError, PermissionError):
                    os.kill(process, signal.SIGKILL)
            if time.monotonic() > until:
                return False
            time.sleep(_LOOK)
        return True

    def _left_behind(self) -> list[int]:
        """Return who was seen before and is still there, not another of its number."""
        return [each for each, started in self._seen.items() if started and _started(each) == started]


def _descendants(process: int) -> list[int]:
    """Return the descendants of a process, but for those that have ended, from its children on; none if unknown."""
    found: list[int] = []
    ahead = _children(process)
    while ahead:
        each = ahead.pop()
        ahead += _children(each)
        if _started(each):
            found.append(each)
    return found


def end_session(process: int) -> None:
    """End a process with its session, which it has been given by `start_new_session`; by itself on Windows.

    Once the process has been waited for, its number may become another's: then only at once.
    """
    with suppress(OSError):
        if sys.platform != "win32":
            os.killpg(process, signal.SIGKILL)
        else:
            os.kill(process, signal.SIGTERM)


def _children(process: int) -> list[int]:
    """Return the children of all threads of a process, or of the process where the kernel lists none for threads."""
    found: list[int] = []
    if not LISTED:
        numbers = (int(entry.name) for entry in _PROCESSES.iterdir() if entry.name.isdecimal())
        return [number for number in numbers if _fields(number)[_PARENT : _PARENT + 1] == [str(process)]]
    with suppress(OSError):
        for thread in (_PROCESSES / str(process) / "task").iterdir():
            with suppress(OSError):
                found += map(int, (thread / "children").read_text().split())
    return found


def _fields(process: int) -> list[str]:
    """Return what proc_pid_stat(5) lists after the name of the program, which may hold anything."""
    try:
        return (_PROCESSES / str(process) / "stat").read_bytes().rpartition(b")")[2].decode().split()
    except OSError:
        return []


def _started(process: int) -> str:
    """Return when a process started, by which it is told from a later one of its number; nothing if it has ended."""
    fields = _fields(process)
    return fields[_STARTED] if len(fields) > _STARTED and fields[0] not in "ZX" else ""


def _resident(process: int) -> int:
    try:
        return int((_PROCESSES / str(process) / "statm").read_text().split()[1]) * _PAGE
    except (OSError, IndexError):
        return 0


def _proportional(process: int) -> int:
    try:
        text = (_PROCESSES / str(process) / "smaps_rollup").read_text()
    except OSError:
        return _resident(process)
    return sum(1024 * int(line.split()[1]) for line in text.splitlines() if line.startswith("Pss:"))
