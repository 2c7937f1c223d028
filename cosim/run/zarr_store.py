"""Stream trajectories to Zarr: chunks are replaced whole, after the index that says what they were and will be.

Columns may differ in length if the program ends while it writes; `cosim.open_trajectory` cuts them to the shortest.
"""

from __future__ import annotations

import uuid
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import OutputError
from cosim.files import make_durable, replace_file, why
from cosim.recording.exchange import simple_attributes
from cosim.recording.record import TEXT
from cosim.recording.result import Column, Rows
from cosim.run import zarr_layout as layout
from cosim.run.store import Position, axis
from cosim.run.zarr_layout import AxisIndex, Candidate, ColumnIndex, DamagedStoreError, Index, digest, text_of

_RUN = "run"


@dataclass
class _Draft:
    """A chunk that is to be written: where, what, and what it will be in the index."""

    column: ColumnIndex
    name: str
    content: bytes
    candidate: Candidate


class _Axis:
    """Columns of one stride, and the rows that no full file holds yet.

    Attributes
    ----------
    index : AxisIndex
        Its part of the index.
    pending : dict of str to ndarray, shape (CHUNK,)
        The rows from `base` on, by name of column, the axis itself among them.
    base, filled : int
        Rows in full files, and after them.
    """

    def __init__(self, index: AxisIndex, base: int = 0, filled: int = 0) -> None:
        self.index = index
        self.base, self.filled = base, filled
        self.pending: dict[str, NDArray[Any]] = {
            column.name: np.full(layout.CHUNK, "" if column.type == TEXT else 0, column.type)
            for column in index.columns
        }

    @property
    def name(self) -> str:
        """Name the axis."""
        return axis(self.index.stride)

    @property
    def rows(self) -> int:
        """Return how many rows have been taken."""
        return self.base + self.filled

    def take(self, rows: Rows) -> Generator[None]:
        """Take what is to be stored; whenever a chunk is full, it has to be written before this goes on."""
        chosen = slice(-rows.first % self.index.stride, None, self.index.stride)
        values = {name: rows.columns[name][chosen] for name in self.pending if name != self.name}
        values[self.name] = rows.times[chosen]
        count, taken = values[self.name].size, 0
        while taken < count:
            part = min(count - taken, layout.CHUNK - self.filled)
            for name, pending in self.pending.items():
                pending[self.filled : self.filled + part] = values[name][taken : taken + part]
            taken += part
            self.filled += part
            if self.filled == layout.CHUNK:
                yield
                self.base, self.filled = self.base + layout.CHUNK, 0
                for column in self.index.columns:
                    column.full.append(column.last.pop()[1])
                    column.last.clear()

    def drafts(self) -> list[_Draft]:
        """Make the chunks that are not on disk as they should be."""
        drafts: list[_Draft] = []
        for column in self.index.columns if self.filled else ():
            if [rows for rows, _ in column.last] == [self.filled]:
                continue
            content = layout.encoded(self.pending[column.name], self.filled)
            name = layout.chunk_file(column, len(column.full))
            drafts.append(_Draft(column, name, content, (self.filled, digest(content))))
        return drafts


class ZarrStore:
    """An open store; made by `create_zarr` or `reopen_zarr`."""

    def __init__(self, path: Path, index: Index, axes: Sequence[_Axis], attributes: Mapping[str, Any]) -> None:
        self._path = path
        self._index = index
        self._axes = tuple(axes)
        self._attributes = dict(attributes)
        self._passing: set[str] = set()

    @property
    def proof(self) -> Mapping[str, str]:
        """Return the name of the run, which no other has; the digests are in the index."""
        return {_RUN: self._index.run}

    def take(self, rows: Rows) -> None:
        """Take the rows that follow those taken before."""
        with _writing(self._path):
            for each in self._axes:
                for _ in each.take(rows):
                    self._write([each], durable=False)

    def commit(self) -> Position:
        """Write everything taken so far, to stay; return the number of rows on each axis."""
        with _writing(self._path):
            self._write(self._axes, durable=True)
            make_durable(self._path / name for name in self._passing)
            self._passing.clear()
            self.describe(durable=False)
        return {each.name: each.rows for each in self._axes}

    def close(self, attributes: Mapping[str, Any]) -> None:
        """Write everything, with attributes of the whole, and gather what describes the columns in one place."""
        self.commit()
        self._attributes |= simple_attributes(attributes)
        content = text_of(self._attributes)
        with _writing(self._path):
            self._index.attributes.append(digest(content))
            self._index.write(self._path)
            replace_file(self._path / layout.ATTRIBUTES, content)
            self._index.attributes = [digest(content)]
            rows = {each.name: each.rows for each in self._axes}
            gathered = layout.gathered_document(self._index, self._attributes, rows)
            replace_file(self._path / layout.GATHERED, text_of(gathered))
            self._index.closed = True
            self._index.write(self._path)

    def release(self) -> None:
        """Do nothing, as no file stays open."""

    def _write(self, axes: Sequence[_Axis], *, durable: bool) -> None:
        """Write the chunks of some axes that are not on disk yet, the index first.

        A chunk that takes the place of one with fewer rows of the last checkpoint is written to stay in any case, and
        so is the index before it: neither may outlive a loss of power without the other.
        """
        drafts = [draft for each in axes for draft in each.drafts()]
        if not drafts:
            return
        durable = durable or any(draft.column.last for draft in drafts)
        for draft in drafts:
            draft.column.last.append(draft.candidate)
        self._index.write(self._path, durable=durable)
        for draft in drafts:
            replace_file(self._path / draft.name, draft.content, durable=durable)
            if not durable:
                self._passing.add(draft.name)
            draft.column.last[:] = [draft.candidate]

    def describe(self, *, durable: bool = True) -> None:
        """Tell readers that know no index how many rows there are."""
        columns = [(column, each.rows) for each in self._axes for column in each.index.columns]
        arrays = [(self._path / column.folder / layout.ARRAY, column, rows) for column, rows in columns]
        for path, column, rows in arrays:
            replace_file(path, text_of(layout.array_document(column, rows)), durable=False)
        if durable:
            make_durable(path for path, _, _ in arrays)


