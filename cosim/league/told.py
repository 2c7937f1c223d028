"""Gather what a report says of leagues that were played."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cosim.errors import InputError
from cosim.files import read_file, why
from cosim.league.score import COLUMNS, Score
from cosim.league.table import ABOUT, LIMITS, SCORES, cell

_MOST_BYTES = 10**8
_NUMBERS = {
    "time_to_free": "time to free [s]",
    "stuck_fraction": "stuck fraction",
    "ssi": "SSI",
    "mean_bit_speed": "mean bit speed [rad/s]",
    "peak_bit_speed": "peak bit speed [rad/s]",
    "least_bit_speed": "least bit speed [rad/s]",
    "greatest_torque": "greatest torque [N.m]",
    "drive_swing": "swing of the drive [rad/s]",
    "penetration": "penetration [m/h]",
    "energy_per_turn": "energy a turn [kJ]",
}


@dataclass(frozen=True)
class Field:
    """A field of the table: a law under a condition.

    Attributes
    ----------
    text, ssi : str
        What became of the string, and the stick-slip index.
    free : bool
        Whether the bit is not stuck at the end.
    """

    text: str
    ssi: str
    free: bool


def gather(folders: Sequence[Path], units: str) -> dict[str, Any]:
    """Return what the page of some leagues shows.

    Parameters
    ----------
    folders : sequence of Path
        That leagues were written to.
    units : str
        A league is told in SI alone.

    Raises
    ------
    InputError
        If a file cannot be read, or is not as it was written, or other units are asked for.
    """
    if units != "si":
        raise InputError(f"a league is told in SI units; expected --units si, not {units}")
    leagues = [_league(folder) for folder in dict.fromkeys(folders)]
    titles = list(dict.fromkeys(each["title"] for each in leagues))
    return {"title": titles[0] if len(titles) == 1 else "Leagues compared", "leagues": leagues, "drawn": None}


def _league(folder: Path) -> dict[str, Any]:
    """Read what a folder tells of a league."""
    with _undamaged(folder):
        about: dict[str, Any] = json.loads(_text(folder / ABOUT))
        scores = {(row["law"], row["condition"]): _score(row) for row in _rows(folder / SCORES)}
        limits = {(row["law"], row["search"]): row for row in _rows(folder / LIMITS)}
        conditions = {str(name): str(title) for name, title in about["conditions"].items()}
        laws = sorted(about["laws"], key=lambda law: -sum(scores[law, name].free for name in conditions))
        mastered = [sum(scores[law, name].free for name in conditions) for law in laws]
        return {
            "title": str(about["title"]),
            "folder": str(folder),
            "laws": [_law(name, about["laws"][name]) for name in laws],
            "names": laws,
            "rows": [(title, [_field(scores[law, name]) for law in laws]) for name, title in conditions.items()],
            "mastered": [f"{count} of {len(conditions)}" for count in mastered],
            "limits": _limits(laws, limits),
            "numbers": [
                (law, title, [_number(getattr(scores[law, name], key)) for key in _NUMBERS])
                for law in laws
                for name, title in conditions.items()
            ],
            "number_headings": list(_NUMBERS.values()),
            "failures": [(*key, score.failure) for key, score in scores.items() if score.failure],
            "times": {name: float(about[name]) for name in ("settle", "judge", "step_size")},
            "versions": {str(name): str(each) for name, each in about["versions"].items()},
            "commit": about.get("commit") or "not known",
        }


@contextmanager
def _undamaged(folder: Path) -> Generator[None]:
    """Say in a sentence that files are not as a league has written them."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{folder} cannot be read: {error.filename or ''} {why(error)}") from error
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError, RecursionError, csv.Error) as error:
        what = f"{error} is missing" if isinstance(error, KeyError) else why(error)
        raise InputError(f"{folder} holds a league that is damaged: {what}") from error


def _text(path: Path) -> str:
    """Read a file."""
    return read_file(path, _MOST_BYTES, follow=False).decode("utf-8")


def _rows(path: Path) -> list[dict[str, str]]:
    """Read a table, of which each row has as many cells as the head."""
    rows = csv.DictReader(io.StringIO(_text(path), newline=""), restkey="", restval=None, strict=True)
    found = [dict(row) for row in rows]
    if any("" in row or None in row.values() for row in found):
        raise ValueError(f"{path.name} has rows of other lengths than its head")
    return found


def _score(row: Mapping[str, str]) -> Score:
    """Read a row of scores; nothing stands for no number."""
    numbers = {
        name: float(row[name]) if row[name] else math.nan for name in COLUMNS if name not in ("switched", "failure")
    }
    return Score(**numbers, switched=row["switched"] == "True", failure=row["failure"])


def _field(score: Score) -> Field:
    """Return the field of a score."""
    return Field(cell(score), "" if math.isnan(score.ssi) else f"{score.ssi:.2g}", score.free)


def _law(name: str, told: Mapping[str, Any]) -> tuple[str, str, str, str]:
    """Return name, title, FMU and parameters of a law."""
    given = ", ".join(f"{key} = {value}" for key, value in told["parameters"].items())
    return name, str(told["title"]), str(told["fmu"]) or "none", given or "as the FMU has them"


def _limits(laws: Sequence[str], limits: Mapping[tuple[str, str], Mapping[str, str]]) -> list[tuple[str, list[str]]]:
    """Return the limits by search, in the order of laws; a + where nothing beyond was tried."""
    searches = dict.fromkeys(search for _, search in limits)
    return [(search, [_limit(limits[law, search]) for law in laws]) for search in searches]


def _limit(row: Mapping[str, str]) -> str:
    """Write a limit."""
    if not row["value"]:
        return "none"
    return f"{float(row['value']):g}{'+' if row['beyond'] == 'True' else ''}"


def _number(value: float) -> str:
    """Write a number; a dash for none."""
    return "-" if math.isnan(value) else f"{value:.4g}"
