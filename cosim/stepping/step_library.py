"""The library of the step loop: C99 compiled by ziglang, as the FMUs are, when it is first needed."""

from __future__ import annotations

import ctypes
import hashlib
import logging
import os
import subprocess
import sys
import tempfile
from functools import cache
from importlib import metadata, resources
from pathlib import Path

import fmpy  # pyright: ignore[reportMissingTypeStubs]
from platformdirs import user_cache_path

log = logging.getLogger("cosim")

_FLAGS = (
    "-shared",
    "-std=c99",
    "-O2",
    "-fvisibility=hidden",
    "-fPIC",
    "-g0",
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Werror",
)


@cache
def step_library() -> ctypes.CDLL | None:
    """Return the library, compiled unless a former run has done so; None, with a message, if it cannot be had.

    It is kept in the user's cache folder (on Linux $XDG_CACHE_HOME/drillstring-cosim), by what it is made from.
    """
    try:
        source = resources.files("cosim.stepping").joinpath("native", "step_loop.c").read_bytes()
        recipe = f"zig {metadata.version('ziglang')} {fmpy.platform_tuple} {_FLAGS}".encode()
        name = hashlib.sha256(recipe + source).hexdigest()[:32]
        path = user_cache_path("drillstring-cosim") / f"step_loop-{name}{fmpy.sharedLibraryExtension}"
        if not path.is_file():
            _compile(source, path)
        return ctypes.CDLL(str(path))
    except (OSError, subprocess.SubprocessError, metadata.PackageNotFoundError) as error:
        log.warning("the compiled step loop cannot be had, so steps are taken in Python: %s", _reason(error))
        return None


def _compile(source: bytes, path: Path) -> None:
    """Compile to a path; another process may do the same meanwhile."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="step_loop-", dir=path.parent) as folder:
        (Path(folder) / "step_loop.c").write_bytes(source)
        command = [sys.executable, "-m", "ziglang", "cc", *_FLAGS, "step_loop.c", "-o", path.name]
        subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True, errors="replace")
        os.replace(Path(folder) / path.name, path)


def _reason(error: Exception) -> str:
    """Return what a compiler said, or what went wrong with a file."""
    said = getattr(error, "stderr", None)
    return str(said).strip().splitlines()[0] if said else str(error)
