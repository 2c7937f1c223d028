"""Python modules that FMUs bring along, which all FMUs of a process share by name.

An FMU that runs Python (made by pythonfmu, for one) puts its resources on the path of the process's one interpreter.
Whoever imports a name first decides what every later import of it gets: two FMUs that bring different modules of one
name both run the first one's, and no call fails. So what an FMU brings is read from its archive before it is loaded.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path, PurePosixPath

from cosim.fmi2.archive import open_archive
from cosim.fmi2.unpacked import archive_digest

_MARK = "resources/slavemodule.txt"

Files = Mapping[str, str]
"""Digests of the files of a module or package, by their paths from where Python finds it."""

_held: dict[str, dict[str, str]] = {}  # by name, what FMUs have brought into this process: as global as sys.modules


def brought_modules(path: Path) -> dict[str, Files]:
    """Return the Python modules and packages at the top of an FMU's resources, by name.

    Parameters
    ----------
    path : Path
        The .fmu file.

    Raises
    ------
    FmuFileError
        If it is not an archive that can safely be opened.
    """
    return _brought(path, archive_digest(path))


@lru_cache(maxsize=256)
def _brought(path: Path, digest: bytes) -> dict[str, Files]:
    """Read the modules of a file with a content."""
    del digest
    modules: dict[str, dict[str, str]] = {}
    with open_archive(path) as archive:
        if _MARK not in archive.names:
            return {}
        for member in archive.names:
            parts = PurePosixPath(member).parts
            if parts[:1] == ("resources",) and len(parts) > 1 and member.endswith(".py"):
                files = modules.setdefault(parts[1].removesuffix(".py"), {})
                files["/".join(parts[1:])] = hashlib.sha256(archive.read(member)).hexdigest()
    return dict(modules)


def differing_module(modules: Mapping[str, Files]) -> str | None:
    """Return the first of an FMU's modules of whose name this process holds another, if there is one."""
    for name, files in sorted(modules.items()):
        held = _held.get(name) or _imported(name, files)
        if held is not None and any(held.get(file) != digest for file, digest in files.items()):
            return name
    return None


def hold(modules: Mapping[str, Files]) -> None:
    """Take note of the modules of an FMU that is about to be loaded in this process."""
    for name, files in modules.items():
        _held.setdefault(name, {}).update(files)


def _imported(name: str, files: Files) -> Files | None:
    """Return those files of a module that the process has imported by itself; None if it has none of that name."""
    origin = getattr(sys.modules.get(name), "__file__", None)
    if origin is None:
        return None
    top = Path(origin).parents[1 if Path(origin).name == "__init__.py" else 0]
    return {file: hashlib.sha256((top / file).read_bytes()).hexdigest() for file in files if (top / file).is_file()}
