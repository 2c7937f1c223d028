"""Run programs of Node.js, which the console and the site of the documentation need."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from .errors import BuildError


def run_node(program: str, *arguments: str, folder: Path, needed_by: str) -> None:
    """Run ``node`` or ``npm`` in a folder.

    Parameters
    ----------
    program : str
        Its name.
    arguments : str
        What it is told.
    folder : Path
        Where it is run.
    needed_by : str
        What cannot be built without it, as the beginning of a sentence.

    Raises
    ------
    BuildError
        It is missing, or has failed.
    """
    path = shutil.which(program)
    if path is None:
        raise BuildError(f"{needed_by} needs {program}, which is missing; install Node.js 18 or later with npm")
    run = subprocess.run(
        [path, *arguments], cwd=folder, capture_output=True, text=True, encoding="utf-8", errors="replace", check=False
    )
    if run.returncode != 0:
        said = (run.stderr + run.stdout).strip()
        raise BuildError(f"{needed_by} cannot be built: {program} {arguments[0]} ended with {run.returncode}:\n{said}")


def install_packages(folder: Path, needed_by: str) -> Path:
    """Install the packages that package-lock.json of a folder names, unless they are there; return where they are.

    A copy of the lock is left with them, which tells what they are.

    Raises
    ------
    BuildError
        As of `run_node`.
    """
    packages, lock = folder / "node_modules", folder / "package-lock.json"
    made_from = packages / ".made-from.json"
    if not made_from.is_file() or made_from.read_bytes() != lock.read_bytes():
        run_node("npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", folder=folder, needed_by=needed_by)
        shutil.copyfile(lock, made_from)
    return packages
