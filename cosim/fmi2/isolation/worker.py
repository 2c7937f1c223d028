"""The process in which an isolated FMU runs: python -m cosim.fmi2.isolation.worker, asked through standard input.

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
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from cosim.errors import CosimError, EndRequestError, FmuFileError, SlaveError
from cosim.fmi2.fmu_slave import FmuSlave, open_fmu
from cosim.fmi2.isolation.protocol import (
    HEADER,
    REPLY,
    REQUEST,
    TEXTS,
    Operation,
    block_of,
    receive,
    send,
    shared_block,
)
from cosim.fmi2.model_description import read_description
from cosim.recording.record import Block
from cosim.system.description import Description

_LOOK = 0.02
# Address space that allocators set aside for threads without holding memory there: an arena and a stack each, bytes.
_SET_ASIDE = 2**28
_MOST_MESSAGES, _LONGEST_MESSAGE = 100, 1000
_PAGES = Path("/proc/self/statm")


class Messages(logging.Handler):
    """Keeps what the FMU says until it can be sent along with a reply."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self._kept: list[tuple[int, str, bool, str]] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a message, unless there are too many."""
        if len(self._kept) < _MOST_MESSAGES:
            category, says_why = getattr(record, "category", ""), getattr(record, "says_why", False)
            self._kept.append((record.levelno, category, says_why, record.getMessage()[:_LONGEST_MESSAGE]))

    def take(self) -> list[tuple[int, str, bool, str]]:
        """Return what has been kept, and forget it."""
        taken, self._kept = self._kept, []
        return taken


class Memory:
    """The memory shared with the master: until there is any, what is noted is noted nowhere."""

    def __init__(self) -> None:
        self._shared: mmap.mmap | None = None

    def share(self, path: Path) -> mmap.mmap:
        """Map a file."""
        with path.open("r+b") as file:
            self._shared = mmap.mmap(file.fileno(), 0)
        return self._shared

    def note(self, operation: Operation) -> None:
        """Note what is about to be done, in case it is the last thing."""
        if self._shared is not None:
            self._shared[0] = operation

    def note_held(self, held: int) -> None:
        """Note how much memory was too much."""
        if self._shared is not None:
            HEADER.pack_into(self._shared, 0, self._shared[0], held)


