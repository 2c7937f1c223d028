"""Python modules that FMUs bring along, which all FMUs of a process share by name.

An FMU that runs Python (made by pythonfmu, for one) puts its resources on the path of the process's one interpreter.
Whoever imports a name first decides what every later import of it gets: two FMUs that bring different modules of one
name both run the first one's, and no call fails. So what an FMU brings is read from its archive before it is loaded.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Mapping
from pathlib import Path, PurePosixPath

from cosim.fmi2.archive import open_archive

_MARK = "resources/slavemodule.txt"
_held: dict[str, str] = {}  # by name, the digest of what this process has loaded: as global as sys.modules


def brought_modules(path: Path) -> dict[str, str]:
    """Return the digests of the Python modules and packages at the top of an FMU's resources, by name.

    Parameters
    ----------
    path : Path
        The .fmu file.

    Raises
    ------
    FmuFileError
        If it is not an archive that can safely be opened.
    """
    files: dict[str, dict[str, bytes]] = {}
    with open_archive(path) as archive:
        if _MARK not in archive.names:
            return {}
        for member in archive.names:
            parts = PurePosixPath(member).parts
            if parts[:1] == ("resources",) and len(parts) > 1 and member.endswith(".py"):
                files.setdefault(parts[1].removesuffix(".py"), {})["/".join(parts[1:])] = archive.read(member)
    return {name: _digest(content) for name, content in files.items()}


def differing_module(modules: Mapping[str, str]) -> str | None:
    """Return the first of an FMU's modules of whose name this process holds another, if there is one."""
    for name, digest in sorted(modules.items()):
        held = _held.get(name) or _imported(name)
        if held is not None and held != digest:
            return name
    return None


def hold(modules: Mapping[str, str]) -> None:
    """Take note of the modules of an FMU that is about to be loaded in this process."""
    _held.update(modules)


def _imported(name: str) -> str | None:
    """Return the digest of a module that the process has imported by itself; None if there is none with a file."""
    origin = getattr(sys.modules.get(name), "__file__", None)
    if origin is None or not origin.endswith(".py"):
        return None
    file = Path(origin)
    paths = sorted(file.parent.rglob("*.py")) if file.name == "__init__.py" else [file]
    top = file.parent.parent if file.name == "__init__.py" else file.parent
    try:
        return _digest({path.relative_to(top).as_posix(): path.read_bytes() for path in paths})
    except OSError:
        return None


def _digest(files: Mapping[str, bytes]) -> str:
    digest = hashlib.sha256()
    for name, content in sorted(files.items()):
        digest.update(f"{name}\0{len(content)}\0".encode() + content)
    return digest.hexdigest()
