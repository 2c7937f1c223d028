"""Work with one isolated FMU, asked through standard input; `cosim.fmi2.isolation.keeper` starts the process.

It does with the FMU what `cosim.fmi2.fmu_slave.FmuSlave` does in the master's process, so that the numbers are the
same.
"""

from __future__ import annotations

import json
import logging
import mmap
import os
import sys
import threading
import time
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from cosim.errors import CosimError, EndRequestError, FmuFileError, SlaveError
from cosim.fmi2.fmu_slave import FmuSlave, open_fmu
from cosim.fmi2.isolation.protocol import (
    MOST_REPLY,
    NOTE,
    REPLY,
    TEXTS,
    Operation,
    PackedRows,
    packed_block,
    receive,
    send,
)
from cosim.fmi2.model_description import read_description
from cosim.recording.record import Block, Section
from cosim.system.description import Description
from cosim.system.signals import Value

_LOOK = 0.02
_NOTHING = b""
_OPERATIONS: dict[int, Operation] = {each.value: each for each in Operation}
# Address space that allocators set aside for threads without holding memory there: an arena and a stack each, bytes.
_SET_ASIDE = 2**28
_MOST_MESSAGES, _LONGEST_MESSAGE, _LONGEST_SENTENCE = 100, 1000, 10000
_PAGES = Path("/proc/self/statm")


class Messages(logging.Handler):
    """Keeps what the FMU says until it can be sent along with a reply."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self._kept: list[dict[str, Any]] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a message, unless there are too many."""
        if len(self._kept) < _MOST_MESSAGES:
            category, says_why = getattr(record, "category", ""), getattr(record, "says_why", False)
            text = _plain(record.getMessage(), _LONGEST_MESSAGE)
            level = min(record.levelno, logging.CRITICAL)
            said = {"level": level, "category": _plain(category, _LONGEST_MESSAGE), "says_why": says_why, "text": text}
            self._kept.append(said)

    def take(self) -> list[dict[str, Any]]:
        """Return what has been kept, and forget it."""
        taken, self._kept = self._kept, []
        return taken


class Note:
    """Tells what the process is doing, in a file that the master reads once the process is lost."""

    def __init__(self, path: Path) -> None:
        with path.open("r+b") as file:
            self._memory = mmap.mmap(file.fileno(), NOTE.size)

    def doing(self, operation: Operation) -> None:
        """Note what is about to be done, in case it is the last thing."""
        self._memory[0] = operation

    def holding(self, held: int) -> None:
        """Note how much memory was too much."""
        NOTE.pack_into(self._memory, 0, self._memory[0], held)


class Worker:
    """Does what it is asked to with one FMU."""

    def __init__(self, requests: int, replies: int, note: Note) -> None:
        self._requests = requests
        self._replies = replies
        self._note = note
        self._process = os.getpid()
        self._messages = Messages()
        self._stack = ExitStack()
        self._description: Description
        self._slave: FmuSlave
        self._block: Block
        self._driven: PackedRows
        self._outputs: PackedRows
        logging.getLogger("cosim").addHandler(self._messages)
        logging.getLogger("cosim").propagate = False
        logging.getLogger("cosim.surroundings").disabled = True  # they are the FMU's own here

    def work(self) -> None:
        """Answer until told to close, or until the master is gone."""
        send(self._replies, REPLY.pack(0, Operation.START, False, 0, 0))
        operation = Operation.START
        while operation is not Operation.CLOSE:
            (number, asked, write, slot, now, size, *_), data, text = receive(self._requests)
            operation = _OPERATIONS[asked]
            result, content = _NOTHING, dict[str, Any]()
            try:
                given: dict[str, Any] = json.loads(text) if text else {}
                if write >= 0:
                    self._note.doing(Operation.WRITE)
                    self._take_driven(write, data, given)
                    self._slave.write(write)
                self._note.doing(operation)
                result, content = self._do(operation, slot, now, size, data, given)
            except Exception as failure:  # whatever it is, the master is to tell it
                content["error"] = _as_content(failure)
            if os.getpid() != self._process:
                os._exit(0)  # the FMU has forked, and it is for the other one to answer
            self._reply(number, operation, result, content)

    def _do(
        self, operation: Operation, slot: int, now: float, size: float, data: bytes, given: dict[str, Any]
    ) -> tuple[bytes | memoryview, dict[str, Any]]:
        """Do an operation; return the numbers and the texts that come of it."""
        match operation:
            case Operation.STEP:
                self._slave.step(now, size)
                self._note.doing(Operation.READ)
                return self._read()
            case Operation.READ:
                return self._read()
            case Operation.SAVE:
                self._slave.save(slot)
            case Operation.RESTORE:
                self._slave.restore(slot)
            case Operation.SERIALISE:
                return self._slave.serialise(), {}
            case Operation.DESERIALISE:
                self._slave.deserialise(data, now)
            case Operation.OPEN:
                self._open(given)
            case Operation.SETUP:
                self._set_up(given, now, size)
            case Operation.ENTER:
                return self._enter(data, given)
            case Operation.EXIT:
                self._slave.exit_initialization()
                return _NOTHING, _not_kept(self._slave.not_kept)
            case Operation.TERMINATE:
                self._slave.terminate()
            case Operation.CLOSE:
                self._stack.close()
            case Operation.START | Operation.WRITE:
                pass
        return _NOTHING, {}

    def _open(self, given: dict[str, Any]) -> None:
        limit_memory(int(given["memory"]), self._note)
        path = Path(given["path"])
        self._description = read_description(path)
        self._slave = self._stack.enter_context(open_fmu(given["name"], path, self._description))

    def _set_up(self, given: dict[str, Any], start_time: float, stop_time: float) -> None:
        self._block, self._driven, self._outputs = packed_block(given["shape"], self._description)
        values = {self._description.by_name[name]: value for name, value in given["start_values"]}
        self._slave.setup(self._block, values, start_time, stop_time)

    def _enter(self, data: bytes, given: dict[str, Any]) -> tuple[memoryview, dict[str, Any]]:
        """Enter initialization mode, in which driven inputs without a start value get the FMU's."""
        self._take_driven(0, data, given)
        self._slave.enter_initialization()
        section = self._block.inputs["String"]
        return self._driven.row(0), _texts(section, 0, section.driven)

    def _read(self) -> tuple[memoryview, dict[str, Any]]:
        self._slave.read(1)
        section = self._block.outputs["String"]
        return self._outputs.row(1), _texts(section, 1, len(section.variables))

    def _take_driven(self, row: int, data: bytes, given: dict[str, Any]) -> None:
        self._driven.row(row)[:] = data
        section = self._block.inputs["String"]
        if section.driven:
            section.values[row, : section.driven] = given[TEXTS]

    def _reply(self, number: int, operation: Operation, result: bytes | memoryview, content: dict[str, Any]) -> None:
        if messages := self._messages.take():
            content["log"] = messages
        text = json.dumps(content).encode() if content else b""
        head = REPLY.pack(number, operation, "error" in content, len(text), len(result))
        send(self._replies, b"".join((head, result, text)))


