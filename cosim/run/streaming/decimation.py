"""Which rows of which columns are stored: every one, every tenth, none, by name or pattern."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase

from cosim.errors import InputError, suggestion
from cosim.recording.rows import Column

EVERYTHING: Mapping[str, int] = {"*": 1}


def decimate(columns: Sequence[Column], every: Mapping[str, int]) -> dict[int, tuple[Column, ...]]:
    """Sort columns by how many rows apart they are stored.

    Parameters
    ----------
    columns : sequence of Column
        All that is recorded.
    every : mapping of str to int
        By name or pattern of names, as ``plant.*``: store every row (1), every tenth (10), none (0). Of several that
        match, the last holds; what none matches is stored in every row.

    Returns
    -------
    dict of int to tuple of Column
        By distance in rows, the smallest first; without those that are not stored.

    Raises
    ------
    InputError
        If a distance is negative, a name or pattern matches nothing, or nothing is left.
    """
    names = [column.name for column in columns]
    for pattern, distance in every.items():
        if distance < 0:
            raise InputError(f"every: {pattern} = {distance}; expected 0 or a number of rows")
        if not any(fnmatchcase(name, pattern) for name in names):
            raise InputError(f"every: there is no '{pattern}'{suggestion(pattern, names)}")
    chosen = {column: _distance(column.name, every) for column in columns}
    distances = sorted(set(chosen.values()) - {0})
    if not distances:
        raise InputError("every: nothing is stored; expected a distance other than 0 for something")
    return {each: tuple(column for column in columns if chosen[column] == each) for each in distances}


def axis(distance: int) -> str:
    """Return the name of the time axis of columns that are stored so many rows apart."""
    return "time" if distance == 1 else f"time_{distance}"


def _distance(name: str, every: Mapping[str, int]) -> int:
    """Return what the last pattern that matches says."""
    return next((every[pattern] for pattern in reversed(tuple(every)) if fnmatchcase(name, pattern)), 1)
