"""Write runs to disk: a folder is complete or it is not there.

Everything is written into a temporary folder beside the final one, which takes its name at the end. Only a folder that
holds an earlier run, which its manifest shows, or nothing, is replaced. A streamed run has a new folder, which is there
from the beginning.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from cosim.errors import OutputError
from cosim.run.report import UNFINISHED, read_content


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
    manifest = read_content(path)
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
