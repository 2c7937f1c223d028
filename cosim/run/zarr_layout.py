"""Lay a trajectory out as Zarr, version 2, as xarray reads it, with an index that every file is held against.

Each column is an array over a time axis, ``time`` where every row is stored, ``time_10`` where every tenth is, and is a
folder with its rows in files of `CHUNK`. Zarr has no checksums, takes a file that is missing for zeros, and believes
what the files say of themselves. So an index says what has been written: the columns, and of each file a digest. It is
replaced before the files are, and names then what they were and what they will be: whenever a program is killed, each
file is one of the two.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.errors import InputError, require
from cosim.files import read_file, refuse_links, replace_file, why
from cosim.recording.record import TEXT
from cosim.recording.result import Column
from cosim.run.store import axis

TRAJECTORY = "trajectory.zarr"
CHUNK = 65536
"""Rows in a file."""
FORMAT = "cosim-index-1"
GROUP, ARRAY, ATTRIBUTES, GATHERED, INDEX = ".zgroup", ".zarray", ".zattrs", ".zmetadata", ".index.json"
MOST_BYTES = {GROUP: 10**4, ARRAY: 10**5, ATTRIBUTES: 10**8, GATHERED: 10**9, INDEX: 10**9}
_MOST_TEXT = 2**30
"""Bytes in a chunk of strings."""
_TYPES = {"<f8": np.dtype(np.float64), "<i4": np.dtype(np.int32), "|b1": np.dtype(np.bool_), "|O": TEXT}
_ENCODED = '%/\\:*?"<>|'
_LONGEST = 200
_BLOSC_HEADER = 16

Candidate = tuple[int, str]
"""A state that a chunk which is not full may be in: its rows, and the digest of its file."""


@dataclass
class ColumnIndex:
    """Say what has been stored of a column.

    Attributes
    ----------
    name, unit, description : str
        As of `cosim.recording.result.Column`.
    dtype : str
        As Zarr writes it.
    full : list of str
        Digests of the files that hold `CHUNK` rows.
    last : list of (int, str)
        States that the file after these may be in; none if there is no such file.
    """

    name: str
    unit: str
    dtype: str
    description: str = ""
    full: list[str] = field(default_factory=list[str])
    last: list[Candidate] = field(default_factory=list[Candidate])

    @property
    def type(self) -> np.dtype[Any]:
        """Return the type of its values in memory."""
        return _TYPES[self.dtype]

    @property
    def folder(self) -> str:
        """Name its folder."""
        return array_name(self.name)

    @property
    def rows(self) -> tuple[int, ...]:
        """Return how many rows there may be, by candidate."""
        full = len(self.full) * CHUNK
        return tuple(full + rows for rows, _ in self.last) or (full,)


@dataclass
class AxisIndex:
    """Say what has been stored of the columns of one stride, the time axis last."""

    stride: int
    columns: list[ColumnIndex]


@dataclass
class Index:
    """Say what has been stored.

    Attributes
    ----------
    run : str
        A name that no other run has.
    axes : list of AxisIndex
        By stride.
    attributes : list of str
        Digests that the file with the attributes of the whole may have.
    closed : bool
        Whether all is in place, so that nothing may differ from what it says.
    format : str
        Of the index.
    """

    run: str
    axes: list[AxisIndex]
    attributes: list[str] = field(default_factory=list[str])
    closed: bool = False
    chunk: int = field(default_factory=lambda: CHUNK)
    format: str = FORMAT

    def write(self, path: Path, *, durable: bool = True) -> None:
        """Write it into a store, below a digest of its own."""
        content = json.dumps(asdict(self)).encode()
        replace_file(path / INDEX, f"{digest(content)}\n".encode() + content, durable=durable)

    @classmethod
    def read(cls, path: Path) -> Index:
        """Read that of a store; raises OSError, or DamagedStoreError if it is none."""
        try:
            whole = read_file(path / INDEX, MOST_BYTES[INDEX], follow=False)
        except FileNotFoundError:
            raise DamagedStoreError(
                f"{INDEX} is missing, which has the digests; an earlier version wrote none, and xarray.open_zarr reads "
                "such a trajectory, unchecked"
            ) from None
        head, _, content = whole.partition(b"\n")
        if digest(content) != head.decode("ascii", "replace"):
            raise DamagedStoreError(f"{INDEX} is damaged")
        return _checked_index(content)


class DamagedStoreError(InputError):
    """A store of which a file is missing, or is not what was written."""


def _checked_index(content: bytes) -> Index:
    """Read an index, which may have been written by somebody else; DamagedStoreError if it makes no sense."""
    from pydantic import TypeAdapter, ValidationError  # which takes a while to import

    try:
        index = TypeAdapter(Index).validate_json(content, strict=True, extra="forbid")
    except ValidationError as error:
        raise DamagedStoreError(f"{INDEX} is damaged: {error.errors()[0]['msg']}") from error
    names = [column.name for each in index.axes for column in each.columns]
    folders = {column.folder for each in index.axes for column in each.columns}
    sound = (
        index.format == FORMAT
        and index.chunk == CHUNK
        and len(folders) == len(names)
        and all(each.stride > 0 and each.columns and each.columns[-1].name == axis(each.stride) for each in index.axes)
        and all(_is_sound(column) for each in index.axes for column in each.columns)
    )
    if not sound:
        raise DamagedStoreError(f"{INDEX} is of another format, or is damaged")
    return index


def _is_sound(column: ColumnIndex) -> bool:
    """Tell whether what an index says of a column can be."""
    return column.dtype in _TYPES and all(0 <= rows <= CHUNK for rows, _ in column.last)


def described(column: Column) -> ColumnIndex:
    """Return the entry of a column of which nothing has been stored."""
    dtype = next(name for name, known in _TYPES.items() if known == column.dtype)
    return ColumnIndex(column.name, column.unit, dtype, column.description)


def digest(content: bytes) -> str:
    """Return what tells one content from all others."""
    return hashlib.blake2b(content, digest_size=16).hexdigest()


def array_name(column: str) -> str:
    """Return the name of a column's array, which is that of a folder.

    It is the column's name, in which what leads into groups or is no part of a file's name is percent-encoded, and the
    percent sign itself. One that no file system takes is cut, and told apart by a digest. The array's attribute
    ``variable`` has the column's own name.
    """
    name = "".join(f"%{ord(each):02X}" if each in _ENCODED or ord(each) < 32 else each for each in column)
    name = name.replace(".", "%2E", 1) if name.startswith(".") else name
    if len(name.encode()) <= _LONGEST:
        return name
    kept = name.encode()[: _LONGEST - 17].decode("utf-8", "ignore")
    return f"{kept}~{hashlib.sha256(column.encode()).hexdigest()[:16]}"


def group_document() -> dict[str, Any]:
    """Return what makes a folder a group."""
    return {"zarr_format": 2}


def array_document(column: ColumnIndex, rows: int) -> dict[str, Any]:
    """Return what describes an array."""
    return {
        "shape": [rows], "chunks": [CHUNK], "dtype": column.dtype,
        "fill_value": None,  # xarray would take another one for missing values
        "order": "C", "filters": [{"id": "vlen-utf8"}] if column.type == TEXT else None, "dimension_separator": ".",
        "compressor": {"id": "blosc", "cname": "lz4", "clevel": 5, "shuffle": 1, "blocksize": 0}, "zarr_format": 2,
    }  # fmt: skip


def column_attributes(column: ColumnIndex) -> dict[str, Any]:
    """Return what xarray has to know of a column."""
    described = {"long_name": column.description} if column.description else {}
    return {"units": column.unit or "1", "variable": column.name, **described}


def attributes_document(column: ColumnIndex, stride: int) -> dict[str, Any]:
    """Return the attributes of an array."""
    return {"_ARRAY_DIMENSIONS": [axis(stride)], **column_attributes(column)}


def gathered_document(index: Index, attributes: Mapping[str, Any], rows: Mapping[str, int]) -> dict[str, Any]:
    """Return all descriptions in one, so that a reader has to open one file; `rows` are those of each axis."""
    told: dict[str, Any] = {GROUP: group_document(), ATTRIBUTES: dict(attributes)}
    for each in index.axes:
        for column in each.columns:
            told[f"{column.folder}/{ARRAY}"] = array_document(column, rows[axis(each.stride)])
            told[f"{column.folder}/{ATTRIBUTES}"] = attributes_document(column, each.stride)
    return {"metadata": told, "zarr_consolidated_format": 1}


def text_of(document: Mapping[str, Any]) -> bytes:
    """Write a description."""
    return json.dumps(document, indent=2).encode()


def require_codecs(purpose: str) -> Any:
    """Return the library of codecs; MissingPackageError if it is not installed."""
    return require("numcodecs", extra="stream", purpose=purpose)


def encoded(values: NDArray[Any], rows: int) -> bytes:
    """Return the file of a chunk of which some rows are there; the others are zeros, or empty strings."""
    numcodecs = require_codecs("writing Zarr")
    whole = np.full(CHUNK, "" if values.dtype == TEXT else 0, values.dtype)
    whole[:rows] = values[:rows]
    plain: Any = numcodecs.VLenUTF8().encode(whole) if values.dtype == TEXT else whole
    # fast, and well where numbers change little from row to row
    return bytes(numcodecs.Blosc("lz4", shuffle=numcodecs.Blosc.SHUFFLE).encode(plain))


def _decoded(content: bytes, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return the rows of a chunk; its sizes are looked at before there is memory for them."""
    numcodecs = require_codecs("reading Zarr")
    size = int.from_bytes(content[4:8], "little") if len(content) >= _BLOSC_HEADER else -1
    if size < 0 or (size > _MOST_TEXT if dtype == TEXT else size != CHUNK * dtype.itemsize):
        raise ValueError(f"it has {size} bytes unpacked")
    plain = bytes(numcodecs.Blosc().decode(content))
    if dtype != TEXT:
        return np.frombuffer(plain, dtype)
    if int.from_bytes(plain[:4], "little") != CHUNK:
        raise ValueError("it has another number of strings")
    return numcodecs.VLenUTF8().decode(plain)


