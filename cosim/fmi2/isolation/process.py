"""Ask, time and end the process of an isolated FMU.

This keeps a faulty FMU from taking the master down. It is no sandbox: the process may do whatever its user may.


"""

from __future__ import annotations

import json
import mmap
import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from cosim.fmi2.isolation import Limits
from cosim.fmi2.isolation.protocol import HEADER, MOST_REPLY, REPLY, REQUEST, Operation, receive, send

START_LIMIT = 120.0
"""Seconds that Python may take to start and import what the process needs."""

_LOOK = 0.05
_FAREWELL = 5.0


class ProcessLostError(Exception):
    """The process is gone; the text says how, as the end of a sentence that begins with "the FMU"."""


@dataclass(frozen=True)
class Reply:
    """Hold an answer of the process: whether the operation failed, and what else there is to say."""

    failed: bool
    content: dict[str, Any]


class IsolatedProcess:
    """A process in which one FMU will be loaded.

    Parameters
    ----------
    folder : Path
        For all temporary files of the process; the caller removes it afterwards.
    limits : Limits
        What to allow.
    """

    def __init__(self, folder: Path, limits: Limits) -> None:
        self._limits = limits
        self._memory: mmap.mmap | None = None
        self._overdue = False
        self._deadline = time.monotonic() + START_LIMIT
        self._asked = Operation.START
        self._process = _start(folder)
        self._to, self._from = _descriptors(self._process)
        self._done = threading.Event()
        self._watch = threading.Thread(target=self._end_when_overdue, daemon=True)
        self._watch.start()

    def share(self, memory: mmap.mmap) -> None:
        """Look in this memory for what the process says it is doing."""
        self._memory = memory

    def ask(
        self, operation: Operation, *, write: int = -1, slot: int = 0, time_: float = 0.0, size: float = 0.0,
        content: dict[str, Any] | None = None,
    ) -> Reply:  # fmt: skip
        """Have an operation done, after the inputs of a row have been written if `write` is one.

        Raises
        ------
        ProcessLostError
            If the process ends instead of answering, or does not answer in time or to the point.
        """
        text = json.dumps(content).encode() if content is not None else b""
        self._asked = operation
        self._deadline = time.monotonic() + self._limits.time
        try:
            send(self._to, REQUEST.pack(operation, write, slot, time_, size, len(text)) + text)
            reply = self._reply()
        except (EOFError, OSError):
            raise ProcessLostError(self._how_it_ended()) from None
        self._deadline = float("inf")
        return reply

    def await_start(self) -> None:
        """Wait until the process can be asked; ProcessLostError if it cannot be started."""
        try:
            self._reply()
        except (EOFError, OSError):
            raise ProcessLostError(self._how_it_ended()) from None
        self._deadline = float("inf")

    def end(self) -> None:
        """End the process and whatever it has started, at once unless it is about to end by itself."""
        self._done.set()
        self._watch.join()
        for descriptor in (self._process.stdin, self._process.stdout):
            if descriptor is not None:
                descriptor.close()
        if self._asked is Operation.CLOSE:
            with suppress(subprocess.TimeoutExpired):
                self._reap(_FAREWELL)
        if self._process.returncode is None:
            end_session(self._process)
            self._reap()

    def _reply(self) -> Reply:
        failed, size = REPLY.unpack(receive(self._from, REPLY.size))
        if not size:
            return Reply(bool(failed), {})
        if size > MOST_REPLY:
            raise self._nonsense()
        try:
            content = json.loads(receive(self._from, size))
        except (ValueError, RecursionError):
            raise self._nonsense() from None
        if not isinstance(content, dict):
            raise self._nonsense()
        return Reply(bool(failed), cast(dict[str, Any], content))

    def _nonsense(self) -> ProcessLostError:
        end_session(self._process)
        return ProcessLostError(f"answered nonsense {self._asked.phrase} and was stopped")

    def _reap(self, patience: float | None = None) -> int:
        """Wait for the process to end, and at once end what it has started; TimeoutExpired if it goes on."""
        code = self._process.wait(patience)
        if sys.platform != "win32":
            end_session(self._process)
        return code

    def _end_when_overdue(self) -> None:
        while not self._done.wait(_LOOK):
            if time.monotonic() > self._deadline:
                self._overdue = True
                if self._process.returncode is None:
                    end_session(self._process)
                return

    def _how_it_ended(self) -> str:
        """Say how the process ended; one that has merely closed its pipe is ended first."""
        try:
            code = self._reap(_FAREWELL)
        except subprocess.TimeoutExpired:
            end_session(self._process)
            self._reap()
            return f"closed the pipe to the master {self._asked.phrase} and was stopped"
        doing, held = HEADER.unpack_from(self._memory) if self._memory else (self._asked, 0)
        where = (Operation(doing) if doing < len(Operation) else self._asked).phrase
        if self._overdue:
            return f"hung {where} and was stopped after {self._limits.time:g} s"
        if held:
            most = f"expected at most {self._limits.memory / 1e6:.0f} MB"
            return f"was stopped {where} because it held {held / 1e6:.0f} MB of memory; {most}"
        how = fault(code)
        return f"crashed {where} ({how})" if how else f"ended its process {where} (exit code {code})"


def _start(folder: Path) -> subprocess.Popen[bytes]:
    """Start the process, in a session of its own so that Ctrl-C reaches only the master."""
    package = str(Path(__file__).resolve().parents[3])
    paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
    temporary = dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(folder))
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "cosim.fmi2.isolation.worker"],
        bufsize=0,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, **temporary, "PYTHONPATH": os.pathsep.join(paths)},
        start_new_session=sys.platform != "win32",
        creationflags=subprocess.CREATE_NEW_PROCESS_GROUP if sys.platform == "win32" else 0,
    )


def _descriptors(process: subprocess.Popen[bytes]) -> tuple[int, int]:
    """Return where to write to a process, and where to read from it."""
    if process.stdin is None or process.stdout is None:
        raise ValueError("expected pipes")
    return process.stdin.fileno(), process.stdout.fileno()


_WINDOWS = {0xC0000005: "access violation", 0xC00000FD: "stack overflow", 0xC0000409: "stack buffer overrun"}


def end_session(process: subprocess.Popen[bytes]) -> None:
    """End a process with whatever it has started, where it was given a session of its own (not on Windows).

    Once the process has been waited for, its number may become another's: then only at once.
    """
    if sys.platform != "win32":
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()


def fault(code: int) -> str | None:
    """Name the signal or Windows exception that an exit code stands for; None if the process has ended itself."""
    if code < 0:
        names = {number.value: number.name for number in signal.Signals}
        return names.get(-code, f"signal {-code}")
    return _WINDOWS.get(code & 0xFFFFFFFF)
