"""Show a league: a table to read, files to go on with, and a figure."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from cosim.errors import OutputError, printable
from cosim.files import replace_file, why
from cosim.league.playing import Limit, Standings
from cosim.league.score import COLUMNS, Score
from cosim.provenance import commit, versions
from cosim.recording.figure import blank_figure, save_figure

SCORES, LIMITS, FIGURE, ABOUT = "scores.csv", "limits.csv", "league.png", "league.json"
_FREE, _STUCK = "#dcebd9", "#f3d6cd"


def headings(standings: Standings) -> tuple[str, ...]:
    """Return the heads of the columns: conditions, and the laws as they are ranked."""
    return ("condition", *(law.name for law in standings.ranked()))


def rows(standings: Standings) -> Iterable[tuple[str, ...]]:
    """Return a row for each condition, one of how many are mastered, and one for each limit."""
    league, laws = standings.league, standings.ranked()
    for each in league.conditions:
        scores = [standings.scores[law.name, each.name] for law in laws]
        yield (f"{each.title} *" if each.hard else each.title, *map(cell, scores))
    total = len(league.conditions)
    freed = [sum(standings.scores[law.name, each.name].free for each in league.conditions) for law in laws]
    yield ("conditions mastered", *(f"{count}/{total}" for count in freed))
    for search in league.searches:
        yield (search.title, *(_limit(standings.limits[law.name, search.name]) for law in laws))


def cell(score: Score) -> str:
    """Write what became of the string: the time to free it, or that it stays stuck."""
    if score.failure:
        return "fails"
    if not score.free:
        return "stuck"
    return f"{score.time_to_free:.1f} s" if score.switched else "free"


def _limit(limit: Limit) -> str:
    """Write a limit; a + where nothing beyond it was tried."""
    if limit.value is None:
        return "-"
    return f"{limit.value:g}{'+' if limit.beyond else ''}"


def explanations(standings: Standings) -> list[str]:
    """Say what the table shows, and what failed."""
    said = [
        "a time is that from when the law is switched on, in full stick-slip, to when the bit is stuck last; a law "
        "without a switch acts from rest, and is said to leave the string free or stuck; * marks conditions that some "
        "good laws are known to fail, and + that nothing harder was tried"
    ]
    for (law, condition), score in standings.scores.items():
        if score.failure:
            said.append(f"{law}, {condition}: {score.failure}")
    return said


def prepare(folder: Path) -> None:
    """Make the folder that a league is written to.

    Raises
    ------
    OutputError
        If it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"output folder {folder} cannot be made: {why(error)}") from None


def write(standings: Standings, folder: Path) -> list[Path]:
    """Write scores and limits as CSV, a figure, and what was played with what, into a folder; return the files.

    Raises
    ------
    OutputError
        If the folder cannot be made.
    OSError
        If a file cannot be written.
    """
    prepare(folder)
    scores = [[*key, *standings.scores[key].record().values()] for key in standings.scores]
    limits = [[*key, each.value, each.beyond] for key, each in standings.limits.items()]
    league = standings.league
    about = {
        "title": league.title,
        "versions": versions(),
        "commit": commit(),
        "settle": league.settle,
        "judge": league.judge,
        "step_size": league.step_size,
        "laws": {
            law.name: {"title": law.title, "fmu": law.fmu, "parameters": dict(law.parameters)} for law in league.laws
        },
        "conditions": {each.name: each.title for each in league.conditions},
    }
    content = {
        SCORES: _rows(["law", "condition", *COLUMNS], scores),
        LIMITS: _rows(["law", "search", "value", "beyond"], limits),
        ABOUT: (json.dumps(about, indent=2) + "\n").encode(),
    }
    for name, written in content.items():
        replace_file(folder / name, written)
    save_figure(folder / FIGURE, lambda: _compose(standings))
    return [folder / name for name in (*content, FIGURE)]


def _rows(head: Sequence[str], content: Iterable[Sequence[object]]) -> bytes:
    """Return a CSV file; numbers to the last bit, nothing where there is no number."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([["" if _nothing(each) else each for each in row] for row in content])
    return text.getvalue().encode()


def _nothing(value: object) -> bool:
    """Tell whether there is no number."""
    return value is None or (isinstance(value, float) and math.isnan(value))


def _compose(standings: Standings) -> Any:
    """Draw the laws over the conditions, each field with its time and its SSI."""
    league, laws = standings.league, standings.ranked()
    count = len(league.conditions)
    figure = blank_figure(2.6 + 0.92 * count, 1.7 + 0.46 * len(laws))
    panel = figure.add_subplot()
    for row, law in enumerate(laws):
        for column, condition in enumerate(league.conditions):
            score = standings.scores[law.name, condition.name]
            colour = _FREE if score.free else _STUCK
            panel.fill_between([column - 0.47, column + 0.47], row - 0.44, row + 0.44, color=colour, linewidth=0.0)
            text = cell(score) if math.isnan(score.ssi) else f"{cell(score)}\nSSI {score.ssi:.2g}"
            panel.text(column, row, text, ha="center", va="center", fontsize=7)
    panel.set_xlim(-0.5, count - 0.5)
    panel.set_ylim(len(laws) - 0.5, -0.5)
    panel.set_xticks(range(count), [printable(each.title) for each in league.conditions], fontsize=7)
    panel.set_yticks(range(len(laws)), [printable(law.name) for law in laws], fontsize=8)
    panel.tick_params(length=0, labelbottom=False, labeltop=True)
    for label in panel.get_xticklabels():
        label.set_rotation(40)
        label.set_horizontalalignment("left")
    panel.spines[:].set_visible(False)
    figure.suptitle(printable(league.title), fontsize=11, x=0.01, ha="left")
    return figure
