"""FMU log messages, carried to Python logging and kept for the sentence an error becomes.

fmpy's native helper, which fills in the printf arguments that ctypes cannot receive, remembers one callback for the
whole process. So there is one callback here, and it tells instances apart by the component environment, which the FMU
hands back with each message.
"""

from __future__ import annotations

import ctypes
import itertools
import logging
import re
from collections import deque
from typing import Any

import fmpy  # pyright: ignore[reportMissingTypeStubs]
import fmpy.fmi2 as fmi2  # pyright: ignore[reportMissingTypeStubs]

from cosim.fmi2.functions import DISCARD

_LEVELS = (logging.DEBUG, logging.WARNING, logging.WARNING, logging.ERROR, logging.CRITICAL, logging.INFO)
_journals: dict[int, Journal] = {}
_keys = itertools.count(1)


class Journal:
    """The messages of one FMU instance.

    Parameters
    ----------
    instance : str
        Its name; messages go to the logger ``cosim.fmi2.<instance>``.

    Attributes
    ----------
    callbacks : fmpy.fmi2.fmi2CallbackFunctions
        To instantiate with; must live as long as the instance.
    """

    def __init__(self, instance: str) -> None:
        self.logger = logging.getLogger(f"cosim.fmi2.{instance}")
        self._instance = instance
        self._failures: deque[str] = deque(maxlen=5)
        self._key = next(_keys)
        _journals[self._key] = self
        self.callbacks: Any = fmi2.fmi2CallbackFunctions()
        self.callbacks.logger = _callback
        self.callbacks.allocateMemory = fmi2.defaultCallbacks.allocateMemory
        self.callbacks.freeMemory = fmi2.defaultCallbacks.freeMemory
        self.callbacks.componentEnvironment = self._key
        _fill_in_arguments(self.callbacks)

    def take(self, status: int, category: str, message: str) -> None:
        """Log one message, and keep it if it says why a call fails."""
        level = _LEVELS[status] if 0 <= status < len(_LEVELS) else logging.ERROR
        says_why = status >= DISCARD
        self.logger.log(level, "%s", message, extra={"category": category, "says_why": says_why})
        if says_why:
            self._failures.append(message)

    def failure(self) -> str:
        """Return the messages that came with failures, in one line, without instance and time, which the error adds."""
        heading = re.compile(rf"{re.escape(self._instance)} at t = \S+ s: ")
        messages = (heading.sub("", " ".join(message.split()), count=1) for message in self._failures)
        return "; ".join(dict.fromkeys(messages))

    def forget(self) -> None:
        """Drop what was said about failures; the calls that failed have been undone."""
        self._failures.clear()

    def close(self) -> None:
        """Receive no more."""
        _journals.pop(self._key, None)


def _receive(environment: int | None, name: bytes, status: int, category: bytes, message: bytes) -> None:
    """Pass a message from an FMU to the journal of its instance."""
    text = (message or b"").decode("utf-8", "replace").strip()
    journal = _journals.get(environment or 0)
    if journal is None:
        logging.getLogger("cosim.fmi2").warning("%s: %s", (name or b"").decode("utf-8", "replace"), text)
        return
    journal.take(status, (category or b"").decode("utf-8", "replace"), text)


_callback: Any = fmi2.fmi2CallbackLoggerTYPE(_receive)


def _fill_in_arguments(callbacks: Any) -> None:
    """Put fmpy's native helper before the callback, where there is one for this platform."""
    try:
        from fmpy.logging import addLoggerProxy  # pyright: ignore[reportMissingTypeStubs, reportUnknownVariableType]
    except (ImportError, OSError):
        logging.getLogger("cosim").debug("no helper for log messages on %s", fmpy.platform_tuple)
        return
    addLoggerProxy(ctypes.byref(callbacks))
