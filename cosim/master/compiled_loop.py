"""Take the steps of a run with known communication points in C, where every component is an FMU of this process.

The loop to read is `cosim.master.fixed_step.readable_steps`. This one lays out the same calls on the same memory for
the library of `step_library`, which walks them. It comes back to Python after each window of rows, and where a call
fails. The library is the one that came with the package, else C99 compiled when it is first needed.
"""

from __future__ import annotations

import ctypes
import hashlib
import logging
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from ctypes import POINTER, Array, Structure, byref, c_double, c_int, c_size_t, c_void_p, cast
from functools import cache
from importlib import metadata, util
from pathlib import Path
from typing import Any, TypeVar

import fmpy  # pyright: ignore[reportMissingTypeStubs]
import numpy as np
from platformdirs import user_cache_path

from cosim.errors import EndRequestError, SlaveError
from cosim.fmi2.fmu_slave import FmuSlave
from cosim.fmi2.functions import SectionExchange, SlopeExchange, StepCalls
from cosim.master.communication_points import Points
from cosim.master.slave import Slave
from cosim.master.wiring import Link, Node
from cosim.system.conversion import Conversion

_WRITE, _INPUT_SLOPES, _DO_STEP, _READ, _OUTPUT_SLOPES = range(5)
"""Phases of a step, as step_loop.c numbers them."""


class _Link(Structure):
    _fields_ = (
        ("source", c_void_p),
        ("target", c_void_p),
        ("source_stride", c_size_t),
        ("target_stride", c_size_t),
        ("size", c_size_t),
        ("lag", c_size_t),
    )


class _Conversion(Structure):
    _fields_ = (
        ("link", _Link),
        ("factor", c_double),
        ("offset", c_double),
        ("table", c_void_p),
        ("pairs", c_size_t),
    )


class _Exchange(Structure):
    _fields_ = (
        ("call", c_void_p),
        ("references", c_void_p),
        ("count", c_size_t),
        ("values", c_void_p),
        ("stride", c_size_t),
    )


class _Slopes(Structure):
    _fields_ = (
        ("call", c_void_p),
        ("references", c_void_p),
        ("count", c_size_t),
        ("orders", c_void_p),
        ("values", c_void_p),
        ("stride", c_size_t),
    )


class _Node(Structure):
    _fields_ = (
        ("component", c_void_p),
        ("do_step", c_void_p),
        ("links", POINTER(_Link)),
        ("link_count", c_size_t),
        ("conversions", POINTER(_Conversion)),
        ("conversion_count", c_size_t),
        ("writes", POINTER(_Exchange)),
        ("write_count", c_size_t),
        ("reads", POINTER(_Exchange)),
        ("read_count", c_size_t),
        ("input_slopes", POINTER(_Slopes)),
        ("output_slopes", POINTER(_Slopes)),
    )


class _Failure(Structure):
    _fields_ = (
        ("row", c_size_t),
        ("node", c_size_t),
        ("phase", c_int),
        ("index", c_size_t),
        ("status", c_int),
    )


_Item = TypeVar("_Item", bound=Structure)


