"""Write runs to disk: a folder is complete or it is not there.

Everything is written into a temporary folder beside the final one, and moved to its place at the end. Of an earlier run
what its manifest names is replaced, and nothing else is ever touched. A streamed run has a new folder, which is there
from the beginning.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from pathlib import Path

from cosim.errors import OutputError
from cosim.files import draft_of, locked, make_durable, why
from cosim.run.report import MANIFEST, UNFINISHED, read_content, was_streamed, written_files


@contextmanager
def run_folder(path: Path, files: Iterable[str] = ()) -> Generator[Path]:
    """Give a temporary folder to write a run into, and move it to `path` if all goes well.

    Parameters
    ----------
    path : Path
        Where the run is to be; a link is followed. Folders above it are made as needed.
    files : iterable of str
        What will be written, within the folder.

    Yields
    ------
    Path
        The folder to write into; gone, with everything made for it, if an exception leaves the block.

    Raises
    ------
    OutputError
        If `path` cannot be written, or holds something that is not a run, a streamed run, or something of the user's
        where a file is to be. Raised before the block is entered, so that no time is lost on a run that cannot be kept.
    """
    path = Path(os.path.realpath(path))
    _refuse_foreign(path)
    earlier = _earlier(path)
    _refuse_what_is_in_the_way(path, files, earlier)
    made: list[Path] = []
    try:
        made = make_folders(path.parent)
        draft = Path(tempfile.mkdtemp(prefix=f".{path.name}-", dir=path.parent))
    except OSError as error:
        remove_empty(made)
        raise OutputError(f"output folder {path} cannot be written: {error.strerror}") from error
    try:
        yield draft
        try:
            _put_in_place(draft, path, earlier)
        except OSError as error:
            raise OutputError(f"output folder {path} cannot be written: {why(error)}") from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)
        remove_empty(made)


def refuse_occupied(path: Path) -> None:
    """Refuse a folder for a new run that is there as it goes on, if it holds anything.

    Raises
    ------
    OutputError
        If it does, or is a file.
    """
    path = Path(os.path.realpath(path))
    _refuse_foreign(path)
    if path.exists() and not _is_empty(path):
        raise OutputError(f"output folder {path} holds a run already; expected a new folder for a streamed one")


@contextmanager
def held(path: Path) -> Generator[None]:
    """Keep other programs from going on with the run in a folder while the block runs.

    Raises
    ------
    OutputError
        If one has begun to.
    """
    if not path.is_dir():
        yield
        return
    with locked(path) as free:
        if not free:
            raise OutputError(f"output folder {path} is in use: the run in it is going on")
        yield


def _refuse_foreign(path: Path) -> None:
    """Refuse a path that holds something other than an earlier run."""
    if not path.exists():
        return
    if not path.is_dir():
        raise OutputError(f"output folder {path} is a file; expected a folder or nothing")
    try:
        empty = _is_empty(path)
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


def _is_empty(path: Path) -> bool:
    """Tell whether a folder holds nothing, or only the draft that a run has left which was killed as it began."""
    return all(entry.name == draft_of(path / MANIFEST).name for entry in path.iterdir())


def _earlier(path: Path) -> set[str]:
    """Return the files of an earlier run in a folder, within it; refuse one that a later run may not replace."""
    content = read_content(path) if path.is_dir() else None
    if content is None:
        return set()
    if was_streamed(content):
        raise OutputError(
            f"output folder {path} holds a finished streamed run, which is not replaced; expected another folder, or "
            "this one removed"
        )
    return {name for name in written_files(content) if not _in_the_way(path, name, {name})}


def _refuse_what_is_in_the_way(path: Path, files: Iterable[str], earlier: set[str]) -> None:
    """Refuse what stands where a file is to be and is none of an earlier run."""
    for name in files:
        obstacle = _in_the_way(path, name, earlier)
        if obstacle is not None:
            raise OutputError(
                f"{obstacle} is in the way, and is not of an earlier run; expected it elsewhere, or another folder"
            )


def _in_the_way(path: Path, name: str, earlier: set[str]) -> Path | None:
    """Return what hinders a file from being written: a link, a file for a folder, a folder for a file, or another's."""
    place = path
    *folders, _ = Path(name).parts
    for folder in folders:
        place = place / folder
        if place.is_symlink() or (place.exists() and not place.is_dir()):
            return place
    place = path / name
    if place.is_symlink() or place.is_dir() or (place.exists() and name not in earlier):
        return place
    return None


def make_folders(path: Path) -> list[Path]:
    """Make a folder and those above it; return the new ones, innermost first."""
    missing: list[Path] = []
    while not path.exists():
        missing.append(path)
        path = path.parent
    made: list[Path] = []
    for folder in reversed(missing):
        try:
            folder.mkdir()
        except OSError:
            remove_empty(made)
            raise
        made.insert(0, folder)
    return made


def remove_empty(folders: Iterable[Path]) -> None:
    """Remove folders that were made for nothing."""
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            continue


def _put_in_place(draft: Path, path: Path, earlier: set[str]) -> None:
    """Move what was written to its place; what an earlier run has written goes only when all the new is there."""
    draft.chmod(0o755)
    make_durable(file for file in draft.rglob("*") if file.is_file())
    if not path.exists():
        draft.rename(path)
        return
    written = [file.relative_to(draft).as_posix() for file in sorted(draft.rglob("*")) if not file.is_dir()]
    _refuse_what_is_in_the_way(path, written, earlier)
    old = Path(tempfile.mkdtemp(prefix=f".{path.name}-old-", dir=path.parent))
    moved: list[tuple[Path, Path]] = []
    # The manifest goes first and comes last, since it is what makes a folder a run.
    moves = [(path / name, old / name) for name in sorted(earlier, key=lambda name: name != MANIFEST)]
    moves += [(draft / name, path / name) for name in sorted(written, key=lambda name: name == MANIFEST)]
    try:
        for source, target in moves:
            if source.exists():
                target.parent.mkdir(parents=True, exist_ok=True)
                source.rename(target)
                moved.append((source, target))
    except OSError:
        for source, target in reversed(moved):
            target.rename(source)
        raise
    finally:
        shutil.rmtree(old, ignore_errors=True)
    remove_empty(folder for name in earlier if (folder := (path / name).parent) != path)
