"""Load the library of the step loop: the one that came with the package, else C99 compiled when it is first needed."""

from __future__ import annotations

import ctypes
import hashlib
import logging
import os
import subprocess
import sys
import tempfile
from functools import cache
from importlib import metadata, util
from pathlib import Path

import fmpy  # pyright: ignore[reportMissingTypeStubs]
from platformdirs import user_cache_path

log = logging.getLogger("cosim")

_SOURCE = Path(__file__).resolve().parent / "native" / "step_loop.c"
_PACKAGED = Path(__file__).resolve().parents[1] / "built" / "step_loop"

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
def step_library() -> tuple[ctypes.CDLL | None, str]:
    """Return the library; or None, with a message, and why it cannot be had.

    A wheel brings it. Otherwise it is compiled, unless a former run has done so: it is kept in the user's cache folder
    (on Linux $XDG_CACHE_HOME/drillstring-cosim), by what it is made from. No file is loaded whose SHA-256 is not what
    stands beside it.
    """
    try:
        source = _SOURCE.read_bytes()
        packaged = _PACKAGED / _file_name(hashlib.sha256(source).hexdigest()[:16])
        if _is_whole(packaged):
            return ctypes.CDLL(str(packaged)), ""
        if util.find_spec("ziglang") is not None:
            return _cached(source), ""
        why = 'compiling it needs ziglang; pip install "drillstring-cosim[build]" brings it'
    except (OSError, subprocess.SubprocessError, metadata.PackageNotFoundError) as error:
        why = _reason(error)
    log.warning("the compiled step loop cannot be had, so steps are taken in Python: %s", why)
    return None, why


def _file_name(origin: str) -> str:
    return f"step_loop-{origin}-{fmpy.platform_tuple}{fmpy.sharedLibraryExtension}"


def _cached(source: bytes) -> ctypes.CDLL:
    """Load the library from the user's cache, compiled and put there if need be, or only used if that cannot be."""
    recipe = f"zig {metadata.version('ziglang')} {fmpy.platform_tuple} {_FLAGS}".encode()
    name = _file_name(hashlib.sha256(recipe + source).hexdigest()[:32])
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
