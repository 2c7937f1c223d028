"""The library of the master's step loop for every platform, as a wheel brings it."""

from __future__ import annotations

import hashlib
from pathlib import Path

from .. import project
from .native import TARGETS, compile_library

SOURCE = project.ROOT / "cosim" / "master" / "native" / "step_loop.c"

# What a platform is called by an importer that asks where it runs (FMI 3.0, section 2.5.1.4.1).
_TUPLES = {
    "linux64": "x86_64-linux",
    "aarch64-linux": "aarch64-linux",
    "win64": "x86_64-windows",
    "darwin64": "x86_64-darwin",
    "aarch64-darwin": "aarch64-darwin",
}


def build_step_loops(folder: Path) -> list[Path]:
    """Compile the step loop for all targets into a folder; return the paths of the libraries.

    Each is named by what it is made from and where it runs, and has its SHA-256 beside it, so that none is loaded that
    is another version's or damaged.

    Raises
    ------
    BuildError
        With the compiler's messages.
    """
    source = SOURCE.read_bytes()
    folder.mkdir(parents=True)
    paths: list[Path] = []
    for target in TARGETS:
        library = compile_library("step_loop", {"step_loop.c": source}, target)
        name = f"step_loop-{hashlib.sha256(source).hexdigest()[:16]}-{_TUPLES[target.folder]}{target.extension}"
        path = folder / name
        path.write_bytes(library)
        path.with_name(f"{name}.sha256").write_text(f"{hashlib.sha256(library).hexdigest()}\n", encoding="utf-8")
        paths.append(path)
    return paths
