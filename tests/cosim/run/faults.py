"""Faults of the disk, one at each single operation that changes a folder: it is full, or the program is killed.

A killed program does nothing more, so all later operations fail as well, clearing up among them.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

MODES = ("full once", "full", "killed")
GROWING = ("open", "write", "mkdir")
"""Operations that a full disk refuses."""
OTHERS = ("replace", "unlink", "ftruncate", "rmdir")


class KilledError(BaseException):
    """The end of a program that is killed."""


class Faults:
    """Count operations on a folder, and let one fail.

    Parameters
    ----------
    folder : Path
        The only one in which anything fails.
    mode : str
        Of `MODES`.
    at : int
        Which operation fails first, from 1 on; 0 for none.
    """

    def __init__(self, folder: Path, mode: str, at: int) -> None:
        self._folder, self._mode, self._at = str(folder), mode, at
        self.count = 0

    def strikes(self) -> bool:
        """Count an operation, and tell whether it is to fail."""
        self.count += 1
        return bool(self._at) and (self.count == self._at or (self.count > self._at and self._mode != "full once"))

    def fail(self) -> None:
        if self._mode == "killed":
            raise KilledError
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def concerns(self, target: Any) -> bool:
        """Tell whether an operation is on the folder."""
        path = os.readlink(f"/proc/self/fd/{target}") if isinstance(target, int) else os.fspath(target)
        return str(path).startswith(self._folder)

    def operation(self, name: str) -> Callable[..., Any]:
        """Return an operation that may fail."""
        real: Callable[..., Any] = getattr(os, name)

        def faulty(target: Any, *rest: Any, **options: Any) -> Any:
            creates = name != "open" or bool(rest[0] & (os.O_CREAT | os.O_TRUNC))
            if creates and self.concerns(target) and self.strikes():
                if name == "write":
                    real(target, bytes(rest[0])[: len(rest[0]) // 2])
                self.fail()
            return real(target, *rest, **options)

        return faulty


@contextmanager
def faults(folder: Path, mode: str, at: int) -> Generator[Faults]:
    """Let the disk fail at an operation on a folder while the block runs."""
    made = Faults(folder, mode, at)
    names = (*GROWING, *OTHERS) if mode == "killed" else GROWING
    with pytest.MonkeyPatch.context() as patch:
        operations = {name: made.operation(name) for name in names}
        for name, operation in operations.items():
            patch.setattr(os, name, operation)
        yield made
