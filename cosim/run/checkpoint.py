"""Keep all that a run needs to go on in one file that is whole or not there: a checkpoint.

The file is an .npz archive of NumPy: arrays by name, and JSON text among them. It is written beside its place and takes
it when it is complete, so a program that is killed on the way leaves the checkpoint before.
"""

from __future__ import annotations

import json
import os
import struct
import zipfile
import zlib
from contextlib import suppress
from pathlib import Path

import numpy as np

from cosim.errors import CheckpointError, OutputError
from cosim.master.run import Snapshot

FORMAT = "cosim-checkpoint-1"
_HEAD = "head"
# What zipfile and NumPy raise on damaged archives.
_DAMAGE = (
    OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, OverflowError, RuntimeError, struct.error,
    zipfile.BadZipFile, zlib.error,
)  # fmt: skip


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
    draft = path.with_name(f".{path.name}.new")
    try:
        with draft.open("wb") as file:
            np.savez(file, allow_pickle=False, **{_HEAD: content}, **plain)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
    except OSError as error:
        with suppress(OSError):
            draft.unlink()
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from error


def read_checkpoint(path: Path) -> Snapshot:
    """Read what a checkpoint holds.

    Raises
    ------
    CheckpointError
        If it is not there, is none, is damaged, or is of another version.
    """
    try:
        # opened here: NumPy leaves the file open where the archive turns out to be none
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        head = json.loads(arrays.pop(_HEAD).tobytes())
        found, names, notes = head["format"], head["arrays"], head["notes"]
    except FileNotFoundError:
        raise CheckpointError(f"{path}: there is no such file") from None
    except _DAMAGE as error:
        raise CheckpointError(f"{path} is no checkpoint, or is damaged: {error}") from error
    if found != FORMAT:
        raise CheckpointError(f"{path} is a checkpoint of format {found}; expected {FORMAT}")
    if sorted(arrays) != names:
        raise CheckpointError(f"{path} is damaged: it holds {', '.join(sorted(arrays))}; expected {', '.join(names)}")
    return Snapshot(notes, arrays)
