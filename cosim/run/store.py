"""Store streamed rows: what a store promises, how columns are decimated, and the store of CSV files.

A column has a stride: 1 stores all its rows, 10 every tenth, 0 none. CSV has a file for each stride, with the text that
`Result.to_csv` writes.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, Protocol

from cosim.errors import InputError, OutputError, suggestion
from cosim.files import open_file, replace_file, why, write_all
from cosim.recording.exchange import header, lines
from cosim.recording.result import Column, Rows

Position = Mapping[str, int]
"""The rows a store holds, by what it counts."""
_AT_ONCE = 2**20
"""Bytes that are read in one go."""


class Store(Protocol):
    """Keeps rows on disk; raises `cosim.errors.OutputError` where it cannot."""

    def take(self, rows: Rows) -> None:
        """Take the rows that follow those taken before."""
        ...

    def commit(self) -> Position:
        """Bring everything taken so far to disk; a store opened at what is returned goes on from here."""
        ...

    @property
    def proof(self) -> Mapping[str, str]:
        """Return what a store opened at the last commit needs to find that its rows are those written until then."""
        ...

    def close(self, attributes: Mapping[str, Any]) -> None:
        """Bring everything to disk and note what is to be said of the run."""
        ...

    def release(self) -> None:
        """Let go of what is open, whatever has become of the run."""
        ...


def decimate(columns: Sequence[Column], strides: Mapping[str, int]) -> dict[int, tuple[Column, ...]]:
    """Sort columns by stride.

    Parameters
    ----------
    columns : sequence of Column
        All that is recorded.
    strides : mapping of str to int
        By name or pattern of names, as ``plant.*``. What is a name is no pattern, and holds before all patterns; of
        several of these that match, the last holds; what none matches is stored in all rows.

    Returns
    -------
    dict of int to tuple of Column
        By stride, the smallest first; without those that are not stored.

    Raises
    ------
    InputError
        If a stride is negative, a name or pattern matches nothing, or nothing is left.
    """
    names = [column.name for column in columns]
    for pattern, stride in strides.items():
        if stride < 0:
            raise InputError(f"every: {pattern} = {stride}; expected 0 or a number of rows")
        if pattern not in names and not any(fnmatchcase(name, pattern) for name in names):
            raise InputError(f"every: there is no '{pattern}'{suggestion(pattern, names)}")
    patterns = {pattern: stride for pattern, stride in strides.items() if pattern not in names}
    chosen = {column: strides.get(column.name, _stride(column.name, patterns)) for column in columns}
    kept = sorted(set(chosen.values()) - {0})
    if not kept:
        raise InputError("every: nothing is stored; expected a distance other than 0 for something")
    return {each: tuple(column for column in columns if chosen[column] == each) for each in kept}


def axis(stride: int) -> str:
    """Return the name of the time axis of columns of a stride."""
    return "time" if stride == 1 else f"time_{stride}"


def stride_of(name: str) -> int:
    """Return the stride of the columns on an axis; ValueError if it is none."""
    stride = 1 if name == axis(1) else int(name.removeprefix("time_"))
    if axis(stride) != name:
        raise ValueError(f"there is no axis {name}")
    return stride


def _stride(name: str, strides: Mapping[str, int]) -> int:
    """Return what the last pattern that matches says."""
    return next((strides[pattern] for pattern in reversed(tuple(strides)) if fnmatchcase(name, pattern)), 1)


class _Sheet:
    """An open file and what goes into it, with the digest of what it has."""

    def __init__(self, stride: int, names: Sequence[str], descriptor: int, content: Any, size: int) -> None:
        self.stride = stride
        self._names = tuple(names)
        self._descriptor = descriptor
        self._content = content
        self.size = size

    @property
    def digest(self) -> str:
        """Return the digest of what has been written."""
        return self._content.hexdigest()

    def take(self, rows: Rows) -> None:
        """Write what is to be stored."""
        chosen = slice(-rows.first % self.stride, None, self.stride)
        columns = (rows.columns[name][chosen] for name in self._names)
        text = "".join(lines(rows.times[chosen], *columns)).encode()
        write_all(self._descriptor, text)
        self._content.update(text)
        self.size += len(text)

    def cut(self) -> None:
        """Drop what comes after what has been written, and go on there."""
        os.ftruncate(self._descriptor, self.size)
        os.lseek(self._descriptor, self.size, os.SEEK_SET)

    def sync(self) -> None:
        """Let what has been written outlive a loss of power."""
        os.fsync(self._descriptor)

    def close(self) -> None:
        """Close the file, once."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor = -1