def chunk_file(column: ColumnIndex, number: int) -> str:
    """Name the file of a chunk within the store."""
    return f"{column.folder}/{number}"


def read_chunk(path: Path, column: ColumnIndex, number: int) -> NDArray[Any]:
    """Return the rows of a chunk, held against the index; zeros follow those that are there.

    Raises
    ------
    DamagedStoreError
        If the file is missing, or is not what was written.
    """
    content, _ = _read_known(path, column, number)
    try:
        return _decoded(content, column.type)
    except (RuntimeError, ValueError) as error:
        raise DamagedStoreError(f"{chunk_file(column, number)} is damaged: {error}") from error


def find_last(path: Path, column: ColumnIndex) -> Candidate:
    """Return in which of its states the last chunk is, by looking if there are several; (0, "") if there is none."""
    if not column.last:
        return 0, ""
    return column.last[0] if len(column.last) == 1 else _read_known(path, column, len(column.full))[1]


def check_chunk(path: Path, column: ColumnIndex, number: int) -> None:
    """Hold a chunk against the index; raises as `read_chunk` does."""
    _read_known(path, column, number)


def _read_known(path: Path, column: ColumnIndex, number: int) -> tuple[bytes, Candidate]:
    """Return the file of a chunk, and which of those it may be it is."""
    known = [(CHUNK, column.full[number])] if number < len(column.full) else column.last
    name = chunk_file(column, number)
    most = _MOST_TEXT if column.type == TEXT else CHUNK * column.type.itemsize + _BLOSC_HEADER
    try:
        content = read_file(path / name, most, follow=False)
    except FileNotFoundError:
        for rows, wanted in known:
            if not rows and not wanted:
                return b"", (0, "")
        raise DamagedStoreError(f"{name} is missing") from None
    except OSError as error:
        raise DamagedStoreError(f"{name} cannot be read: {why(error)}") from error
    found = digest(content)
    matching = [candidate for candidate in known if candidate[1] == found]
    if not matching:
        raise DamagedStoreError(f"{name} is damaged: its digest is another one than when it was written")
    return content, max(matching)  # zeros are stored for rows that are not there yet as well


