"""Speak between the master and the process of an isolated FMU.

A request is a head, numbers and JSON; so is its reply, which repeats number and operation of the request, so that one
that belongs to another, or to none, is told apart. The numbers are a row of the component's block, side by side, or a
state. No memory is shared for them: what the master reads is its own, whatever becomes of the process. Only what the
process is doing it notes in a file that it has mapped, and that the master reads once the process is lost.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping, Sequence
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


def receive(descriptor: int) -> tuple[Sequence[Any], bytes, bytes]:
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
    numbers = REQUEST.size + data
    return head, message[REQUEST.size : numbers], message[numbers:]


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
        self.content = bytearray(sum(values.shape[1] * values.itemsize for values in arrays))
        self._pairs: list[tuple[NDArray[Any], NDArray[Any]]] = []
        begin = 0
        for values in sorted(arrays, key=_by_size):
            self._pairs.append((values, np.frombuffer(self.content, values.dtype, values.shape[1], begin)))
            begin += values.shape[1] * values.itemsize

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


class PackedRows:
    """Two rows for some arrays in one memory, so that nothing has to be copied one by one.

    Parameters
    ----------
    arrays : sequence of ndarray, each of shape (rows, columns)
        For whose like there is to be room.

    Attributes
    ----------
    arrays : list of ndarray, each of shape (2, columns)
        All zero, in the memory of the rows; those of strings are the ones given.
    """

    def __init__(self, arrays: Sequence[NDArray[Any]]) -> None:
        numbers = sorted((values for values in arrays if values.dtype != TEXT), key=_by_size)
        self._size = sum(values.shape[1] * values.itemsize for values in numbers)
        self._stride = -(-self._size // 8) * 8
        memory = bytearray(_ROWS * self._stride + 8)
        self._memory = memoryview(memory)
        begin, packed = 0, dict[int, NDArray[Any]]()
        for values in numbers:
            shape, strides = (_ROWS, values.shape[1]), (self._stride, values.itemsize)
            packed[id(values)] = np.ndarray(shape, values.dtype, memory, begin, strides)
            begin += values.shape[1] * values.itemsize
        self.arrays = [packed.get(id(values), values) for values in arrays]

    def row(self, row: int) -> memoryview:
        """Return the bytes of a row, to be read or written, as `RowBytes` has them."""
        return self._memory[row * self._stride : row * self._stride + self._size]


def _by_size(values: NDArray[Any]) -> int:
    """Sort numbers of eight bytes before others, so that all lie where they are read fastest."""
    return -values.itemsize


def driven_bytes(block: Block) -> RowBytes:
    """Return the bytes of what goes with a request: driven inputs, and their slopes."""
    driven = [section.values[:, : section.driven] for section in (block.inputs[kind] for kind in BASE_TYPES)]
    return RowBytes([*driven, *([block.slopes.values] if block.slopes else [])])


def output_bytes(block: Block) -> RowBytes:
    """Return the bytes of what comes with a reply: outputs, and their slopes."""
    slopes = [block.output_slopes.values] if block.output_slopes else []
    return RowBytes([*(block.outputs[kind].values for kind in BASE_TYPES), *slopes])


def shape_of(block: Block) -> dict[str, Any]:
    """Say by names and value references what is exchanged through a block, so that `packed_block` can make its like."""
    inputs, outputs = ({kind: part[kind].variables for kind in BASE_TYPES} for part in (block.inputs, block.outputs))
    slopes = (block.slopes, block.output_slopes)
    return {
        "inputs": {kind: [each.name for each in inputs[kind][: block.inputs[kind].driven]] for kind in BASE_TYPES},
        "outputs": {kind: [each.name for each in outputs[kind]] for kind in BASE_TYPES},
        "slopes": [part.references.tolist() if part else None for part in slopes],
    }


def packed_block(shape: dict[str, Any], description: Description) -> tuple[Block, PackedRows, PackedRows]:
    """Make a block of two rows, and return it with the memory of its driven inputs and of its outputs."""

    def section(kind: BaseType, names: Mapping[str, list[str]], driven: bool) -> Section:
        variables = tuple(description.by_name[name] for name in names[kind])
        references = np.array([variable.reference for variable in variables], dtype=np.uint32)
        values = np.full((_ROWS, len(variables)), "" if kind == "String" else 0, DTYPES[kind])
        return Section(variables, references, values, len(variables) if driven else 0)

    def slopes(references: list[int] | None) -> Slopes | None:
        if references is None:
            return None
        count = len(references)
        return Slopes(np.array(references, np.uint32), np.ones(count, np.int32), np.zeros((_ROWS, count)))

    inputs: dict[BaseType, Section] = {kind: section(kind, shape["inputs"], True) for kind in BASE_TYPES}
    outputs: dict[BaseType, Section] = {kind: section(kind, shape["outputs"], False) for kind in BASE_TYPES}
    block = Block(inputs, outputs, *(slopes(references) for references in shape["slopes"]))
    driven, told = (
        PackedRows([*(part.values for part in sections.values()), *([ends.values] if ends else [])])
        for sections, ends in ((inputs, block.slopes), (outputs, block.output_slopes))
    )
    kinds = len(BASE_TYPES)
    arrays = [*driven.arrays[:kinds], *told.arrays[:kinds], *driven.arrays[kinds:], *told.arrays[kinds:]]
    return block.with_arrays(arrays), driven, told
