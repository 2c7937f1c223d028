"""Ask, watch and end the process of an isolated FMU.

All that keeps it within its limits is done from here, where it has no say: whoever waits for a reply looks now and then
at the time, at the memory that the process and its descendants hold, and whether the process is still there. It is no
sandbox: the process may do whatever its user may.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from cosim.fmi2.isolation import Limits
from cosim.fmi2.isolation.channel import LOOK, Pipes, channel_to
from cosim.fmi2.isolation.family import Family, end_session
from cosim.fmi2.isolation.protocol import MOST_REPLY, MOST_STATE, NOTE, PART, REPLY, REQUEST, Operation

if TYPE_CHECKING:
    from cosim.fmi2.isolation.reply import Content

START_LIMIT = 120.0
"""Seconds that Python may take to start and import what the process needs."""

_FAREWELL = 5.0


class ProcessLostError(Exception):
    """The process is gone; the text says how, as the end of a sentence that begins with "the FMU"."""


class Reply(NamedTuple):
    """Hold an answer of the process: whether the operation failed, numbers, and what else there is to say, if any."""

    failed: bool
    data: memoryview
    content: Content | None


class IsolatedProcess:
    """A process in which one FMU will be loaded.

    Parameters
    ----------
    folder : Path
        For all temporary files of the process; the caller removes it afterwards.
    limits : Limits
        What to allow.

    Raises
    ------
    OSError
        If there is no more room for a process.
    """

    def __init__(self, folder: Path, limits: Limits) -> None:
        self._limits = limits
        self._patience = min(_FAREWELL, limits.time)
        self._number = 0
        self._asked = Operation.START
        self._first = self._first_shared_out = 0
        self._gone = self._stopped = False
        self._buffer = memoryview(bytearray(PART))
        note = folder / "note"
        note.write_bytes(bytes(NOTE.size))
        self._deadline, self._looked = time.monotonic() + START_LIMIT, time.monotonic()
        self._process, self._channel = _start(folder, note)
        self._note = note.open("rb")
        self._family = Family(self._process.pid)

    def ask(
        self, operation: Operation, write: int = -1, *, slot: int = 0, time_: float = 0.0, size: float = 0.0,
        data: bytes | bytearray = b"", content: dict[str, Any] | None = None, expected: int = 0,
    ) -> Reply:  # fmt: skip
        """Have an operation done, after the inputs of a row have been written if `write` is one.

        Parameters
        ----------
        operation, write, slot, time_, size, data, content
            What the request says.
        expected : int
            Bytes of numbers in the reply; of states `MOST_STATE`, which is the most.

        Raises
        ------
        ProcessLostError
            If the process ends instead of answering, or does not answer in time or to the point.
        """
        if operation is Operation.OPEN:
            self._first, self._first_shared_out = self._family.held(), self._family.shared_out()
        text = json.dumps(content).encode() if content is not None else b""
        self._asked = operation
        self._number += 1
        now = time.monotonic()
        self._deadline = now + self._limits.time
        if now > self._looked + LOOK:
            self._look()
        head = REQUEST.pack(self._number, operation, write, slot, time_, size, len(data), len(text))
        self._send(memoryview(b"".join((head, data, text))))
        return self._reply(expected)

    def await_start(self) -> None:
        """Wait until the process can be asked; ProcessLostError if it cannot be started."""
        self._reply(0)
        self._number = int.from_bytes(os.urandom(7))  # so that no reply can be made before its request is known

    def end(self) -> None:
        """End the process and whatever it has started, at once unless it is about to end by itself."""
        self._channel.close()
        if self._asked is Operation.CLOSE:
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(self._patience)
        self._stop()
        self._note.close()

    def _send(self, message: memoryview) -> None:
        while message:
            try:
                message = message[self._channel.send(message) :]
            except TimeoutError:
                self._look()
            except OSError:
                raise ProcessLostError(self._how_it_ended()) from None

    def _reply(self, expected: int) -> Reply:
        """Receive one reply; one that is not to the present request, or followed by more, is none."""
        got = self._receive(self._buffer)
        while got < REPLY.size:
            got += self._receive(self._buffer[got:])
        number, operation, failed, text, data = REPLY.unpack_from(self._buffer)
        least, most = (0, 0) if failed else (0, MOST_STATE) if expected == MOST_STATE else (expected, expected)
        fits = least <= data <= most and text <= MOST_REPLY and failed in (False, True)
        if (number, operation) != (self._number, self._asked) or not fits:
            raise self._nonsense()
        size = REPLY.size + data + text
        message = self._buffer[:got] if got >= size else self._rest(got, size)
        if len(message) != size:
            raise self._nonsense()
        body = message[REPLY.size :]
        return Reply(bool(failed), body[:data], self._content(bytes(body[data:])) if text else None)

    def _rest(self, got: int, size: int) -> memoryview:
        """Receive what does not come, or does not fit, at once."""
        message = bytearray(self._buffer[:got])
        while len(message) < size:
            self._see_to_deadline()
            message += self._buffer[: self._receive(self._buffer)]
        return memoryview(message)

    def _content(self, text: bytes) -> Content:
        from cosim.fmi2.isolation.reply import read_content  # with pydantic, which silent FMUs do without

        try:
            return read_content(text)
        except ValueError:
            raise self._nonsense() from None

    def _receive(self, buffer: memoryview) -> int:
        """Wait for some bytes."""
        while True:
            try:
                count = self._channel.receive(buffer)
            except TimeoutError:
                self._look()
                continue
            except OSError:
                count = 0
            if not count:
                raise ProcessLostError(self._how_it_ended())
            return count

    def _look(self) -> None:
        """See that there still is a process, and that it keeps its limits."""
        self._looked = time.monotonic()
        self._see_to_deadline()
        if self._gone:  # and has left nothing to receive, although somebody else may hold its end of the channel
            raise ProcessLostError(self._how_it_ended())
        self._gone = self._process.poll() is not None
        if self._family.held() - self._first > self._limits.memory:
            held = self._family.shared_out() - self._first_shared_out
            if held > self._limits.memory:
                raise self._stopped_for_memory(held)

    def _see_to_deadline(self) -> None:
        if time.monotonic() > self._deadline:
            self._stop()
            raise ProcessLostError(f"hung {self._where()[0]} and was stopped after {self._limits.time:g} s")

    def _nonsense(self) -> ProcessLostError:
        self._stop()
        return ProcessLostError(f"answered nonsense {self._asked.phrase} and was stopped")

    def _stopped_for_memory(self, held: int) -> ProcessLostError:
        where, _ = self._where()
        self._stop()
        most = f"expected at most {self._limits.memory / 1e6:.0f} MB"
        return ProcessLostError(f"was stopped {where} because it held {held / 1e6:.0f} MB of memory; {most}")

    def _how_it_ended(self) -> str:
        """Say how the process ended; one that has merely closed its end of the channel is ended first."""
        try:
            code = self._process.wait(self._patience)
        except subprocess.TimeoutExpired:
            self._stop()
            return f"closed the channel to the master {self._asked.phrase} and was stopped"
        self._stop()
        where, held = self._where()
        if held and sys.platform != "linux":
            return str(self._stopped_for_memory(held))
        how = fault(code)
        return f"crashed {where} ({how})" if how else f"ended its process {where} (exit code {code})"

    def _where(self) -> tuple[str, int]:
        """Return what the process has noted that it is doing, and how much it held if that was too much."""
        self._note.seek(0)
        note = self._note.read(NOTE.size)
        doing, held = NOTE.unpack(note) if len(note) == NOTE.size else (0, 0)
        known = Operation.START < doing < len(Operation)
        return (Operation(doing) if known else self._asked).phrase, held

    def _stop(self) -> None:
        """End the process and all its descendants now, unless that has been done.

        The keeper does it when told to; one that does not obey, or is gone before its time, is ended last.
        """
        if self._stopped:
            return
        self._stopped = True
        if sys.platform == "linux":
            if self._process.poll() is None:
                self._family.look()
                self._process.send_signal(signal.SIGTERM)
                self._process.send_signal(signal.SIGCONT)  # in case the FMU has stopped it
                with suppress(subprocess.TimeoutExpired):
                    self._process.wait(self._patience)
            self._family.end(self._patience)
        if sys.platform != "linux" or self._process.poll() is None:
            end_session(self._process.pid)
            self._process.wait()


def _start(folder: Path, note: Path) -> tuple[subprocess.Popen[bytes], Pipes]:
    """Start the process, in a session of its own so that Ctrl-C reaches only the master."""
    package = str(Path(__file__).resolve().parents[3])
    paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
    temporary = dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(folder))
    command = [sys.executable, "-P", "-m", "cosim.fmi2.isolation.keeper", str(os.getpid()), str(note)]
    environment = {**os.environ, **temporary, "PYTHONPATH": os.pathsep.join(paths)}
    process = subprocess.Popen(
        command,
        bufsize=0,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment,
        start_new_session=sys.platform != "win32",
        creationflags=subprocess.CREATE_NEW_PROCESS_GROUP if sys.platform == "win32" else 0,
    )
    return process, channel_to(process)


_WINDOWS = {0xC0000005: "access violation", 0xC00000FD: "stack overflow", 0xC0000409: "stack buffer overrun"}


def fault(code: int) -> str | None:
    """Name the signal or Windows exception that an exit code stands for; None if the process has ended itself."""
    if code < 0:
        names = {number.value: number.name for number in signal.Signals}
        return names.get(-code, f"signal {-code}")
    return _WINDOWS.get(code & 0xFFFFFFFF)
