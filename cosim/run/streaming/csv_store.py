"""Trajectories streamed to CSV: a file for each distance in rows, with the text that `Result.to_csv` writes."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from cosim.errors import OutputError
from cosim.recording.csv_text import header, lines
from cosim.recording.rows import Column, Rows
from cosim.run.streaming.decimation import axis
from cosim.run.streaming.store import Position


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
