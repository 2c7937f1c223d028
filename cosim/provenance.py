"""Tell by what results are made: versions of what computes, and the commit of this package."""

from __future__ import annotations

import os
import platform
import subprocess
import tomllib
from functools import cache
from importlib import metadata
from pathlib import Path

import numpy as np


def versions() -> dict[str, str]:
    """Return the versions of what computes, and the platform."""
    import fmpy  # pyright: ignore[reportMissingTypeStubs]

    return {
        "drillstring-cosim": _installed(),
        "fmpy": fmpy.__version__,
        "numpy": np.__version__,
        "python": platform.python_version(),
        "platform": fmpy.platform_tuple,
    }


@cache
def _installed() -> str:
    """Return the version of this package."""
    return metadata.version(_PROJECT)


PACKAGE = Path(__file__).resolve().parent
_PROJECT = "drillstring-cosim"
_PATIENCE = 10.0


@cache
def commit(package: Path = PACKAGE) -> str | None:
    """Return the full hash, with ``-dirty`` if tracked files differ from it; None if nobody knows.

    Parameters
    ----------
    package : Path
        The folder of this package.
    """
    checkout = package.parent
    if _is_checkout(checkout):
        return _described(checkout)
    try:
        return (package / "built" / "commit.txt").read_text(encoding="utf-8").strip() or None
    except (OSError, UnicodeDecodeError):
        return None


def _is_checkout(folder: Path) -> bool:
    """Tell whether a folder is the top of a repository of this project, not of one that has it installed within."""
    try:
        project = tomllib.loads((folder / "pyproject.toml").read_text(encoding="utf-8"))["project"]["name"]
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, KeyError, TypeError):
        return False
    return project == _PROJECT and (folder / ".git").exists()


def _described(folder: Path) -> str | None:
    """Ask git, whatever repository the environment speaks of, as it does in a hook."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    command = ["git", "-C", str(folder), "describe", "--always", "--abbrev=40", "--exclude=*", "--dirty"]
    try:
        done = subprocess.run(
            command, env=environment, check=True, capture_output=True, text=True, errors="replace", timeout=_PATIENCE
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None