def create_zarr(path: Path, columns: Mapping[int, Sequence[Column]], attributes: Mapping[str, Any]) -> ZarrStore:
    """Begin a store.

    Parameters
    ----------
    path : Path
        A folder that does not exist.
    columns : mapping of int to sequence of Column
        What to store, by stride.
    attributes : mapping
        Of the whole; anything that JSON knows.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    told = simple_attributes(attributes)
    content = text_of(told)
    index = Index(uuid.uuid4().hex, layout.strides_of(columns), [digest(content)])
    store = ZarrStore(path, index, [_Axis(each) for each in index.axes], told)
    with _writing(path):
        path.mkdir()
        replace_file(path / layout.GROUP, text_of(layout.group_document()), durable=False)
        replace_file(path / layout.ATTRIBUTES, content)
        for each in index.axes:
            for column in each.columns:
                (path / column.folder).mkdir()
                document = text_of(layout.attributes_document(column, each.stride))
                replace_file(path / column.folder / layout.ATTRIBUTES, document, durable=False)
                document = text_of(layout.array_document(column, 0))
                replace_file(path / column.folder / layout.ARRAY, document, durable=False)
        index.write(path)
    return store


def reopen_zarr(
    path: Path, columns: Mapping[int, Sequence[Column]] | None, position: Position, proof: Mapping[str, str]
) -> ZarrStore:
    """Go on with a store from where `ZarrStore.commit` had brought it; what was stored after that is dropped.

    Everything up to there is held against the index first, and nothing is changed if anything is not as it was.

    Parameters
    ----------
    path : Path
        The store.
    columns : mapping of int to sequence of Column, optional
        What it must consist of, by stride.
    position : mapping of str to int
        The number of rows on each axis.
    proof : mapping of str to str
        As `ZarrStore.proof` returned it then.

    Raises
    ------
    OutputError
        If the store is not there any more, is of another run, lacks rows, is damaged, or cannot be written.
    """
    with _writing(path):
        try:
            index = Index.read(path)
            _refuse_other_run(index, columns, proof)
            told = layout.check_descriptions(path, index)
            whole = deepcopy(index)
            axes = [_reopened(path, each, position[axis(each.stride)]) for each in index.axes]
        except DamagedStoreError as error:
            raise OutputError(f"{path}: {error}; expected what was written") from error
        store = ZarrStore(path, index, axes, told)
        # at any moment an array must be no longer than the index says: so it is cut first
        whole.closed = index.closed = False
        whole.write(path)
        store.describe()
        index.write(path)
        with suppress(FileNotFoundError):
            (path / layout.GATHERED).unlink()  # it tells the lengths of before
    return store


def _refuse_other_run(index: Index, columns: Mapping[int, Sequence[Column]] | None, proof: Mapping[str, str]) -> None:
    """Refuse the store of another run, or of other columns."""
    if index.run != proof.get(_RUN):
        raise DamagedStoreError("it is of another run than the checkpoint")
    if columns is None:
        return
    for found, wanted in zip(index.axes, layout.strides_of(columns), strict=False):
        if [(each.name, each.dtype) for each in found.columns] != [(each.name, each.dtype) for each in wanted.columns]:
            raise DamagedStoreError("it has other columns than the run")
    if [each.stride for each in index.axes] != list(columns):
        raise DamagedStoreError("its columns are stored in other distances than those of the run")


def _reopened(path: Path, index: AxisIndex, rows: int) -> _Axis:
    """Check the rows of an axis, cut its index to them, and read back those that fill no file."""
    number, filled = divmod(rows, layout.CHUNK)
    found = _Axis(index, number * layout.CHUNK, filled)
    for column in index.columns:
        for full in range(number):
            if full >= len(column.full):
                raise DamagedStoreError(f"{column.name} has been stored for less than {rows} rows")
            layout.check_chunk(path, column, full)
        if filled:
            found.pending[column.name][:filled] = _beginning(path, column, number, filled)[:filled]
    for column in index.columns:
        if number < len(column.full):
            column.full, column.last = column.full[:number], [(layout.CHUNK, column.full[number])]
    return found


def _beginning(path: Path, column: ColumnIndex, number: int, rows: int) -> NDArray[Any]:
    """Return the chunk in which the rows end."""
    there = layout.CHUNK if number < len(column.full) else layout.find_last(path, column)[0]
    if number > len(column.full) or there < rows:
        raise DamagedStoreError(f"{column.name} has been stored for less than {number * layout.CHUNK + rows} rows")
    return layout.read_chunk(path, column, number)


@contextmanager
def _writing(path: Path) -> Generator[None]:
    """Say what could not be written."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {why(error)}") from error
