"""The end of a process that ran other people's code: how to bring it about, and what its exit code says."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress

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
