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

log = logging.getLogger("cosim")

_ENVIRONMENT = 256
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

_SIGNALS = range(1, 32)
_C: Any = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)

_Reading = tuple[object, Callable[[], object]]
"""What something is, and how to make it so again."""


class Surroundings:
    """Remember what FMUs of this process and thread share, as it is now."""

    def __init__(self) -> None:
        self._said: set[str] = set()
        self._before = _read()

    def restore(self) -> list[str]:
        """Put back what differs; return what that was."""
        changed: list[str] = []
        for name, (now, _) in _read().items():
            before, put_back = self._before[name]
            if now != before:
                with suppress(OSError, ValueError, locale.Error):
                    put_back()
                changed.append(name)
        return changed

    def restore_after(self, who: str, when: str) -> None:
        """Put back what differs, and say so the first time."""
        changed = [name for name in self.restore() if name not in self._said]
        self._said.update(changed)
        if changed:
            log.warning(
                "%s changed %s of this process %s; it has been put back, and what else ran here until then may be off; "
                "in a process of its own (isolate) an FMU changes nothing here",
                who,
                " and ".join(changed),
                when,
            )


@contextmanager
def kept(name: str, when: str) -> Generator[None]:
    """Leave what FMUs share as it was, whatever the FMU of this name does meanwhile."""
    surroundings = Surroundings()
    try:
        yield
    finally:
        surroundings.restore_after(name, when)


def _read() -> dict[str, _Reading]:
    readings = {"the working folder": _folder(), "the locale": _locale()}
    if (mode := _arithmetic()) is not None:
        readings["the mode of floating-point arithmetic"] = mode
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


def _arithmetic() -> _Reading | None:
    """Read the mode of floating-point arithmetic, where it is known how that is stored."""
    fields = _CONTROL.get((sys.platform, platform.machine()))
    if fields is None or not hasattr(_C, "fegetenv"):
        return None
    environment = ctypes.create_string_buffer(_ENVIRONMENT)
    _C.fegetenv(environment)
    words = (int.from_bytes(environment[at : at + size], sys.byteorder) & mask for at, size, mask in fields)
    return tuple(words), partial(_C.fesetenv, environment)


def _handling() -> _Reading:
    """Read which function handles each signal, as the system has it: Python does not notice changes made in C."""
    actions = ctypes.create_string_buffer(_ENVIRONMENT * (_SIGNALS[-1] + 1))
    places = [(number, ctypes.addressof(actions) + _ENVIRONMENT * number) for number in _SIGNALS]
    for number, place in places:
        _C.sigaction(number, None, ctypes.c_void_p(place))

    def put_back() -> None:
        for number, _ in places:
            _C.sigaction(number, ctypes.byref(actions, _ENVIRONMENT * number), None)

    pointer = ctypes.sizeof(ctypes.c_void_p)  # to the function, which the structure begins with
    return [actions[_ENVIRONMENT * number : _ENVIRONMENT * number + pointer] for number in _SIGNALS], put_back


def _blocked() -> _Reading:
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    return blocked, partial(signal.pthread_sigmask, signal.SIG_SETMASK, blocked)