class Worker:
    """Does what it is asked to with one FMU."""

    def __init__(self, requests: int, replies: int) -> None:
        self._requests = requests
        self._replies = replies
        self._memory = Memory()
        self._messages = Messages()
        self._stack = ExitStack()
        self._description: Description
        self._slave: FmuSlave
        self._block: Block
        logging.getLogger("cosim").addHandler(self._messages)
        logging.getLogger("cosim").propagate = False

    def work(self) -> None:
        """Answer until told to close, or until the master is gone."""
        send(self._replies, REPLY.pack(False, 0))
        operation = Operation.START
        while operation is not Operation.CLOSE:
            number, write, slot, now, size, length = REQUEST.unpack(receive(self._requests, REQUEST.size))
            content: dict[str, Any] = json.loads(receive(self._requests, length)) if length else {}
            operation = Operation(number)
            error: dict[str, Any] | None = None
            try:
                if write >= 0:
                    self._memory.note(Operation.WRITE)
                    self._write(write, content)
                self._memory.note(operation)
                self._do(operation, slot, now, size, content)
            except CosimError as failure:
                error = _as_content(failure)
            self._reply(error, operation)

    def _do(self, operation: Operation, slot: int, now: float, size: float, content: dict[str, Any]) -> None:
        match operation:
            case Operation.STEP:
                self._slave.step(now, size)
                self._memory.note(Operation.READ)
                self._slave.read(1)
            case Operation.READ:
                self._slave.read(1)
            case Operation.SAVE:
                self._slave.save(slot)
            case Operation.RESTORE:
                self._slave.restore(slot)
            case Operation.SERIALISE:
                Path(content["state"]).write_bytes(self._slave.serialise())
            case Operation.DESERIALISE:
                self._slave.deserialise(Path(content["state"]).read_bytes(), now)
            case Operation.OPEN:
                self._open(content)
            case Operation.SETUP:
                self._set_up(content, now, size)
            case Operation.ENTER:
                self._slave.enter_initialization()
            case Operation.EXIT:
                self._slave.exit_initialization()
            case Operation.TERMINATE:
                self._slave.terminate()
            case Operation.CLOSE:
                self._stack.close()
            case Operation.START | Operation.WRITE:
                pass

    def _open(self, content: dict[str, Any]) -> None:
        limit_memory(int(content["memory"]), self._memory)
        path = Path(content["path"])
        self._description = read_description(path)
        self._slave = self._stack.enter_context(open_fmu(content["name"], path, self._description))

    def _set_up(self, content: dict[str, Any], start_time: float, stop_time: float) -> None:
        memory = self._memory.share(Path(content["memory"]))
        self._memory.note(Operation.SETUP)
        block = self._block = shared_block(block_of(content["shape"], self._description), memory)
        values = {self._description.by_name[name]: value for name, value in content["start_values"]}
        self._slave.setup(block, values, start_time, stop_time)

    def _write(self, row: int, content: dict[str, Any]) -> None:
        section = self._block.inputs["String"]
        if section.driven:
            section.values[row, : section.driven] = content[TEXTS]
        self._slave.write(row)

    def _reply(self, error: dict[str, Any] | None, operation: Operation) -> None:
        content: dict[str, Any] = {"error": error} if error else {}
        if not error and operation in (Operation.STEP, Operation.READ) and self._block.outputs["String"].variables:
            content[TEXTS] = self._block.outputs["String"].values[1].tolist()
        if messages := self._messages.take():
            content["log"] = messages
        text = json.dumps(content).encode() if content else b""
        send(self._replies, REPLY.pack(error is not None, len(text)) + text)


def _as_content(error: CosimError) -> dict[str, Any]:
    """Write an error so that the master can raise its like."""
    if isinstance(error, EndRequestError):
        return {"end": error.end, "message": error.message[:_LONGEST_MESSAGE]}
    if isinstance(error, SlaveError):
        return {"function": error.function, "status": error.status, "message": error.message[:_LONGEST_MESSAGE]}
    return {"text": str(error)[: 10 * _LONGEST_MESSAGE], "file": isinstance(error, FmuFileError)}


def limit_memory(most: int, memory: Memory) -> None:
    """End this process when it holds more bytes than now by `most`, or when the master is gone.

    Memory that is held is looked at every 20 ms. Where the system can (on Linux), it refuses address space beyond twice
    the limit, and some for threads, at once, which an FMU sees as an allocation that fails. No core is dumped.
    """
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if sys.platform == "linux":
            space = _pages()[0] + 2 * most + _SET_ASIDE
            resource.setrlimit(resource.RLIMIT_AS, (space, space))
    first = _held()
    master = os.getppid()

    def look() -> None:
        while True:
            time.sleep(_LOOK)
            held = _held() - first
            if held > most:
                memory.note_held(held)
                os._exit(1)
            if os.getppid() != master:
                os._exit(1)

    threading.Thread(target=look, daemon=True).start()


def _held() -> int:
    """Return the bytes of memory that this process holds, or has held where the system tells only that."""
    if sys.platform == "linux":
        return _pages()[1]
    if sys.platform == "darwin":
        import resource

        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return 0


def _pages() -> tuple[int, int]:
    """Return address space and resident memory on Linux (proc_pid_statm(5)), bytes."""
    size = os.sysconf("SC_PAGE_SIZE")
    total, resident = _PAGES.read_text().split()[:2]
    return int(total) * size, int(resident) * size


def main() -> None:
    """Take over standard input and output, which are the pipes, so that what the FMU prints goes to standard error."""
    requests, replies = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    try:
        Worker(requests, replies).work()
    except (EOFError, BrokenPipeError):
        os._exit(1)


if __name__ == "__main__":
    main()
