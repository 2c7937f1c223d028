"""Exchange bytes with the process of an isolated FMU, and never wait for it longer than a little while.

On POSIX systems that takes two pipes and poll(2). Windows cannot poll pipes: there threads wait in our stead.
"""

from __future__ import annotations

import os
import select
import subprocess
import sys
import threading
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import IO, Protocol, cast

from cosim.fmi2.isolation.protocol import PART

LOOK = 0.02
"""Seconds after which a channel that has to wait gives its owner a moment to look around."""


class Pipes(Protocol):
    """Send bytes to the process, and receive some."""

    def send(self, message: memoryview) -> int:
        """Send some bytes, and return how many; TimeoutError if none can be sent for now."""
        ...

    def receive(self, buffer: memoryview) -> int:
        """Receive some bytes, and return how many; 0 if there will be none, TimeoutError if there are none yet."""
        ...

    def close(self) -> None:
        """Say to the process that there is nothing more."""
        ...


def channel_to(process: subprocess.Popen[bytes]) -> Pipes:
    """Return the channel to a process that was started with pipes, unbuffered, as standard input and output."""
    to, back = cast(IO[bytes], process.stdin), cast(IO[bytes], process.stdout)
    return ThreadedPipes(to, back) if sys.platform == "win32" else PolledPipes(to, back)


class PolledPipes:
    """A channel of two pipes that are polled.

    Parameters
    ----------
    to, back : binary files without buffers
        Where to write to the process and where to read from it.
    """

    def __init__(self, to: IO[bytes], back: IO[bytes]) -> None:
        self._files = (to, back)
        self._to, self._back = to.fileno(), back.fileno()
        os.set_blocking(self._to, False)
        os.set_blocking(self._back, False)
        self._writable, self._readable = select.poll(), select.poll()
        self._writable.register(self._to, select.POLLOUT)
        self._readable.register(self._back, select.POLLIN)

    def send(self, message: memoryview) -> int:
        """Send some bytes."""
        try:
            return os.write(self._to, message)
        except BlockingIOError:
            self._writable.poll(1000 * LOOK)
            raise TimeoutError from None

    def receive(self, buffer: memoryview) -> int:
        """Receive some bytes."""
        if not self._readable.poll(1000 * LOOK):
            raise TimeoutError
        try:
            return os.readv(self._back, [buffer])
        except BlockingIOError:  # somebody else has read it
            raise TimeoutError from None

    def close(self) -> None:
        """Close both pipes."""
        for file in self._files:
            file.close()


class ThreadedPipes:
    """A channel of two pipes that threads write and read.

    Parameters
    ----------
    to, back : binary files without buffers
        Where to write to the process and where to read from it.
    """

    def __init__(self, to: IO[bytes], back: IO[bytes]) -> None:
        self._to, self._back = to, back
        self._outgoing: SimpleQueue[bytes | None] = SimpleQueue()
        self._incoming: SimpleQueue[bytes] = SimpleQueue()
        self._left = memoryview(b"")
        for task in (self._write, self._read):
            threading.Thread(target=task, daemon=True).start()

    def send(self, message: memoryview) -> int:
        """Have all bytes sent."""
        self._outgoing.put(bytes(message))
        return len(message)

    def receive(self, buffer: memoryview) -> int:
        """Receive some bytes."""
        if not self._left:
            try:
                self._left = memoryview(self._incoming.get(timeout=LOOK))
            except Empty:
                raise TimeoutError from None
        count = min(len(buffer), len(self._left))
        buffer[:count], self._left = self._left[:count], self._left[count:]
        return count

    def close(self) -> None:
        """Close the pipe to the process; the other is closed when the process has ended."""
        self._outgoing.put(None)

    def _write(self) -> None:
        with suppress(OSError), self._to:
            while (message := self._outgoing.get()) is not None:
                self._to.write(message)

    def _read(self) -> None:
        part = b"begun"
        with self._back:
            while part:
                try:
                    part = self._back.read(PART)
                except OSError:
                    part = b""
                self._incoming.put(part)