class StepLoop:
    """The steps of a run, laid out for the library; for slaves that `loop_library` has a library for.

    Parameters
    ----------
    library : ctypes.CDLL
        From `loop_library`.
    nodes : sequence of Node
        Set up, in stepping order, every slave an `FmuSlave`.
    """

    def __init__(self, library: Any, nodes: Sequence[Node]) -> None:
        self._slaves = [node.slave for node in nodes if isinstance(node.slave, FmuSlave)]
        self._calls: list[StepCalls] = [slave.calls() for slave in self._slaves]
        self._keep: list[object] = []
        laid_out = [self._lay_out(node, calls) for node, calls in zip(nodes, self._calls, strict=True)]
        self._nodes = (_Node * len(nodes))(*laid_out)
        self._step_rows = library.step_rows
        self._step_rows.restype = c_int
        self._step_rows.argtypes = (c_void_p, c_size_t, c_void_p, c_void_p, c_size_t, c_size_t, c_void_p)

    def __call__(self, points: Points) -> EndRequestError | None:
        """Take the steps between communication points, which end in the rows from 1 on, but for an end in between.

        Returns
        -------
        EndRequestError or None
            What a component has asked for in the step that begins at its `time`; that step does not count.

        Raises
        ------
        SlaveError
            If a component refuses a value or a step.
        """
        failure = _Failure()
        times, sizes, last = np.ascontiguousarray(points.times), np.ascontiguousarray(points.sizes), points.sizes.size
        addresses = times.ctypes.data, sizes.ctypes.data
        if self._step_rows(self._nodes, len(self._nodes), *addresses, 1, last, byref(failure)):
            error = self._error(failure, points)
            if isinstance(error, EndRequestError):
                return error
            raise error
        for slave in self._slaves:
            slave.arrive(float(times[last - 1] + sizes[last - 1]))
        return None

    def _lay_out(self, node: Node, calls: StepCalls) -> _Node:
        """Write a component as the struct of C."""
        return _Node(
            calls.instance,
            _address(calls.do_step),
            *self._array(_Link, [_lay_out_link(link) for link in node.links]),
            *self._array(_Conversion, [self._lay_out_conversion(*each) for each in node.converted]),
            *self._array(_Exchange, [_lay_out_exchange(exchange) for exchange in calls.writes]),
            *self._array(_Exchange, [_lay_out_exchange(exchange) for exchange in calls.reads]),
            self._array(_Slopes, [_lay_out_slopes(calls.input_slopes)])[0] if calls.input_slopes else None,
            self._array(_Slopes, [_lay_out_slopes(calls.output_slopes)])[0] if calls.output_slopes else None,
        )

    def _lay_out_conversion(self, link: Link, conversion: Conversion) -> _Conversion:
        """Write a connection that converts as the struct of C."""
        numbers = (c_int * (2 * len(conversion.table)))(*(number for pair in conversion.table for number in pair))
        self._keep.append(numbers)
        table = cast(numbers, c_void_p) if conversion.table else None
        return _Conversion(_lay_out_link(link), conversion.factor, conversion.offset, table, len(conversion.table))

    def _array(self, kind: type[_Item], items: Sequence[_Item]) -> tuple[Array[_Item], int]:
        """Return an array of structs, kept alive, and its length."""
        array = (kind * len(items))(*items)
        self._keep.append(array)
        return array, len(items)

    def _error(self, failure: _Failure, points: Points) -> SlaveError:
        """Return what the slave itself would have raised."""
        node, row, phase = int(failure.node), int(failure.row), int(failure.phase)
        calls = self._calls[node]
        names = {
            _WRITE: [exchange.name for exchange in calls.writes],
            _READ: [exchange.name for exchange in calls.reads],
            _DO_STEP: ["fmi2DoStep"],
            _INPUT_SLOPES: ["fmi2SetRealInputDerivatives"],
            _OUTPUT_SLOPES: ["fmi2GetRealOutputDerivatives"],
        }[phase]
        time = float(points.times[row - 1])
        if phase > _DO_STEP:
            time += float(points.sizes[row - 1])
        slave = self._slaves[node]
        slave.arrive(time)
        name = names[int(failure.index) if len(names) > 1 else 0]
        return slave.failure(name, int(failure.status), float(points.sizes[row - 1]))


def loop_library(slaves: Mapping[str, Slave]) -> tuple[Any, str]:
    """Return the library, compiled now if need be; or None, and why steps are taken in Python."""
    foreign = [name for name, slave in slaves.items() if not isinstance(slave, FmuSlave)]
    if foreign:
        return None, f"{foreign[0]} is no FMU in this process"
    return step_library()


def _address(function: Any) -> c_void_p:
    """Return where a bound function is."""
    return cast(function, c_void_p)


def _lay_out_link(link: Link) -> _Link:
    """Write a connection as the struct of C: both ends are memory views of recordings."""
    source, source_column, target, target_column, lag = link
    ends = [(np.asarray(source), source_column), (np.asarray(target), target_column)]
    (begin, end) = (values.ctypes.data + column * values.itemsize for values, column in ends)
    strides = [values.strides[0] for values, _ in ends]
    return _Link(begin, end, *strides, ends[0][0].itemsize, lag)


def _lay_out_exchange(exchange: SectionExchange) -> _Exchange:
    """Write a getter or setter as the struct of C."""
    call = _address(exchange.function)
    return _Exchange(call, exchange.references, exchange.count, exchange.base, exchange.stride)


def _lay_out_slopes(exchange: SlopeExchange) -> _Slopes:
    """Write the setter or getter of derivatives as the struct of C."""
    call = _address(exchange.function)
    return _Slopes(call, exchange.references, exchange.count, exchange.orders, exchange.base, exchange.stride)


log = logging.getLogger("cosim")

_SOURCE = Path(__file__).resolve().parent / "native" / "step_loop.c"
PACKAGED = Path(__file__).resolve().parents[1] / "built" / "step_loop"

_FLAGS = (
    "-shared",
    "-std=c99",
    "-O2",
    "-ffp-contract=off",  # else a factor and an offset are rounded once where the processor can, and twice in Python
    "-fvisibility=hidden",
    "-fPIC",
    "-g0",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Werror",
)


