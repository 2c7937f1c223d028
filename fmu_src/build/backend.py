"""The build of the distribution (PEP 517, PEP 660): setuptools, with the FMUs and the step loop put in a wheel first.

A wheel runs in any folder without a compiler, so it holds the native FMUs and the library of the step loop for every
platform. They stand in `cosim/built` while the wheel is packed and never otherwise: in a checkout, what runs is what
`build_fmu.py` has built last.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path

from setuptools import build_meta
from setuptools.build_meta import (
    build_editable,
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]

_ROOT = Path(__file__).resolve().parents[2]
_BUILT = _ROOT / "cosim" / "built"
_EARLIEST = "315532800"
"""1980-01-01, the first day that an archive can name: so that two builds give the same bytes."""

type_of_settings = Mapping[str, str | list[str] | None] | None


def get_requires_for_build_wheel(config_settings: type_of_settings = None) -> list[str]:
    """Return what a wheel needs beside setuptools: all that compiles, describes and tries FMUs."""
    import tomllib

    project = tomllib.loads((_ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return [
        *build_meta.get_requires_for_build_wheel(config_settings),
        *project["dependencies"],
        *project["optional-dependencies"]["build"],
    ]


def build_wheel(
    wheel_directory: str, config_settings: type_of_settings = None, metadata_directory: str | None = None
) -> str:
    """Build a wheel that holds the FMUs; return its file name."""
    os.environ.setdefault("SOURCE_DATE_EPOCH", _EARLIEST)
    shutil.rmtree(_ROOT / "build" / "lib", ignore_errors=True)  # setuptools packs what an earlier build left there
    with _built_files():
        return build_meta.build_wheel(wheel_directory, config_settings, metadata_directory)


@contextmanager
def _built_files() -> Generator[None]:
    """Have the folder of what is built for as long as the wheel is packed."""
    from .command import build_all
    from .step_loop import build_step_loops

    shutil.rmtree(_BUILT, ignore_errors=True)
    try:
        build_all(_BUILT)
        build_step_loops(_BUILT / "step_loop")
        _take_console()
        commit = _commit()
        if commit:
            (_BUILT / "commit.txt").write_text(f"{commit}\n", encoding="utf-8")
        yield
    finally:
        shutil.rmtree(_BUILT, ignore_errors=True)


def _take_console() -> None:
    """Take up the console if `make console` has built it of these sources: a wheel can be built without node."""
    subprocess.run([sys.executable, "-m", "fmu_src.console", "--take", str(_BUILT)], cwd=_ROOT, check=True)


def _commit() -> str | None:
    """Return the commit that the wheel is built from, if this is a checkout of it and git is there."""
    if not (_ROOT / ".git").exists():
        return None
    try:
        run = subprocess.run(
            ["git", "rev-parse", "HEAD"], cwd=_ROOT, capture_output=True, text=True, check=True, timeout=30
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return run.stdout.strip()
