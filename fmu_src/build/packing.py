"""From the files of an FMU to the FMU in its place: identity, archive, trial, and the move at the very end."""

from __future__ import annotations

import hashlib
import io
import os
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

from fmpy.validation import validate_fmu  # pyright: ignore[reportMissingTypeStubs]

from .. import project
from ..errors import BuildError

TRIAL = project.SOURCES / "build" / "trial.py"
TRIAL_SECONDS = 120.0
_EPOCH = (1980, 1, 1, 0, 0, 0)


def digest(files: Mapping[str, bytes]) -> str:
    """Return a hexadecimal SHA-256 over names and contents, whatever their order."""
    total = hashlib.sha256()
    for name in sorted(files):
        content = hashlib.sha256(files[name]).hexdigest()
        total.update(f"{name}\0{content}\n".encode())
    return total.hexdigest()


def guid(files: Mapping[str, bytes]) -> str:
    """Return the GUID of an FMU: a name for the content of the files it is made from."""
    text = digest(files)
    return "{" + "-".join((text[:8], text[8:12], text[12:16], text[16:20], text[20:32])) + "}"


def archive(files: Mapping[str, bytes]) -> bytes:
    """Return a ZIP archive that depends on nothing but names and contents.

    The files are stored, not compressed: zlib implementations differ in the bytes they make, and the standard
    allows both.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as out:
        for name in sorted(files, key=lambda name: (name != "modelDescription.xml", name)):
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.create_system = 3  # Unix, on every host, so that the permissions below count
            entry.external_attr = (0o100755 if name.startswith("binaries/") else 0o100644) << 16
            out.writestr(entry, files[name])
    return buffer.getvalue()


def place(files: Mapping[str, bytes], target: Path, *, runs_here: bool = True) -> None:
    """Put an FMU in its place once it is known to be good; until then the place stays as it was.

    Parameters
    ----------
    files : mapping of str to bytes
        The content by path inside the FMU.
    target : Path
        Where the FMU goes; its folder is made if need be.
    runs_here : bool
        The FMU holds a library for this machine, so it is tried in a process of its own.

    Raises
    ------
    BuildError
        The folder cannot be written, or the FMU is not valid, or it does not run.
    """
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        # beside the target, because a move is atomic only within one file system
        with tempfile.TemporaryDirectory(prefix=".build-", dir=target.parent) as folder:
            draft = Path(folder) / target.name
            draft.write_bytes(archive(files))
            _check(draft, runs_here=runs_here)
            os.replace(draft, target)
    except OSError as error:
        reason = error.strerror or str(error)
        raise BuildError(f"cannot write {target}: {reason}; choose another folder with --output") from error


def _check(draft: Path, *, runs_here: bool) -> None:
    problems = validate_fmu(str(draft))
    if problems:
        listed = "\n".join(f"  {problem}" for problem in problems)
        raise BuildError(f"{draft.name} breaks the FMI standard and was not put in place:\n{listed}")
    if runs_here:
        _try(draft)


def _try(draft: Path) -> None:
    # A process of its own: a library that crashes must not take the build with it.
    command = [sys.executable, "-I", str(TRIAL), str(draft)]
    try:
        run = subprocess.run(
            command, capture_output=True, text=True, errors="replace", check=False, timeout=TRIAL_SECONDS
        )
    except subprocess.TimeoutExpired as error:
        message = f"{draft.name} did not end its trial run within {TRIAL_SECONDS:g} s and was not put in place"
        raise BuildError(message) from error
    if run.returncode != 0:
        output = (run.stdout + run.stderr).strip() or "no message"
        message = f"{draft.name} failed its trial run (exit code {run.returncode}) and was not put in place:\n{output}"
        raise BuildError(message)
