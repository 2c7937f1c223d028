"""Keep unpacked FMUs while the process lives, so that one that is loaded again need not be unpacked again.

A folder is lent to one library at a time, since instances of one library share its global variables, which FMUs use
more often than the standard allows. It is kept only if all its files are as they were unpacked, and if nothing of the
library has stayed in the process: whoever loads from it next begins as if nobody had before.
"""

from __future__ import annotations

import atexit
import ctypes
import os
import shutil
import tempfile
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from cosim.files import digest_of, open_file

MOST_FOLDERS = 16
"""Kept at a time, those that were used last."""
MOST_BYTES = 64_000_000
"""In a folder that is kept."""

Proof = tuple[tuple[str, int, int, int], ...]
"""Of each file below a folder: name, number, size, and when it was changed."""


@dataclass(frozen=True)
class _Unpacked:
    """A folder, the library in it, and what was unpacked."""

    content: bytes
    folder: Path
    library: Path
    proof: Proof

    @property
    def is_as_it_was(self) -> bool:
        """Tell whether nothing was changed, and nothing is loaded."""
        return _proof_of(self.folder) == self.proof and not _is_loaded(self.library)


class UnpackedFmus:
    """Folders that wait to be lent again; of this process alone, whatever it is forked into."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._waiting: list[_Unpacked] = []
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=self._forget)
        atexit.register(self.clear)

    @contextmanager
    def lent(self, archive: Path, unpack: Callable[[Path], Path]) -> Generator[tuple[Path, Path]]:
        """Lend a folder with what is in an archive.

        Parameters
        ----------
        archive : Path
            The .fmu file.
        unpack : callable
            Fills an empty folder, and returns the path of the library in it.

        Yields
        ------
        folder, library : Path
            The library is to be loaded from there, and unloaded before the block ends.
        """
        content = archive_digest(archive)
        found = self._taken(content)
        folder = Path(tempfile.mkdtemp(prefix="cosim-")) if found is None else found.folder
        try:
            if found is None:
                library = unpack(folder)
                found = _Unpacked(content, folder, library, _proof_of(folder))
            yield folder, found.library
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        self._take_back(found)

    def clear(self) -> None:
        """Remove all that wait."""
        with self._lock:
            gone, self._waiting = self._waiting, []
        for each in gone:
            shutil.rmtree(each.folder, ignore_errors=True)

    def _forget(self) -> None:
        """Leave the folders to the process that this one was forked from."""
        self._lock, self._waiting = threading.Lock(), []

    def _taken(self, content: bytes) -> _Unpacked | None:
        """Take a folder of a content that is as it was unpacked; remove those that are not."""
        while True:
            with self._lock:
                found = next((each for each in reversed(self._waiting) if each.content == content), None)
                if found is None:
                    return None
                self._waiting.remove(found)
            if found.is_as_it_was:
                return found
            shutil.rmtree(found.folder, ignore_errors=True)

    def _take_back(self, unpacked: _Unpacked) -> None:
        """Keep a folder, if it can be lent again, and remove one that is not, or that has waited longest."""
        gone = [unpacked]
        if sum(size for _, _, size, _ in unpacked.proof) <= MOST_BYTES and unpacked.is_as_it_was:
            with self._lock:
                self._waiting.append(unpacked)
                gone = self._waiting[:-MOST_FOLDERS]
                del self._waiting[:-MOST_FOLDERS]
        for each in gone:
            shutil.rmtree(each.folder, ignore_errors=True)


def archive_digest(archive: Path) -> bytes:
    """Return what tells the content of a file from all others; nothing if it cannot be read, as unpacking will say."""
    try:
        with open(open_file(archive, os.O_RDONLY, follow=True), "rb") as file:
            return digest_of(file)
    except OSError:
        return b""


def _proof_of(folder: Path) -> Proof:
    """Return what changes if anybody changes a file below a folder, adds one or removes one."""
    found: list[tuple[str, int, int, int]] = []
    for place, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = os.path.join(place, name)
            status = os.lstat(path)
            found.append((path, status.st_ino, status.st_size, status.st_ctime_ns))
    return tuple(sorted(found))


def _is_loaded(library: Path) -> bool:
    """Tell whether a library is in the process; where that cannot be known, it is taken to be."""
    if not hasattr(os, "RTLD_NOLOAD"):
        return True  # Windows
    try:
        ctypes.CDLL(str(library), mode=os.RTLD_NOLOAD | os.RTLD_NOW)
    except OSError:
        return False
    return True
