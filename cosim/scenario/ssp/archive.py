"""The .ssp file itself, of which members are read by name."""

from __future__ import annotations

import logging
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit

import cosim.fmi2.archive
from cosim.errors import SspError
from cosim.fmi2.archive import Archive
from cosim.scenario.ssp.vocabulary import STRUCTURE

log = logging.getLogger("cosim")


class SspArchive:
    """An open .ssp file, of which members are read one by one, never unpacked by their own names."""

    def __init__(self, archive: Archive) -> None:
        self.path = archive.path
        self._archive = archive
        self._names = archive.names

    def read(self, name: str) -> bytes:
        """Return the content of a member; SspError if there is none of that name or it is damaged."""
        return self._archive.read(name)

    def copy(self, name: str, target: Path) -> None:
        """Write the content of a member to a file; SspError as by `read`, or if it cannot be written."""
        self._archive.copy(name, target)

    def number(self, name: str) -> int:
        """Return the place of a member in the archive; -1 if it is not there."""
        return self._names.index(name) if name in self._names else -1

    def member(self, source: str, what: str) -> str:
        """Return the name of the member that a URI of the description means.

        Raises
        ------
        SspError
            If the URI leads out of the archive.
        """
        parts = urlsplit(source)
        path = PurePosixPath(unquote(parts.path))
        outside = path.is_absolute() or ".." in path.parts or "\\" in str(path)
        if parts.scheme or parts.netloc or parts.query or parts.fragment or outside or not path.parts:
            raise SspError(f"{self.path}: the source of {what} is '{source}'; expected a path within the archive")
        return str(path)


@contextmanager
def open_archive(path: Path) -> Generator[SspArchive]:
    """Open an .ssp file for reading.

    Raises
    ------
    SspError
        If it is missing, is not a zip archive that can safely be opened, or holds no SystemStructure.ssd.
    """
    with cosim.fmi2.archive.open_archive(path, "an SSP file", SspError) as archive:
        if STRUCTURE not in archive.names:
            raise SspError(f"{path} is not an SSP file: there is no {STRUCTURE} in it")
        others = [name for name in archive.names if name.endswith(".ssd") and "/" not in name and name != STRUCTURE]
        if others:
            log.warning("%s: %s is read; the variants %s are not", path.name, STRUCTURE, ", ".join(others))
        yield SspArchive(archive)
