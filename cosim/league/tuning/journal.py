"""Keep what has been played in a file, a line for each run as it ends: a tuning that is killed goes on from there."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

from cosim.errors import CheckpointError, OutputError
from cosim.files import UnfitFileError, locked, open_file, read_file, replace_file, why, write_all
from cosim.league.score import COLUMNS, Score

FILE = "evaluations.jsonl"
MOST_BYTES = 2**30
Key = tuple[str, str]
"""The values that were tried, as JSON, and the name of a condition."""


def key_of(values: Mapping[str, float], condition: str) -> Key:
    """Return what a run is known by; no values are the law as it is."""
    return json.dumps(dict(values)), condition


class EvaluationLog:
    """Runs that have been played.

    Parameters
    ----------
    path : Path
        The file.
    descriptor : int
        Of it, at its end.
    found : dict of (str, str) to Score
        What is in it.
    """

    def __init__(self, path: Path, descriptor: int, found: dict[Key, Score]) -> None:
        self.path, self.found = path, found
        self._descriptor = descriptor

    def append(self, key: Key, score: Score) -> None:
        """Keep a run; it outlives a loss of power from now on.

        Raises
        ------
        OutputError
            If it cannot be written.
        """
        values, condition = key
        line = {"values": json.loads(values), "condition": condition, "score": _plain(score)}
        try:
            write_all(self._descriptor, (json.dumps(line) + "\n").encode())
            os.fsync(self._descriptor)
        except OSError as error:
            raise OutputError(f"{self.path} cannot be written: {why(error)}") from None
        self.found[key] = score


@contextmanager
def opened_journal(folder: Path, identity: Mapping[str, Any]) -> Generator[EvaluationLog]:
    """Open the journal of a folder, which is made if it is not there.

    Parameters
    ----------
    folder : Path
        Of the tuning, held for one program at a time.
    identity : mapping
        All that decides what a run gives and which ones follow, as JSON can hold it.

    Raises
    ------
    CheckpointError
        If the folder holds another tuning, or its journal is damaged, or another program goes on with it.
    OutputError
        If it cannot be read or written.
    """
    path = folder / FILE
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with locked(folder) as free:
            if not free:
                raise CheckpointError(f"{folder}: another program is tuning there")
            if not path.exists():
                replace_file(path, (json.dumps({"tuning": identity}) + "\n").encode())
            found, end = _read(path, identity)
            descriptor = open_file(path, os.O_RDWR | os.O_APPEND)
            try:
                os.ftruncate(descriptor, end)
                yield EvaluationLog(path, descriptor, found)
            finally:
                os.close(descriptor)
    except OSError as error:
        reason = str(error) if isinstance(error, UnfitFileError) else why(error)
        raise OutputError(f"output folder {folder} cannot be used: {reason}") from None


def _read(path: Path, identity: Mapping[str, Any]) -> tuple[dict[Key, Score], int]:
    """Return what is in a journal, and where its last complete line ends."""
    content = read_file(path, MOST_BYTES, follow=False)
    end = content.rfind(b"\n") + 1  # a program that was killed may have left a part of a line
    lines = content[:end].splitlines()
    found: dict[Key, Score] = {}
    if not lines:
        raise CheckpointError(f"{path} is empty; expected a tuning, or no such file")
    for number, line in enumerate(lines, 1):
        try:
            entry: dict[str, Any] = json.loads(line)
            if number == 1:
                _refuse_other(path, entry["tuning"], identity)
            else:
                found[key_of(entry["values"], str(entry["condition"]))] = _score(entry["score"])
        except (ValueError, KeyError, TypeError, AttributeError):
            raise CheckpointError(f"{path}, line {number}: it is damaged; expected a run as it was written") from None
    return found, end


def _refuse_other(path: Path, before: Mapping[str, Any], now: Mapping[str, Any]) -> None:
    """Refuse to go on with a tuning of something else, and name what differs."""
    same: dict[str, Any] = json.loads(json.dumps(now))
    other = [name for name in {**before, **same} if before.get(name) != same.get(name)]
    if other:
        differ = ", ".join(f"{name}{_short(before.get(name))}" for name in other)
        raise CheckpointError(f"{path} is of another tuning, by {differ}; expected the same, or another --output")


def _short(value: object) -> str:
    """Write what a tuning was begun with, if that takes little room."""
    return f" ({value})" if isinstance(value, int | float | str) and len(str(value)) <= 40 else ""


def _plain(score: Score) -> dict[str, Any]:
    """Return a score as JSON has it, which has no infinite numbers."""
    return {name: str(each) if isinstance(each, float) and not math.isfinite(each) else each
            for name, each in score.record().items()}  # fmt: skip


def _score(record: Mapping[str, Any]) -> Score:
    """Return a score that was kept."""
    if set(record) != set(COLUMNS):
        raise ValueError("another score")
    numbers = {name: float(cast(float, each)) for name, each in record.items() if name not in ("switched", "failure")}
    return Score(**numbers, switched=bool(record["switched"]), failure=str(record["failure"]))
