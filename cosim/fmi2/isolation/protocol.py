"""Speak between the master and the process of an isolated FMU.

A request is a head, numbers and JSON; so is its reply, which repeats number and operation of the request, so that one
that belongs to another, or to none, is told apart. The numbers are a row of the component's block, side by side, or a
state. No memory is shared for them: what the master reads is its own, whatever becomes of the process. Only what the
process is doing it notes in a file that it has mapped, and that the master reads once the process is lost.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.recording.record import BASE_TYPES, DTYPES, TEXT, BaseType, Block, Section, Slopes
from cosim.system.description import Description

REQUEST = struct.Struct("<QBb2xiddQI4x")
"""Number; operation; row to be written first, or -1; slot; time and size [s]; bytes of numbers and of JSON."""

REPLY = struct.Struct("<QBB2xIQ")
"""Number; operation; whether it failed (0 or 1); bytes of JSON and of numbers, which come first."""

MOST_REPLY = 2**20
"""Bytes of JSON in a reply."""

MOST_STATE = 2**30
"""Bytes of a state."""

PART = 2**16
"""Bytes that are read at once."""

NOTE = struct.Struct("<B7xQ")
"""Operation under way; bytes of memory held, once they are too many and the process has to see to that itself."""

TEXTS = "texts"
"""Key of strings: those of the driven inputs in a request, those of the outputs in a reply."""

_ROWS = 2  # one for initialisation, as FMUs take slopes from row 1 on


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


def receive(descriptor: int) -> tuple[Sequence[Any], memoryview, memoryview]:
    """Read one request: its head, numbers and JSON; EOFError if the other end is closed."""
    message = _part(descriptor)
    while len(message) < REQUEST.size:
        message += _part(descriptor)
    head = REQUEST.unpack_from(message)
    data, text = head[-2:]
    size = REQUEST.size + data + text
    if len(message) < size:
        parts = [message]
        left = size - len(message)
        while left:
            parts.append(_part(descriptor, left))
            left -= len(parts[-1])
        message = b"".join(parts)
    body = memoryview(message)[REQUEST.size :]
    return head, body[:data], body[data:]


def _part(descriptor: int, size: int = PART) -> bytes:
    part = os.read(descriptor, min(size, PART))
    if not part:
        raise EOFError
    return part


def send(descriptor: int, message: bytes) -> None:
    """Write all bytes."""
    while message:
        message = message[os.write(descriptor, message) :]


class RowBytes:
    """One row of some arrays as bytes, side by side.

    Parameters
    ----------
    arrays : sequence of ndarray, each of shape (rows, columns)
        Whose rows are taken and put; those of strings are left out.
    """

    def __init__(self, arrays: Sequence[NDArray[Any]]) -> None:
        arrays = [values for values in arrays if values.dtype != TEXT and values.shape[1]]
        widths = [values.shape[1] * values.itemsize for values in arrays]
        self.content = bytearray(sum(widths))
        self._pairs: list[tuple[NDArray[Any], NDArray[Any]]] = []
        begin = 0
        # numbers of eight bytes first, so that all lie where they are read fastest
        for values, width in sorted(zip(arrays, widths, strict=True), key=lambda pair: -pair[0].itemsize):
            self._pairs.append((values, np.frombuffer(self.content, values.dtype, values.shape[1], begin)))
            begin += width

    def take(self, row: int) -> bytearray:
        """Return the bytes of a row; valid until the next is taken."""
        for values, image in self._pairs:
            image[:] = values[row]
        return self.content

    def load(self, content: memoryview) -> None:
        """Take bytes that came from the other side, of the same length."""
        self.content[:] = content

    def put(self, row: int) -> None:
        """Put what was loaded into a row."""
        for values, image in self._pairs:
            values[row] = image


def driven_bytes(block: Block) -> RowBytes:
    """Return the bytes of what goes with a request: driven inputs, and their slopes."""
    driven = [section.values[:, : section.driven] for section in (block.inputs[kind] for kind in BASE_TYPES)]
    return RowBytes([*driven, *([block.slopes.values] if block.slopes else [])])


def output_bytes(block: Block) -> RowBytes:
    """Return the bytes of what comes with a reply: outputs, and their slopes."""
    slopes = [block.output_slopes.values] if block.output_slopes else []
    return RowBytes([*(block.outputs[kind].values for kind in BASE_TYPES), *slopes])


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
    """Make a block of two rows."""

    def section(names: list[str], kind: BaseType, driven: int) -> Section:
        variables = tuple(description.by_name[name] for name in names)
        references = np.array([variable.reference for variable in variables], dtype=np.uint32)
        values = np.full((_ROWS, len(names)), "" if kind == "String" else 0, DTYPES[kind])
        return Section(variables, references, values, driven)

    def slopes(references: list[int] | None) -> Slopes | None:
        if references is None:
            return None
        count = len(references)
        return Slopes(np.array(references, np.uint32), np.ones(count, np.int32), np.zeros((_ROWS, count)))

    inputs: dict[BaseType, Section] = {
        kind: section(shape["inputs"][kind], kind, shape["driven"][kind]) for kind in BASE_TYPES
    }
    outputs: dict[BaseType, Section] = {kind: section(shape["outputs"][kind], kind, 0) for kind in BASE_TYPES}
    return Block(inputs, outputs, *(slopes(references) for references in shape["slopes"]))
