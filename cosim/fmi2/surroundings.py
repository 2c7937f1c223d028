"""Keep what all FMUs of a process share as it was: an FMU that changes it would change other FMUs' numbers.

That is the mode of floating-point arithmetic (rounding, subnormal numbers), which libraries that were compiled for
speed change as they are loaded; the handling of signals, by which a run is interrupted; the working folder; and the
locale, by which numbers are read and written. It is compared when FMUs have had their turn, put back where it differs,
and said.
"""

from __future__ import annotations

import ctypes
import locale
import logging
import os
import platform
import signal
import sys
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

log = logging.getLogger("cosim.surroundings")

_SIGNALS = [
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGPIPE", "SIGCHLD")
    if hasattr(signal, name)
]
"""Those by which a run is ended or processes are waited for. Others belong to the runtimes that FMUs bring: Java and
Go need theirs for memory faults."""

_ROOM = 256
"""Bytes, more than fenv_t and struct sigaction take anywhere."""

_CONTROL: Mapping[tuple[str, str], tuple[tuple[int, int, int], ...]] = {
    ("linux", "x86_64"): ((0, 2, 0x0F3F), (28, 4, 0xFFC0)),
    ("linux", "aarch64"): ((0, 4, 0xFFFFFFFF),),
    ("darwin", "x86_64"): ((0, 2, 0x0F3F), (4, 4, 0xFFC0)),
    ("darwin", "arm64"): ((8, 8, 0xFFFFFFFF),),
    ("win32", "AMD64"): ((0, 4, 0xFFFFFFFF),),
    ("win32", "ARM64"): ((0, 4, 0xFFFFFFFF),),
}
"""Where in fenv_t the modes are, apart from the flags that any operation may raise: offset, bytes, mask."""

_C: Any = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
_MODES = _CONTROL.get((sys.platform, platform.machine())) if hasattr(_C, "fegetenv") else None
_POINTER = ctypes.sizeof(ctypes.c_void_p)

_Reading = tuple[object, Callable[[], object]]
"""What something is, and how to make it so again."""


class Surroundings:
    """Keep what FMUs of this process share as it was before their turn.

    Parameters
    ----------
    who : str
        Takes turns, for the log.
    """

    def __init__(self, who: str) -> None:
        self._who = who
        self._said: set[str] = set()
        self._undisturbed = False
        self._known: dict[str, _Reading] | None = None

    @contextmanager
    def undisturbed(self) -> Generator[None]:
        """Have turns follow each other with nothing between that changes anything, so that it is read once a turn."""
        self._undisturbed = True
        try:
            yield
        finally:
            self._undisturbed, self._known = False, None

    @contextmanager
    def kept(self, when: str | Callable[[], str]) -> Generator[None]:
        """Put back, after a turn, what is not as it was before; say so the first time, and when that was."""
        before = self._known or _read()
        try:
            yield
        finally:
            now = _read()
            self._known = before if self._undisturbed else None
            changed = [name for name, (what, _) in before.items() if now[name][0] != what]
            for name in changed:
                with suppress(OSError, ValueError, locale.Error):
                    before[name][1]()
            self._say([name for name in changed if name not in self._said], when)

    def _say(self, changed: list[str], when: str | Callable[[], str]) -> None:
        self._said.update(changed)
        if changed:
            log.warning(
                "%s changed %s of this process %s; it has been put back, but what others computed there meanwhile may "
                "be off; in a process of its own (isolate) an FMU changes nothing here",
                self._who,
                " and ".join(changed),
                when if isinstance(when, str) else when(),
            )


def _read() -> dict[str, _Reading]:
    """Read all that is kept, by names that end a sentence."""
    readings = {"the working folder": _folder(), "the locale": _locale()}
    if _MODES is not None:
        readings["the mode of floating-point arithmetic"] = _arithmetic(_MODES)
    if sys.platform != "win32":
        readings["the handling of signals"] = _handling()
        readings["which signals are blocked"] = _blocked()
    return readings


def _folder() -> _Reading:
    try:
        folder = os.getcwd()
    except OSError:  # it has been removed
        return None, lambda: None
    return folder, partial(os.chdir, folder)


def _locale() -> _Reading:
    now = locale.setlocale(locale.LC_ALL)
    return now, partial(locale.setlocale, locale.LC_ALL, now)


def _arithmetic(modes: tuple[tuple[int, int, int], ...]) -> _Reading:
    environment = ctypes.create_string_buffer(_ROOM)
    _C.fegetenv(environment)
    words = [int.from_bytes(environment[at : at + size], sys.byteorder) & mask for at, size, mask in modes]
    return words, partial(_C.fesetenv, environment)


def _handling() -> _Reading:
    """Read which function handles each signal, as the system has it: Python does not notice changes made in C."""
    actions = ctypes.create_string_buffer(_ROOM * len(_SIGNALS))
    for place, number in enumerate(_SIGNALS):
        _C.sigaction(number, None, ctypes.byref(actions, _ROOM * place))

    def put_back() -> None:
        for place, number in enumerate(_SIGNALS):
            _C.sigaction(number, ctypes.byref(actions, _ROOM * place), None)

    # the function, by a pointer, is what the structure begins with
    return [actions[_ROOM * place : _ROOM * place + _POINTER] for place in range(len(_SIGNALS))], put_back


def _blocked() -> _Reading:
    if sys.platform == "win32":
        return None, lambda: None
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    return blocked, partial(signal.pthread_sigmask, signal.SIG_SETMASK, blocked)
