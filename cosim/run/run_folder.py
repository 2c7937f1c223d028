"""Runs on disk: a folder is complete or it is not there.

Everything is written into a temporary folder beside the final one, which takes its name at the end. Only a folder that
holds an earlier run, which its manifest shows, or nothing, is replaced.

Records as JSON can hold them.

Which commit of this package computes: of the checkout it runs from, or the one a wheel was built from.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import tempfile
import tomllib
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any, cast

from cosim.drilling.energy import EnergyBalance
from cosim.drilling.oscillation import Measures
from cosim.errors import OutputError
from cosim.recording.result import Result

MANIFEST = "manifest.json"
TRAJECTORY = "trajectory.csv"
FIGURE = "figure.png"
FORMAT = "cosim-run-1"
UNFINISHED = "unfinished"
"""State of a run that can be resumed, in its manifest."""


@contextmanager
def run_folder(path: Path) -> Generator[Path]:
    """Give a temporary folder to write a run into, and move it to `path` if all goes well.

    Parameters
    ----------
    path : Path
        Where the run is to be. Folders above it are made as needed.

    Yields
    ------
    Path
        The folder to write into; gone, with everything made for it, if an exception leaves the block.

    Raises
    ------
    OutputError
        If `path` cannot be written, or holds something that is not a run. Raised before the block is entered, so that
        no time is lost on a run that cannot be kept.
    """
    path = Path(os.path.abspath(path))
    _refuse_foreign(path)
    made: list[Path] = []
    try:
        made = _make_folders(path.parent)
        draft = Path(tempfile.mkdtemp(prefix=f".{path.name}-", dir=path.parent))
    except OSError as error:
        _remove_empty(made)
        raise OutputError(f"output folder {path} cannot be written: {error.strerror}") from error
    try:
        yield draft
        _put_in_place(draft, path)
    except OSError as error:
        raise OutputError(f"output folder {path} cannot be written: {error.strerror or error}") from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)
        _remove_empty(made)


def write_manifest(folder: Path, content: Mapping[str, Any]) -> None:
    """Write what makes a folder a run; infinite numbers as ``"inf"``, since JSON has none."""
    text = json.dumps({"format": FORMAT, **plain(content)}, indent=2, allow_nan=False)
    (folder / MANIFEST).write_text(text + "\n", encoding="utf-8")


def read_manifest(folder: Path) -> dict[str, Any] | None:
    """Return what was written by `write_manifest`; None if the folder is no run.

    Raises
    ------
    OutputError
        If there is a manifest that cannot be read.
    """
    try:
        content: object = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise OutputError(f"output folder {folder} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise OutputError(f"output folder {folder}: {MANIFEST} is not JSON: {error}") from error
    if not isinstance(content, dict):
        return None
    manifest = cast(dict[str, Any], content)
    return manifest if manifest.get("format") == FORMAT else None


def write_variant(
    folder: Path, subfolder: str, result: Result, measures: Measures | None, energy: EnergyBalance | None
) -> dict[str, Any]:
    """Write one variant's trajectory, and return its entry for the manifest.

    Parameters
    ----------
    folder : Path
        Of the run.
    subfolder : str
        Where the trajectory goes within it; empty for the run's own folder.
    result : Result
        What was recorded.
    measures : Measures, optional
        What it amounts to.
    energy : EnergyBalance, optional
        Where its energy went.
    """
    (folder / subfolder).mkdir(exist_ok=True)
    result.to_csv(folder / subfolder / TRAJECTORY)
    return variant_entry(result, measures, energy, f"{subfolder}/{TRAJECTORY}" if subfolder else TRAJECTORY)


def variant_entry(
    result: Result, measures: Measures | None, energy: EnergyBalance | None, trajectory: str
) -> dict[str, Any]:
    """Return the entry of a variant for the manifest, as JSON can hold it, with where its trajectory is."""
    entry = {
        **{key: value for key, value in result.record.items() if key not in ("scenario", "versions")},
        "trajectory": trajectory,
        "units": dict(result.units),
        "measures": asdict(measures) if measures else None,
        "energy": {"since": float(result.time[0]), **energy.summary()} if energy else None,
    }
    return plain(entry)


def refuse_occupied(path: Path) -> None:
    """Refuse a folder for a new run that is there as it goes on, if it holds anything.

    Raises
    ------
    OutputError
        If it does, or is a file.
    """
    _refuse_foreign(path)
    if path.exists() and any(path.iterdir()):
        raise OutputError(f"output folder {path} holds a run already; expected a new folder for a streamed one")


def _refuse_foreign(path: Path) -> None:
    """Refuse a path that holds something other than an earlier run."""
    if not path.exists():
        return
    if not path.is_dir():
        raise OutputError(f"output folder {path} is a file; expected a folder or nothing")
    try:
        empty = not any(path.iterdir())
    except OSError as error:
        raise OutputError(f"output folder {path} cannot be read: {error}") from error
    manifest = read_manifest(path)
    if not empty and manifest is None:
        raise OutputError(
            f"output folder {path} holds something that is not a run of this program; expected a new folder"
        )
    if manifest is not None and manifest.get("state") == UNFINISHED:
        raise OutputError(
            f"output folder {path} holds an unfinished run; go on with it by 'cosim resume {path}', or remove it"
        )
    if not os.access(path, os.W_OK):
        raise OutputError(f"output folder {path} cannot be written: Permission denied")


def _make_folders(path: Path) -> list[Path]:
    """Make a folder and those above it; return the new ones, innermost first."""
    missing: list[Path] = []
    while not path.exists():
        missing.append(path)
        path = path.parent
    for folder in reversed(missing):
        folder.mkdir()
    return missing


def _remove_empty(folders: list[Path]) -> None:
    """Remove folders that were made for nothing."""
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            return


def _put_in_place(draft: Path, path: Path) -> None:
    """Give the draft its name; an earlier run goes only when the new one is there."""
    draft.chmod(0o755)
    if not path.exists():
        draft.rename(path)
        return
    old = Path(tempfile.mkdtemp(prefix=f".{path.name}-old-", dir=path.parent))
    try:
        path.rename(old / path.name)
        try:
            draft.rename(path)
        except OSError:
            (old / path.name).rename(path)
            raise
    finally:
        shutil.rmtree(old, ignore_errors=True)


def plain(value: Any) -> Any:
    """Turn a value into what JSON knows; infinite numbers as ``"inf"``, since JSON has none."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in cast(Mapping[Any, Any], value).items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in cast(list[Any], value)]
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    return value


PACKAGE = Path(__file__).resolve().parents[1]
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
