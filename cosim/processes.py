"""Start processes that share the work of this one."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Generator
from contextlib import contextmanager
from types import ModuleType

_MAIN = "__main__"
_swapping = threading.Lock()


def processors() -> int:
    """Return how many processors this process may use."""
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