@cache
def step_library() -> tuple[ctypes.CDLL | None, str]:
    """Return the library; or None, with a message, and why it cannot be had.

    A wheel brings it. Otherwise it is compiled, unless a former run has done so: it is kept in the user's cache folder
    (on Linux $XDG_CACHE_HOME/drillstring-cosim), by what it is made from. No file is loaded whose SHA-256 is not what
    stands beside it.
    """
    try:
        source = _SOURCE.read_bytes()
        packaged = PACKAGED / library_name(hashlib.sha256(source).hexdigest()[:16])
        if _is_whole(packaged):
            return ctypes.CDLL(str(packaged)), ""
        if util.find_spec("ziglang") is not None:
            return cached_library(source), ""
        why = 'compiling it needs ziglang; pip install "drillstring-cosim[build]" brings it'
    except (OSError, subprocess.SubprocessError, metadata.PackageNotFoundError) as error:
        why = _reason(error)
    log.warning("the compiled step loop cannot be had, so steps are taken in Python: %s", why)
    return None, why


def library_name(origin: str) -> str:
    """Return the file name of the step loop's library for this platform, made of a source or recipe."""
    return f"step_loop-{origin}-{fmpy.platform_tuple}{fmpy.sharedLibraryExtension}"


def cached_library(source: bytes) -> ctypes.CDLL:
    """Load the library from the user's cache, compiled and put there if need be, or only used if that cannot be."""
    recipe = f"zig {metadata.version('ziglang')} {fmpy.platform_tuple} {_FLAGS}".encode()
    name = library_name(hashlib.sha256(recipe + source).hexdigest()[:32])
    cache_folder = _cache_folder()
    path = cache_folder / name if cache_folder is not None else None
    if path is not None and _is_whole(path):
        return ctypes.CDLL(str(path))
    with tempfile.TemporaryDirectory(prefix="step_loop-", ignore_cleanup_errors=True) as folder:
        library = _compile(source, Path(folder) / name)
        if path is not None and _keep(library, path):
            return ctypes.CDLL(str(path))
        return ctypes.CDLL(str(library))


def _cache_folder() -> Path | None:
    """Return the user's cache folder; or None for a user without a home, as in a container under a number."""
    try:
        folder = user_cache_path("drillstring-cosim")
    except RuntimeError:  # platformdirs finds no home
        return None
    return folder if folder.is_absolute() else None  # by an older platformdirs, "~" below the working directory


def _is_whole(path: Path) -> bool:
    """Tell whether a library is there, and is what its SHA-256 beside it says."""
    try:
        expected = _checksum_file(path).read_text(encoding="utf-8").strip()
        return hashlib.sha256(path.read_bytes()).hexdigest() == expected
    except (OSError, UnicodeDecodeError):
        return False


def _checksum_file(path: Path) -> Path:
    return path.with_name(f"{path.name}.sha256")


def _compile(source: bytes, path: Path) -> Path:
    path.with_name("step_loop.c").write_bytes(source)
    try:
        _run_zig(path, {})
    except subprocess.CalledProcessError:
        # zig gives up where it cannot write its cache, which is in the user's home unless it is told another place.
        caches = {"ZIG_GLOBAL_CACHE_DIR": "zig-global", "ZIG_LOCAL_CACHE_DIR": "zig-local"}
        _run_zig(path, {variable: str(path.parent / folder) for variable, folder in caches.items()})
    return path


def _run_zig(path: Path, caches: dict[str, str]) -> None:
    command = [sys.executable, "-m", "ziglang", "cc", *_FLAGS, "step_loop.c", "-o", path.name]
    environment = os.environ | caches
    subprocess.run(
        command, cwd=path.parent, env=environment, check=True, capture_output=True, text=True, errors="replace"
    )


def _keep(library: Path, path: Path) -> bool:
    """Put a library into the cache, whole or not at all; return whether it is there. A full disk costs the cache only.

    Another process may do the same meanwhile, with the same bytes.
    """
    content = library.read_bytes()
    checksum = f"{hashlib.sha256(content).hexdigest()}\n".encode()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        for target, data in ((path, content), (_checksum_file(path), checksum)):
            with tempfile.TemporaryDirectory(prefix="step_loop-", dir=path.parent) as folder:
                draft = Path(folder) / target.name
                draft.write_bytes(data)
                os.replace(draft, target)
    except OSError as error:
        log.info("the compiled step loop is not kept for later runs: %s", error)
        return False
    return True


def _reason(error: Exception) -> str:
    """Return what a compiler said, or what went wrong with a file."""
    said = getattr(error, "stderr", None)
    return str(said).strip().splitlines()[0] if said else str(error)