def _texts(section: Section, row: int, count: int) -> dict[str, Any]:
    return {TEXTS: section.values[row, :count].tolist()} if count else {}


def _not_kept(values: Mapping[str, Value]) -> dict[str, Any]:
    """Return parameters that are not what they were set to, as many as a reply has room for."""
    told: dict[str, Value] = {}
    room = MOST_REPLY // 4
    for name, value in values.items():
        room -= len(json.dumps([name, value]))
        if room < 0:
            break
        told[name] = value
    return {"not_kept": told} if told else {}


def _as_content(error: Exception) -> dict[str, Any]:
    """Write an error so that the master can raise its like."""
    if isinstance(error, EndRequestError):
        return {"kind": "end", "end": error.end, "message": _plain(error.message, _LONGEST_SENTENCE)}
    if isinstance(error, SlaveError):
        message = _plain(error.message, _LONGEST_SENTENCE)
        return {"kind": "call", "function": error.function, "status": error.status, "message": message}
    text = str(error) if isinstance(error, CosimError) else f"the FMU's process failed: {type(error).__name__}: {error}"
    return {"kind": "refused", "text": _plain(text, _LONGEST_SENTENCE), "file": isinstance(error, FmuFileError)}


def _plain(text: str, longest: int) -> str:
    """Return a text of bounded length that can be written in UTF-8, which names of files need not be."""
    return text[:longest].encode("utf-8", "replace").decode()


def limit_memory(most: int, note: Note) -> None:
    """See to it that this process holds at most so many bytes more than now, as far as it has to itself.

    On Linux the master looks at what is held, and the system refuses address space beyond twice the limit, and some for
    threads, at once, which an FMU sees as an allocation that fails. Elsewhere the process looks every 20 ms, also
    whether the master is still there.
    """
    if sys.platform == "linux":
        import resource

        space = _address_space() + 2 * most + _SET_ASIDE
        resource.setrlimit(resource.RLIMIT_AS, (space, space))
        return
    first, master = _most_held(), os.getppid()

    def look() -> None:
        while True:
            time.sleep(_LOOK)
            held = _most_held() - first
            if held > most:
                note.holding(held)
            if held > most or os.getppid() != master:
                os._exit(1)

    threading.Thread(target=look, daemon=True).start()


def _most_held() -> int:
    """Return the bytes of memory that this process has held at most, where the system tells (getrusage(2) on macOS)."""
    if sys.platform == "darwin":
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return 0


def _address_space() -> int:
    """Return the size of the address space on Linux (proc_pid_statm(5)), bytes."""
    return int(_PAGES.read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")


def work(note: str) -> None:
    """Take over standard input and output, which are the channel, so that what the FMU prints goes to standard error.

    Parameters
    ----------
    note : str
        Path of the file in which to note what is being done.
    """
    requests, replies = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    try:
        Worker(requests, replies, Note(Path(note))).work()
    except (EOFError, OSError):
        os._exit(1)
