"""Write and read checkpoints: all that a run needs to go on, or to be reported, in one file.

It is an .npz archive of NumPy, arrays by name and JSON text among them, none of them compressed. What is read may have
been written by somebody else: its sizes are those of the file, and nothing is made larger than that.
"""

from __future__ import annotations

import io
import json
import struct
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NotRequired

import numpy as np
from numpy.typing import NDArray
from typing_extensions import TypedDict  # as pydantic wants it before Python 3.12

from cosim.errors import CheckpointError, OutputError
from cosim.files import read_file, replace_file, why
from cosim.master.run import Snapshot
from cosim.master.step_control import Tally
from cosim.run.report import EnergyResidual, GuardSpan, NotIterated

CHECKPOINT = "checkpoint.npz"
FORMAT = "cosim-checkpoint-2"
MOST_BYTES = 2**33
_HEAD = "head"
_ARRAY = ".npy"
_MOST_ARRAYS = 100_000
_KINDS = "biufU"
# What zipfile, JSON and NumPy raise on what is damaged.
_DAMAGE = (
    ValueError, KeyError, TypeError, AttributeError, EOFError, OverflowError, RuntimeError, NotImplementedError,
    SyntaxError, RecursionError, IndexError, struct.error, zipfile.BadZipFile,
)  # fmt: skip


class _FixedSteps(TypedDict):
    """Place of a run of fixed steps: how many were taken."""

    row: int


class _VaryingSteps(TypedDict):
    """Place of a run of steps that vary or are repeated, as `cosim.master.step_control` counts it."""

    interval: int
    place: int
    level: int
    tally: Tally


class _Account(TypedDict):
    """Account of the coupling so far."""

    energy_residual: dict[str, EnergyResidual]
    guards: dict[str, GuardSpan]
    not_iterated: NotRequired[dict[str, NotIterated]]
    not_finite: bool


class _MasterNotes(TypedDict):
    """Notes of a master's snapshot."""

    run: _FixedSteps | _VaryingSteps
    account: _Account
    timings: _Timings
    time: float


class _Timings(TypedDict):
    """Wall-clock times so far [s]."""

    initialise: float
    step: float


@dataclass(frozen=True)
class Notes:
    """Say of which run a checkpoint is, and where that was.

    Attributes
    ----------
    identity : mapping
        All that decides what the results are.
    every : mapping of str to int
        Strides of columns, by name or pattern.
    csv : bool
        Whether rows go to CSV.
    position : mapping of str to int
        As `cosim.run.store.Store.commit` returned it.
    proof : mapping of str to str
        What the store needs besides, to find that its rows are those of this run.
    snapshot : mapping, optional
        Of the master, to go on from; None of a run that is complete.
    record : mapping, optional
        What is to be told of a run that is complete, and lacks nothing but its manifest.
    units : mapping of str to str
        Of the columns that are kept of a complete run.
    signals : list of str
        What the figure of a complete run is to show.
    """

    identity: dict[str, Any]
    every: dict[str, int]
    csv: bool
    position: dict[str, int]
    proof: dict[str, str]
    snapshot: _MasterNotes | None = None
    record: dict[str, Any] | None = None
    units: dict[str, str] | None = None
    signals: list[str] | None = None


@dataclass(frozen=True)
class Checkpoint:
    """Hold what a checkpoint file does: notes, and arrays by name."""

    notes: Notes
    arrays: Mapping[str, NDArray[Any]]


def write_checkpoint(path: Path, snapshot: Snapshot) -> None:
    """Write a snapshot as a checkpoint, in place of an earlier one.

    Raises
    ------
    OutputError
        If it cannot be written; the earlier one is left alone.
    """
    head = {"format": FORMAT, "arrays": sorted(snapshot.arrays), "notes": snapshot.notes}
    content = np.frombuffer(json.dumps(head).encode(), np.uint8)
    plain = {name: values.astype(str) if values.dtype == object else values for name, values in snapshot.arrays.items()}
    archive = io.BytesIO()
    np.savez(archive, allow_pickle=False, **{_HEAD: content}, **plain)
    try:
        replace_file(path, archive.getvalue())
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {why(error)}") from error


