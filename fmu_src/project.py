"""Tell where the sources lie, and what every FMU says about the project they come from."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib import metadata
from pathlib import Path

SOURCES = Path(__file__).resolve().parent
ROOT = SOURCES.parent
FMUS = SOURCES / "fmus"
ICONS = SOURCES / "icons"
NAME = "drillstring-cosim"
AUTHOR = "The drillstring-cosim authors"
LICENSE = "MIT"


def icon(name: str) -> Path:
    """Return the drawing of an FMU: its own, or the one for all that bring none."""
    own = FMUS / name / "icon.svg"
    return own if own.is_file() else ICONS / "any.svg"


@cache
def version() -> str:
    """Return the version of the project, from pyproject.toml or, in an installed package, its metadata."""
    declaration = ROOT / "pyproject.toml"
    if not declaration.is_file():
        return metadata.version(NAME)
    project: dict[str, str] = tomllib.loads(declaration.read_text(encoding="utf-8"))["project"]
    return project["version"]


@cache
def license_text(distribution: str = NAME) -> str:
    """Return the licence of this project, or of an installed distribution.

    Raises
    ------
    FileNotFoundError
        The distribution carries no licence file.
    """
    if distribution == NAME and (ROOT / "LICENSE").is_file():
        return (ROOT / "LICENSE").read_text(encoding="utf-8")
    for path in metadata.files(distribution) or []:
        is_text = path.suffix in ("", ".md", ".rst", ".txt")  # not a module licenses.py
        if is_text and path.name.upper().startswith("LICEN") and path.parent.name != "_vendor":
            return Path(path.locate()).read_text(encoding="utf-8")
    raise FileNotFoundError(f"the installed {distribution} carries no licence file; reinstall it")
