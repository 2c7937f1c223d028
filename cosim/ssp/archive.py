"""The .ssp file itself, of which members are read by name."""

from __future__ import annotations

import logging
import zipfile
import zlib
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit

from cosim.errors import SspError
from cosim.ssp.vocabulary import STRUCTURE

log = logging.getLogger("cosim")


class SspArchive:
    """An open .ssp file, of which members are read one by one, never unpacked by their own names."""

    def __init__(self, path: Path, file: zipfile.ZipFile) -> None:
        self.path = path
        self._file = file
        self._names = file.namelist()

    def read(self, name: str) -> bytes:
        """Return the content of a member.

        Raises
        ------
        SspError
            If there is none of that name or it is damaged.
        """
        if name not in self._names:
            raise SspError(f"{self.path}: there is no {name} in it")
        try:
            return self._file.read(name)
        except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError, NotImplementedError) as error:
            raise SspError(f"{self.path}: {name} cannot be read: {error}") from error

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
        If it is missing, is not a zip archive, or holds no SystemStructure.ssd.
    """
    try:
        file = zipfile.ZipFile(path)
    except FileNotFoundError:
        raise SspError(f"{path}: there is no such file") from None
    except zipfile.BadZipFile:
        raise SspError(f"{path} is not an SSP file: it is not a zip archive") from None
    except OSError as error:
        raise SspError(f"{path}: cannot be read: {error.strerror}") from error
    with file:
        if STRUCTURE not in file.namelist():
            raise SspError(f"{path} is not an SSP file: there is no {STRUCTURE} in it")
        others = [name for name in file.namelist() if name.endswith(".ssd") and "/" not in name and name != STRUCTURE]
        if others:
            log.warning("%s: %s is read; the variants %s are not", path.name, STRUCTURE, ", ".join(others))
        yield SspArchive(path, file)