def read_checkpoint(path: Path) -> Snapshot:
    """Read what a checkpoint holds.

    Raises
    ------
    CheckpointError
        If it is not there, is none, is damaged, or is of another version.
    """
    try:
        content = read_file(path, MOST_BYTES, follow=False)
    except FileNotFoundError:
        raise CheckpointError(f"{path}: there is no such file") from None
    except OSError as error:
        raise CheckpointError(f"{path} cannot be read: {why(error)}") from error
    try:
        arrays = _arrays(content)
        head = json.loads(arrays.pop(_HEAD).tobytes())
        found, names, notes = head["format"], head["arrays"], head["notes"]
    except _DAMAGE as error:
        raise CheckpointError(f"{path} is no checkpoint, or is damaged: {why(error)}") from error
    if found != FORMAT:
        raise CheckpointError(f"{path} is a checkpoint of format {found}; expected {FORMAT}")
    if sorted(arrays) != names:
        raise CheckpointError(f"{path} is damaged: it holds {', '.join(sorted(arrays))}; expected {', '.join(names)}")
    return Snapshot(notes, arrays)


def _arrays(content: bytes) -> dict[str, NDArray[Any]]:
    """Read the arrays of an archive, none of them larger than it is in the file."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        entries = archive.infolist()
        if len(entries) > _MOST_ARRAYS or sum(entry.file_size for entry in entries) > len(content):
            raise ValueError("it says it holds more than it has bytes")
        for entry in entries:
            if entry.compress_type != zipfile.ZIP_STORED or not entry.filename.endswith(_ARRAY):
                raise ValueError(f"{entry.filename} is none of its arrays")
        names = [entry.filename.removesuffix(_ARRAY) for entry in entries]
        if len(set(names)) < len(names):
            raise ValueError("it holds an array twice")
        return {name: _array(archive.read(entry)) for name, entry in zip(names, entries, strict=True)}


def _array(content: bytes) -> NDArray[Any]:
    """Read an array, of plain numbers or text, whose declared size must be that of its data."""
    file = io.BytesIO(content)
    version = np.lib.format.read_magic(file)
    if version != (1, 0):
        raise ValueError(f"an array is of version {version}")
    shape, fortran, dtype = np.lib.format.read_array_header_1_0(file)
    count = 1
    for size in shape:
        count *= size
    if dtype.kind not in _KINDS or dtype.itemsize == 0 or min(shape, default=0) < 0:
        raise ValueError(f"an array is of type {dtype}")
    if count * dtype.itemsize != len(content) - file.tell():
        raise ValueError("an array is not as large as it says")
    values = np.frombuffer(content, dtype, offset=file.tell()).reshape(shape, order="F" if fortran else "C")
    return values.copy()


def checkpoint_of(path: Path) -> Checkpoint:
    """Read the checkpoint of a run, with its notes as they must be.

    Raises
    ------
    CheckpointError
        If it is not there, is none, is damaged, or is of another version.
    """
    from pydantic import TypeAdapter, ValidationError  # which takes a while to import

    read = read_checkpoint(path)
    try:
        notes = TypeAdapter(Notes).validate_python(dict(read.notes), extra="forbid")
    except (ValidationError, TypeError, ValueError) as error:
        raise CheckpointError(f"{path} is damaged: {_first(error)}") from error
    finished = notes.snapshot is None
    if min(notes.position.values(), default=0) < 0 or finished is (notes.record is None):
        raise CheckpointError(f"{path} is damaged: its notes make no sense")
    return Checkpoint(notes, read.arrays)


def snapshot_of(saved: Checkpoint) -> Snapshot:
    """Return what the master goes on from, in plain numbers."""
    from pydantic import TypeAdapter

    adapter: TypeAdapter[_MasterNotes | None] = TypeAdapter(_MasterNotes | None)
    return Snapshot(adapter.dump_python(saved.notes.snapshot) or {}, saved.arrays)


def _first(error: Exception) -> str:
    """Return the first reason of a refusal."""
    from pydantic import ValidationError

    if not isinstance(error, ValidationError):
        return why(error)
    first = error.errors(include_input=False, include_url=False)[0]
    return f"{'.'.join(map(str, first['loc']))}: {first['msg']}"
