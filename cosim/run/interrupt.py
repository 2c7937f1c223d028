"""Ctrl-C and a request to terminate, taken between steps.

An FMU may run Python of its own, which would swallow a KeyboardInterrupt raised within it and report a failed step
instead. So the signal is only noted, and the run is left at the next report of progress.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Generator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def interruptible(*, to_the_end: bool = True) -> Generator[Callable[[], None]]:
    """Note SIGINT and SIGTERM while the block runs; a second one acts at once.

    Parameters
    ----------
    to_the_end : bool
        Raise KeyboardInterrupt at the end of the block as well, for a signal since the last look.

    Yields
    ------
    callable
        To be called now and then; raises KeyboardInterrupt if there was a signal.
    """
    noted: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        del frame
        if noted:
            raise KeyboardInterrupt
        noted.append(number)

    def check() -> None:
        if noted:
            raise KeyboardInterrupt

    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield check
        if to_the_end:
            check()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
