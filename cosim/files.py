"""Read and write files where others may have been: regular ones of bounded size, replaced whole or left as they are.

A file from elsewhere may be a pipe that never ends, a device, a link to what must stay, or larger than memory. What is
written has a draft beside it, made anew and never through a link, that takes its place in one step; so a program that
is killed, or a disk that is full, leaves what was there before.
"""

from __future__ import annotations

import errno
import hashlib
import os
import stat
import time
from collections.abc import Generator, Iterable
from contextlib import contextmanager, suppress
from io import BufferedReader
from pathlib import Path

_digests: dict[tuple[int, ...], bytes] = {}
_MOST_DIGESTS = 1000
_SETTLED = 2_000_000_000
"""Nanoseconds after which a file that is changed once more gets another time, on any file system."""

# Windows has none of these.
_NO_LINK: int = getattr(os, "O_NOFOLLOW", 0)
_AT_ONCE: int = getattr(os, "O_NONBLOCK", 0)
_FOLDER: int = getattr(os, "O_DIRECTORY", 0)
_BINARY: int = getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)


class UnfitFileError(OSError):
    """A file that is there and is not one to be used: a link, a pipe, a device, or too large."""


def why(error: BaseException) -> str:
    """Return the reason of an error, never empty."""
    return getattr(error, "strerror", None) or str(error) or type(error).__name__


def read_file(path: Path, most: int, *, follow: bool = True) -> bytes:
    """Return the content of a file.

    Parameters
    ----------
    path : Path
        The file.
    most : int
        Bytes that it may have.
    follow : bool
        Whether it may be a link.

    Raises
    ------
    OSError
        If it cannot be read; UnfitFileError if it is no regular file, or has more bytes.
    """
    descriptor = open_file(path, os.O_RDONLY, follow=follow)
    with open(descriptor, "rb") as file:
        _refuse_size(os.fstat(descriptor).st_size, most)
        content = file.read(most + 1)  # it may have grown, or not tell its size
    _refuse_size(len(content), most)
    return content


def open_file(path: Path, flags: int, *, follow: bool = False) -> int:
    """Open a regular file that is there, without waiting for the other end of a pipe; return its descriptor.

    Raises
    ------
    OSError
        If it cannot be opened; UnfitFileError if it is no regular file, or a link that is not to be followed.
    """
    try:
        descriptor = os.open(path, flags | _BINARY | _AT_ONCE | (0 if follow else _NO_LINK))
    except OSError as error:
        if error.errno == errno.ELOOP and path.is_symlink():
            raise UnfitFileError(f"{path.name} is a link; expected a file") from None
        if error.errno == errno.ENXIO:  # a pipe without a reader, or a socket
            raise UnfitFileError(f"{path.name} is no regular file") from None
        raise
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        if stat.S_ISDIR(os.stat(path).st_mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        raise UnfitFileError(f"{path.name} is no regular file")
    return descriptor


def _refuse_size(size: int, most: int) -> None:
    """Refuse a file that is too large."""
    if size > most:
        raise UnfitFileError(f"it has more than {most / 1e6:.6g} MB")


def replace_file(path: Path, content: bytes, *, durable: bool = True) -> None:
    """Write a file in place of an earlier one, or of a link, in one step.

    Parameters
    ----------
    path : Path
        In a folder that exists.
    content : bytes
        All of it.
    durable : bool
        Whether it has to outlive a loss of power from now on; if not, `make_durable` can see to it later.

    Raises
    ------
    OSError
        If it cannot be written; what was there before is left alone then.
    """
    draft = draft_of(path)
    with suppress(FileNotFoundError):
        draft.unlink()  # a killed program may have left it, and somebody else may have put a link there
    descriptor = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _NO_LINK | _BINARY, 0o666)
    try:
        try:
            write_all(descriptor, content)
            if durable:
                os.fsync(descriptor)
        finally:
            os.close(descriptor)
        os.replace(draft, path)
    except BaseException:
        with suppress(OSError):
            draft.unlink()
        raise
    if durable:
        _sync_folder(path.parent)


def digest_of(file: BufferedReader) -> bytes:
    """Return the SHA-256 of an open file, which is remembered as long as the file is as it was."""
    status = os.fstat(file.fileno())
    key = (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)
    found = _digests.get(key)
    if found is None:
        found = hashlib.file_digest(file, "sha256").digest()
        if time.time_ns() - max(status.st_mtime_ns, status.st_ctime_ns) > _SETTLED:
            if len(_digests) >= _MOST_DIGESTS:
                _digests.clear()
            _digests[key] = found
    return found


def draft_of(path: Path) -> Path:
    """Return where a file is written before it takes its place."""
    return path.with_name(f".{path.name}.new")


def write_all(descriptor: int, content: bytes) -> None:
    """Write bytes, however few the system takes at once."""
    rest = memoryview(content)
    while rest:
        rest = rest[os.write(descriptor, rest) :]


def make_durable(paths: Iterable[Path]) -> None:
    """Let files outlive a loss of power."""
    folders: set[Path] = set()
    for path in paths:
        descriptor = open_file(path, os.O_RDWR)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
        folders.add(path.parent)
    for folder in folders:
        _sync_folder(folder)


def _sync_folder(folder: Path) -> None:
    """Let the names in a folder outlive a loss of power; where folders cannot be opened, the system sees to it."""
    if not _FOLDER:
        return
    descriptor = os.open(folder, os.O_RDONLY | _FOLDER | _BINARY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.ENOTSUP):  # as on some network file systems
            raise
    finally:
        os.close(descriptor)


def refuse_links(folder: Path, *names: str) -> None:
    """Refuse a folder in which one of these paths leads through a link, and so perhaps out of it.

    Raises
    ------
    UnfitFileError
        If one does.
    """
    for name in names:
        place = folder
        for part in Path(name).parts:
            place = place / part
            if place.is_symlink():
                raise UnfitFileError(f"{place.relative_to(folder).as_posix()} is a link; expected a file or folder")


@contextmanager
def locked(folder: Path) -> Generator[bool]:
    """Hold a folder for one program at a time; yields False where another holds it.

    The lock goes with the program, however that ends. Where there are no locks, as on some network file systems, or on
    Windows, True is yielded all the same.
    """
    try:
        import fcntl
    except ImportError:
        yield True
        return
    descriptor = os.open(folder, os.O_RDONLY | _FOLDER | _BINARY)
    try:
        free = True
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            free = False
        except OSError:
            free = True
        yield free
    finally:
        os.close(descriptor)