class CsvStore:
    """Open files; made by `create_csv` or `reopen_csv`."""

    def __init__(self, folder: Path, sheets: Sequence[_Sheet]) -> None:
        self._folder = folder
        self._sheets = tuple(sheets)

    def take(self, rows: Rows) -> None:
        """Write the rows that follow those taken before."""
        with _writing(self._folder):
            for sheet in self._sheets:
                sheet.take(rows)

    def commit(self) -> Position:
        """Bring everything to disk; return the length of each file in bytes."""
        with _writing(self._folder):
            for sheet in self._sheets:
                sheet.sync()
        return {axis(sheet.stride): sheet.size for sheet in self._sheets}

    @property
    def proof(self) -> Mapping[str, str]:
        """Return the SHA-256 of each file."""
        return {axis(sheet.stride): sheet.digest for sheet in self._sheets}

    def close(self, attributes: Mapping[str, Any]) -> None:
        """Bring everything to disk; attributes have no place in CSV."""
        del attributes
        self.commit()

    def release(self) -> None:
        """Close the files."""
        for sheet in self._sheets:
            sheet.close()


def csv_file(folder: Path, stride: int) -> Path:
    """Return where columns of a stride go."""
    return folder / f"trajectory{'' if stride == 1 else f'_{stride}'}.csv"


def create_csv(folder: Path, columns: Mapping[int, Sequence[Column]]) -> CsvStore:
    """Begin files in a folder that exists, each with its header; OutputError if they cannot be written."""
    position: dict[str, int] = {}
    proof: dict[str, str] = {}
    with _writing(folder):
        for stride, chosen in columns.items():
            head = header(column.name for column in chosen).encode()
            replace_file(csv_file(folder, stride), head)
            position[axis(stride)], proof[axis(stride)] = len(head), hashlib.sha256(head).hexdigest()
    return reopen_csv(folder, columns, position, proof)


def reopen_csv(
    folder: Path, columns: Mapping[int, Sequence[Column]], position: Position, proof: Mapping[str, str]
) -> CsvStore:
    """Go on with files from where `CsvStore.commit` had brought them; what was written after that is dropped.

    Everything up to there is held against the digests first, and nothing is changed if anything is not as it was.

    Raises
    ------
    OutputError
        If a file is shorter than that, is not what was written, or cannot be written.
    """
    sheets: list[_Sheet] = []
    try:
        with _writing(folder):
            for stride, chosen in columns.items():
                path, end = csv_file(folder, stride), position[axis(stride)]
                descriptor = open_file(path, os.O_RDWR)
                sheets.append(
                    _Sheet(stride, [column.name for column in chosen], descriptor, _content(descriptor, end), end)
                )
                _refuse_other(path, descriptor, sheets[-1], proof[axis(stride)])
            for sheet in sheets:
                sheet.cut()
    except BaseException:
        for sheet in sheets:
            sheet.close()
        raise
    return CsvStore(folder, sheets)


def _content(descriptor: int, end: int) -> Any:
    """Read a file up to a place, and return the state of its digest."""
    content, left = hashlib.sha256(), end
    while left and (part := os.read(descriptor, min(left, _AT_ONCE))):
        content.update(part)
        left -= len(part)
    return content


def _refuse_other(path: Path, descriptor: int, sheet: _Sheet, digest: str) -> None:
    """Refuse a file that is not what was written, or that has another name as well, by which it would be lost."""
    found = os.fstat(descriptor)
    if found.st_size < sheet.size:
        raise OutputError(f"{path} has less than {sheet.size} bytes; expected what was written")
    if sheet.digest != digest:
        raise OutputError(f"{path} is damaged: its digest is another one than when it was written")
    if found.st_nlink > 1:
        raise OutputError(f"{path} is also known by another name; expected a file of its own, such as a copy")


@contextmanager
def _writing(folder: Path) -> Generator[None]:
    """Say what could not be written."""
    try:
        yield
    except FileNotFoundError as error:
        raise OutputError(f"{error.filename or folder} is missing; expected what was written") from error
    except OSError as error:
        raise OutputError(f"{folder} cannot be written: {why(error)}") from error
