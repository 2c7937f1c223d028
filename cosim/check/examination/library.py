"""Bind the functions of a loaded FMU so that the last one called is known even after a crash."""

from __future__ import annotations

import mmap
from collections.abc import Callable, Mapping, Sequence
from ctypes import POINTER, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from typing import Any

from cosim.system.description import Description

CO_SIMULATION = 1
ELEMENTS: Mapping[str, Any] = {"Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p}
"""The C type of the values of each base type."""

_REALS, _INTEGERS, _TEXTS, _REFERENCES = POINTER(c_double), POINTER(c_int), POINTER(c_char_p), POINTER(c_uint)
_ARRAYS: Mapping[str, Any] = {"Real": _REALS, "Integer": _INTEGERS, "Boolean": _INTEGERS, "String": _TEXTS}
_ARGUMENTS: Mapping[str, tuple[Any, ...]] = {
    "SetDebugLogging": (c_int, c_size_t, _TEXTS),
    "SetupExperiment": (c_int, c_double, c_double, c_int, c_double),
    "EnterInitializationMode": (),
    "ExitInitializationMode": (),
    "DoStep": (c_double, c_double, c_int),
    "Terminate": (),
    "Reset": (),
    "GetFMUstate": (POINTER(c_void_p),),
    "SetFMUstate": (c_void_p,),
    "FreeFMUstate": (POINTER(c_void_p),),
    "SerializedFMUstateSize": (c_void_p, POINTER(c_size_t)),
    "SerializeFMUstate": (c_void_p, c_void_p, c_size_t),
    "DeSerializeFMUstate": (c_void_p, c_size_t, POINTER(c_void_p)),
    "SetRealInputDerivatives": (_REFERENCES, c_size_t, _INTEGERS, _REALS),
    "GetRealOutputDerivatives": (_REFERENCES, c_size_t, _INTEGERS, _REALS),
    "GetDirectionalDerivative": (_REFERENCES, c_size_t, _REFERENCES, c_size_t, _REALS, _REALS),
    "GetBooleanStatus": (c_int, _INTEGERS),
    **{f"{way}{kind}": (_REFERENCES, c_size_t, array) for kind, array in _ARRAYS.items() for way in ("Get", "Set")},
}


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
        self.functions = {name: self.bind(name, types) for name, types in _ARGUMENTS.items()}
        self.instantiate = self.bind(
            "Instantiate", (c_char_p, c_int, c_char_p, c_char_p, c_void_p, c_int, c_int), c_void_p, itself=False
        )
        self.free = self.bind("FreeInstance", (), None)
        self.version = self.bind("GetVersion", (), c_char_p, itself=False)
        self.types_platform = self.bind("GetTypesPlatform", (), c_char_p, itself=False)

    def bind(self, name: str, types: Sequence[Any], result: Any = c_int, *, itself: bool = True) -> Callable[..., Any]:
        """Return a function of the library that notes its name before each call.

        Parameters
        ----------
        name : str
            Without its prefix.
        types : sequence of ctypes types
            Of the arguments but the instance.
        itself : bool
            Whether the instance comes first.
        """
        # indexing makes a new object, so that the types fmpy has given its own stay
        function = self._library[f"fmi2{name}"]
        function.argtypes = ((c_void_p,) if itself else ()) + tuple(types)
        function.restype = result
        label, mark = CallTrace.padded(f"fmi2{name}"), self._trace.mark

        def traced(*arguments: Any) -> Any:
            mark(label)
            return function(*arguments)

        return traced
