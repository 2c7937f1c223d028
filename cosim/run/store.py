"""What a run is streamed to.

Which rows of which columns are stored: every one, every tenth, none, by name or pattern.

Trajectories streamed to CSV: a file for each distance in rows, with the text that `Result.to_csv` writes.
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
"""How far a store has got, by what it counts."""


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


EVERYTHING: Mapping[str, int] = {"*": 1}


def decimate(columns: Sequence[Column], every: Mapping[str, int]) -> dict[int, tuple[Column, ...]]:
    """Sort columns by how many rows apart they are stored.

    Parameters
    ----------
    columns : sequence of Column
        All that is recorded.
    every : mapping of str to int
        By name or pattern of names, as ``plant.*``: store every row (1), every tenth (10), none (0). Of several that
        match, the last holds; what none matches is stored in every row.

    Returns
    -------
    dict of int to tuple of Column
        By distance in rows, the smallest first; without those that are not stored.

    Raises
    ------
    InputError
        If a distance is negative, a name or pattern matches nothing, or nothing is left.
    """
    names = [column.name for column in columns]
    for pattern, distance in every.items():
        if distance < 0:
            raise InputError(f"every: {pattern} = {distance}; expected 0 or a number of rows")
        if not any(fnmatchcase(name, pattern) for name in names):
            raise InputError(f"every: there is no '{pattern}'{suggestion(pattern, names)}")
    chosen = {column: _distance(column.name, every) for column in columns}
    distances = sorted(set(chosen.values()) - {0})
    if not distances:
        raise InputError("every: nothing is stored; expected a distance other than 0 for something")
    return {each: tuple(column for column in columns if chosen[column] == each) for each in distances}


def axis(distance: int) -> str:
    """Return the name of the time axis of columns that are stored so many rows apart."""
    return "time" if distance == 1 else f"time_{distance}"


def _distance(name: str, every: Mapping[str, int]) -> int:
    """Return what the last pattern that matches says."""
    return next((every[pattern] for pattern in reversed(tuple(every)) if fnmatchcase(name, pattern)), 1)


@dataclass(frozen=True)
class _Sheet:
    """An open file and what goes into it."""

    distance: int
    names: tuple[str, ...]
    file: BinaryIO

    def take(self, rows: Rows) -> None:
        """Write what is to be stored."""
        chosen = slice(-rows.first % self.distance, None, self.distance)
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
            return {axis(sheet.distance): sheet.file.tell() for sheet in self._sheets}

    def close(self, attributes: Mapping[str, Any]) -> None:
        """Bring everything to disk; attributes have no place in CSV."""
        del attributes
        with _writing(self._folder):
            for sheet in self._sheets:
                sheet.file.close()


def csv_file(folder: Path, distance: int) -> Path:
    """Return where columns that are stored so many rows apart go."""
    return folder / f"trajectory{'' if distance == 1 else f'_{distance}'}.csv"


def create_csv(folder: Path, columns: Mapping[int, Sequence[Column]]) -> CsvStore:
    """Begin files in a folder that exists, each with its header; OutputError if they cannot be written."""
    with _writing(folder):
        for distance, chosen in columns.items():
            csv_file(folder, distance).write_bytes(header(column.name for column in chosen).encode())
        ends = {axis(distance): csv_file(folder, distance).stat().st_size for distance in columns}
    return reopen_csv(folder, columns, ends)


def reopen_csv(folder: Path, columns: Mapping[int, Sequence[Column]], position: Position) -> CsvStore:
    """Go on with files from where `CsvStore.commit` had brought them; OutputError if they are shorter than that."""
    sheets: list[_Sheet] = []
    with _writing(folder):
        for distance, chosen in columns.items():
            path, end = csv_file(folder, distance), position[axis(distance)]
            if not path.is_file() or path.stat().st_size < end:
                raise OutputError(f"{path} has less than {end} bytes; expected what was written")
            file = path.open("r+b")
            file.truncate(end)
            file.seek(end)
            sheets.append(_Sheet(distance, tuple(column.name for column in chosen), file))
    return CsvStore(folder, sheets)


@contextmanager
def _writing(folder: Path) -> Generator[None]:
    try:
        yield
    except OSError as error:
        raise OutputError(f"{folder} cannot be written: {error.strerror or error}") from error
