"""Store streamed rows: what a store promises, how columns are decimated, and the store of CSV files.

A column has a stride: 1 stores all its rows, 10 every tenth, 0 none. CSV has a file for each stride, with the text that
`Result.to_csv` writes.
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, BinaryIO, Protocol

from cosim.errors import InputError, OutputError, suggestion
from cosim.recording.result import Column, Rows, header, lines

Position = Mapping[str, int]
"""The rows a store holds, by what it counts."""


class Store(Protocol):
    """Keeps rows on disk; raises `cosim.errors.OutputError` where it cannot."""

    def take(self, rows: Rows) -> None:
        """Take the rows that follow those taken before."""
        ...

    def commit(self) -> Position:
        """Bring everything taken so far to disk; a store opened at what is returned goes on from here."""
        ...

    def close(self, attributes: Mapping[str, Any]) -> None:
        """Bring everything to disk and note what is to be said of the run."""
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


def _stride(name: str, strides: Mapping[str, int]) -> int:
    """Return what the last pattern that matches says."""
    return next((strides[pattern] for pattern in reversed(tuple(strides)) if fnmatchcase(name, pattern)), 1)


@dataclass(frozen=True)
class _Sheet:
    """An open file and what goes into it."""

    stride: int
    names: tuple[str, ...]
    file: BinaryIO

    def take(self, rows: Rows) -> None:
        """Write what is to be stored."""
        chosen = slice(-rows.first % self.stride, None, self.stride)
        columns = (rows.columns[name][chosen] for name in self.names)
        self.file.writelines(line.encode() for line in lines(rows.times[chosen], *columns))


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
                sheet.file.flush()
            return {axis(sheet.stride): sheet.file.tell() for sheet in self._sheets}

    def close(self, attributes: Mapping[str, Any]) -> None:
        """Bring everything to disk; attributes have no place in CSV."""
        del attributes
        with _writing(self._folder):
            for sheet in self._sheets:
                sheet.file.close()


def csv_file(folder: Path, stride: int) -> Path:
    """Return where columns of a stride go."""
    return folder / f"trajectory{'' if stride == 1 else f'_{stride}'}.csv"


def create_csv(folder: Path, columns: Mapping[int, Sequence[Column]]) -> CsvStore:
    """Begin files in a folder that exists, each with its header; OutputError if they cannot be written."""
    with _writing(folder):
        for stride, chosen in columns.items():
            csv_file(folder, stride).write_bytes(header(column.name for column in chosen).encode())
        ends = {axis(stride): csv_file(folder, stride).stat().st_size for stride in columns}
    return reopen_csv(folder, columns, ends)


def reopen_csv(folder: Path, columns: Mapping[int, Sequence[Column]], position: Position) -> CsvStore:
    """Go on with files from where `CsvStore.commit` had brought them; OutputError if they are shorter than that."""
    sheets: list[_Sheet] = []
    with _writing(folder):
        for stride, chosen in columns.items():
            path, end = csv_file(folder, stride), position[axis(stride)]
            if not path.is_file() or path.stat().st_size < end:
                raise OutputError(f"{path} has less than {end} bytes; expected what was written")
            file = path.open("r+b")
            file.truncate(end)
            file.seek(end)
            sheets.append(_Sheet(stride, tuple(column.name for column in chosen), file))
    return CsvStore(folder, sheets)


@contextmanager
def _writing(folder: Path) -> Generator[None]:
    """Say what could not be written."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"{folder} cannot be written: {error.strerror or error}") from error
