"""Hand out the FMUs as files for other tools: those that are there, copies of them, and built anew."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

from cosim.errors import FmuFileError, InputError, MissingPackageError, OutputError, suggestion
from cosim.fmi2.locate import PACKAGINGS, build_script, how_to_build, promised_fmus

_NEEDED = ("ziglang", "pythonfmu", "jinja2")


def available_fmus(packaging: str) -> dict[str, Path]:
    """Return the files of the FMUs of this project, by name.

    Raises
    ------
    InputError
        If there is no such packaging.
    FmuFileError
        If there are none.
    """
    if packaging not in PACKAGINGS:
        raise InputError(f"there is no packaging '{packaging}'{suggestion(packaging, PACKAGINGS)}")
    found = promised_fmus(packaging)
    if not found:
        raise FmuFileError(f"there are no FMUs of the {packaging} packaging here{how_to_build(packaging)}")
    return found


def copy_fmus(folder: Path, packaging: str, *, replace: bool = False) -> list[Path]:
    """Copy the FMUs into a folder, each whole or not at all; return the paths of the copies.

    Parameters
    ----------
    folder : Path
        Made if it is not there.
    packaging : str
        ``"native"`` or ``"python"``.
    replace : bool, optional
        Whether files of the same names and other content are replaced.

    Raises
    ------
    InputError
        If there is no such packaging, or a file of another content stands where a copy is to go: nothing is written.
    FmuFileError
        If there are no FMUs.
    OutputError
        If the folder cannot be written.
    """
    sources = available_fmus(packaging)
    targets = {folder / source.name: source for source in sources.values()}
    try:
        if not replace:
            for target, source in targets.items():
                if target.exists() and target.read_bytes() != source.read_bytes():
                    raise InputError(f"{target} is there already and is another file; expected --force to replace it")
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".fmus-", dir=folder) as draft:
            for target, source in targets.items():
                copy = shutil.copyfile(source, Path(draft) / source.name)
                os.replace(copy, target)
    except OSError as error:
        raise OutputError(f"folder {folder} cannot be written: {error.strerror or error}") from error
    return list(targets)


def build_fmus(arguments: Sequence[str]) -> int:
    """Build FMUs in a process of its own, by the options of `build_fmu.py`; return its exit code.

    Raises
    ------
    MissingPackageError
        If what building needs is not installed.
    """
    missing = [name for name in _NEEDED if find_spec(name) is None]
    if missing:
        brings = 'pip install "drillstring-cosim[build]" brings all of it'
        raise MissingPackageError(f"building FMUs needs {', '.join(missing)}; {brings}")
    script = build_script()
    how = ["-m", "cosim.fmu_src.build"] if script is None else [str(script)]
    command = [sys.executable, *how, *arguments]
    return subprocess.run(command, check=False).returncode
