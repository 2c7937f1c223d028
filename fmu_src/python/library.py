"""Two faults in the library that pythonfmu 0.7.0 puts into an FMU, and how the process survives them."""

from __future__ import annotations

import atexit
import ctypes
import sys
from pathlib import Path
from typing import Any

_held: dict[str, ctypes.CDLL] = {}


def keep(namespace: dict[str, Any]) -> None:
    """Keep the namespace of the main script alive; the script calls this each time it is run.

    The library runs the script once to import it and once for every instance, and with every instance gives up a
    reference to the namespace that it does not own. Without one more to give up, the second instance of a script
    that defines nothing of its own finds the namespace destroyed. So this adds a reference that nobody owns: one
    held in a list would be given up twice, the second time at the end of the process.
    """
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(namespace))


def hold(resources: str | None, model: str) -> None:
    """Keep the library of an FMU loaded, and let go of its interpreter before it is unloaded at the end.

    When the library is unloaded, on Linux, its `finalizePythonInterpreter` lowers the count of an object that has
    just been freed. Where that memory is in use again, the C library finds its heap corrupted and aborts. Called
    once before, it leaves nothing to lower. An importer that is no Python process is left alone: there the library
    owns the interpreter.
    """
    if resources is None or not sys.platform.startswith("linux") or not sys.orig_argv:
        return
    for path in sorted(Path(resources).parent.glob(f"binaries/*linux*/{model}.so")):
        if str(path) not in _held:
            _held[str(path)] = ctypes.CDLL(str(path))


@atexit.register
def _release() -> None:
    for library in _held.values():
        library.finalizePythonInterpreter()