def check_descriptions(path: Path, index: Index) -> dict[str, Any]:
    """Hold all that describes a store against the index, before any rows are read; return the attributes of the whole.

    Raises
    ------
    DamagedStoreError
        If something is missing, or is not what was written.
    """
    try:
        refuse_links(path, *(column.folder for each in index.axes for column in each.columns))
        _refuse_unless(_document(path, GROUP) == group_document(), GROUP)
        for each in index.axes:
            for column in each.columns:
                name = f"{column.folder}/{ATTRIBUTES}"
                _refuse_unless(_document(path, name) == attributes_document(column, each.stride), name)
                _check_array(path, index, column)
        attributes = read_file(path / ATTRIBUTES, MOST_BYTES[ATTRIBUTES], follow=False)
        _refuse_unless(digest(attributes) in index.attributes, ATTRIBUTES)
        told = json.loads(attributes)
        if index.closed:
            rows = {axis(each.stride): each.columns[-1].rows[0] for each in index.axes}
            _refuse_unless(_document(path, GATHERED) == gathered_document(index, told, rows), GATHERED)
    except FileNotFoundError as error:
        raise DamagedStoreError(f"{Path(str(error.filename)).relative_to(path).as_posix()} is missing") from None
    except (OSError, ValueError, RecursionError) as error:
        raise DamagedStoreError(f"what describes it cannot be read: {why(error)}") from error
    return told


def _check_array(path: Path, index: Index, column: ColumnIndex) -> None:
    """Hold what describes an array against the index; while rows are being stored its length lags behind."""
    name = f"{column.folder}/{ARRAY}"
    found: Any = _document(path, name)
    rows: Any = found["shape"][0] if isinstance(found, dict) and found.get("shape") else None  # pyright: ignore
    if not isinstance(rows, int):
        raise DamagedStoreError(f"{name} is damaged")
    _refuse_unless(found == array_document(column, rows), name)
    _refuse_unless(rows == column.rows[0] if index.closed else 0 <= rows <= max(column.rows), name)


def _document(path: Path, name: str) -> Any:
    """Read a description."""
    return json.loads(read_file(path / name, MOST_BYTES[Path(name).name], follow=False))


def _refuse_unless(sound: bool, name: str) -> None:
    """Refuse a file that is not what was written."""
    if not sound:
        raise DamagedStoreError(f"{name} is damaged: it is not what was written")


def strides_of(columns: Mapping[int, Sequence[Column]]) -> list[AxisIndex]:
    """Return entries of columns by stride, of which nothing has been stored."""
    float64 = np.dtype(np.float64)
    return [
        AxisIndex(
            stride, [*map(described, chosen), described(Column(axis(stride), "s", float64, "communication points"))]
        )
        for stride, chosen in columns.items()
    ]
