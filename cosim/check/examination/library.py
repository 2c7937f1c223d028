"""The functions of a loaded FMU, bound so that the last one called is known even after a crash."""

from __future__ import annotations

import mmap
from collections.abc import Callable
from pathlib import Path
from typing import Any

from cosim.fmi2.functions import CALLS, bind
from cosim.system.description import Description


class CallTrace:
    """The name of the last function called, in a file that survives a crash of this process.

    Parameters
    ----------
    path : Path
        The file; it is made.
    """

    _LENGTH = 64

    def __init__(self, path: Path) -> None:
        path.write_bytes(bytes(self._LENGTH))
        with path.open("r+b") as file:
            self._memory = mmap.mmap(file.fileno(), self._LENGTH)

    def mark(self, name: bytes) -> None:
        """Note a function, its name padded by `padded`."""
        self._memory[:] = name

    @classmethod
    def padded(cls, name: str) -> bytes:
        """Return a name as `mark` takes it."""
        return name.encode()[: cls._LENGTH].ljust(cls._LENGTH, b"\0")

    @staticmethod
    def read(path: Path) -> str:
        """Return the function noted last; empty if there is none."""
        return path.read_bytes().rstrip(b"\0").decode() if path.is_file() else ""


class Library:
    """The functions of a loaded FMU.

    Parameters
    ----------
    loaded : fmpy.fmi2.FMU2Slave
        From `cosim.fmi2.library.loaded_fmu`.
    description : Description
        Of the FMU.
    trace : CallTrace
        Told of every call.
    """

    def __init__(self, loaded: Any, description: Description, trace: CallTrace) -> None:
        self.description = description
        self.folder = str(loaded.unzipDirectory)
        self._library = loaded.dll
        self._trace = trace
        self.functions = {name: self._traced(name) for name in CALLS}
        self.instantiate = self._traced("Instantiate")
        self.free = self._traced("FreeInstance")
        self.version = self._traced("GetVersion")
        self.types_platform = self._traced("GetTypesPlatform")

    def _traced(self, name: str) -> Callable[..., Any]:
        """Return a function of the library that notes its name before each call."""
        function = bind(self._library, name)
        label, mark = CallTrace.padded(f"fmi2{name}"), self._trace.mark

        def traced(*arguments: Any) -> Any:
            mark(label)
            return function(*arguments)

        return traced
