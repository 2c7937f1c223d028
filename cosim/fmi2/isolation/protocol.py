"""Speak between the master and the process of an isolated FMU.

Requests and replies go through pipes, values through memory that both have mapped: a header, in which the process notes
what it is doing, then two rows of the component's block. Row 0 is for initialisation, as FMUs take slopes from row 1
on. Strings go with requests and replies. The master unpickles nothing and believes nothing: what comes back is a
status, JSON of bounded size, and numbers.
"""

from __future__ import annotations

import mmap
import os
import struct
from collections.abc import Iterable, Sequence
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.recording.record import BASE_TYPES, DTYPES, TEXT, BaseType, Block, Section, Slopes
from cosim.system.description import Description

REQUEST = struct.Struct("<BbiddI")
"""Operation; row to be written first, or -1; slot; time and size [s]; bytes of JSON that follow."""

REPLY = struct.Struct("<BI")
"""Failure of the operation (0 or 1); bytes of JSON that follow."""

MOST_REPLY = 2**20
"""Bytes of JSON in a reply."""

HEADER = struct.Struct("<B7xQ")
"""Operation under way; bytes of memory held, once they are too many."""

TEXTS = "texts"
"""Key of strings: those of the driven inputs in a request, those of the outputs in a reply."""

_ROWS = 2


class Operation(IntEnum):
    """Name what the process is asked to do, or says that it is doing."""

    START = 0
    OPEN = 1
    SETUP = 2
    ENTER = 3
    EXIT = 4
    WRITE = 5
    STEP = 6
    READ = 7
    SAVE = 8
    RESTORE = 9
    SERIALISE = 10
    DESERIALISE = 11
    TERMINATE = 12
    CLOSE = 13

    @property
    def phrase(self) -> str:
        """Tell where in a run the FMU was, to end a sentence."""
        return _PHRASES[self]


_PHRASES = {
    Operation.START: "before it was loaded",
    Operation.OPEN: "while it was loaded and instantiated",
    Operation.SETUP: "while its start values were set",
    Operation.ENTER: "in fmi2EnterInitializationMode",
    Operation.EXIT: "in fmi2ExitInitializationMode",
    Operation.WRITE: "while its inputs were set",
    Operation.STEP: "in fmi2DoStep",
    Operation.READ: "while its outputs were read",
    Operation.SAVE: "in fmi2GetFMUstate",
    Operation.RESTORE: "in fmi2SetFMUstate",
    Operation.SERIALISE: "in fmi2SerializeFMUstate",
    Operation.DESERIALISE: "in fmi2DeSerializeFMUstate",
    Operation.TERMINATE: "in fmi2Terminate",
    Operation.CLOSE: "while it was freed and unloaded",
}


def receive(descriptor: int, size: int) -> bytes:
    """Read a number of bytes from a pipe; EOFError if the other end is closed."""
    parts: list[bytes] = []
    while size:
        part = os.read(descriptor, min(size, 2**16))
        if not part:
            raise EOFError
        parts.append(part)
        size -= len(part)
    return b"".join(parts)


def send(descriptor: int, message: bytes) -> None:
    """Write all bytes to a pipe."""
    while message:
        message = message[os.write(descriptor, message) :]


def shape_of(block: Block) -> dict[str, Any]:
    """Say by names and value references what a block holds, so that `block_of` can make its like."""
    slopes = (block.slopes, block.output_slopes)
    return {
        "inputs": {kind: [variable.name for variable in block.inputs[kind].variables] for kind in BASE_TYPES},
        "outputs": {kind: [variable.name for variable in block.outputs[kind].variables] for kind in BASE_TYPES},
        "driven": {kind: block.inputs[kind].driven for kind in BASE_TYPES},
        "slopes": [part.references.tolist() if part else None for part in slopes],
    }


def block_of(shape: dict[str, Any], description: Description) -> Block:
    """Make a block without rows."""

    def section(names: list[str], kind: BaseType, driven: int) -> Section:
        variables = tuple(description.by_name[name] for name in names)
        references = np.array([variable.reference for variable in variables], dtype=np.uint32)
        return Section(variables, references, np.zeros((0, len(names)), DTYPES[kind]), driven)

    def slopes(references: list[int] | None) -> Slopes | None:
        if references is None:
            return None
        count = len(references)
        return Slopes(np.array(references, np.uint32), np.ones(count, np.int32), np.zeros((0, count)))

    inputs: dict[BaseType, Section] = {
        kind: section(shape["inputs"][kind], kind, shape["driven"][kind]) for kind in BASE_TYPES
    }
    outputs: dict[BaseType, Section] = {kind: section(shape["outputs"][kind], kind, 0) for kind in BASE_TYPES}
    return Block(inputs, outputs, *(slopes(references) for references in shape["slopes"]))


def shared_size(block: Block) -> int:
    """Return the bytes of memory that header and rows take."""
    return HEADER.size + sum(_ROWS * 8 * values.shape[1] for values in block.arrays() if values.dtype != TEXT)


def shared_block(block: Block, memory: mmap.mmap) -> Block:
    """Return a block like another whose two rows are in shared memory, but for strings, which each side has."""
    return block.with_arrays(_views(block.arrays(), memory))


def _views(arrays: Sequence[NDArray[Any]], memory: mmap.mmap) -> Iterable[NDArray[Any]]:
    offset = HEADER.size
    for values in arrays:
        columns = values.shape[1]
        if values.dtype == TEXT:
            yield np.full((_ROWS, columns), "", TEXT)
            continue
        yield np.frombuffer(memory, values.dtype, _ROWS * columns, offset).reshape(_ROWS, columns)
        offset += _ROWS * 8 * columns
