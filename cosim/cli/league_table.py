"""Show on a terminal what has come of a league, and of tuning a law on its bench."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table
from rich.text import Text

from cosim.cli.terminal import new_console
from cosim.league.playing import Standings
from cosim.league.table import explanations, headings, rows

if TYPE_CHECKING:
    from cosim.league.tuning.search import Tuned


def print_standings(standings: Standings, files: list[Path]) -> None:
    """Show who frees the string under which condition, and what was written where."""
    console = new_console()
    console.print(Text(standings.league.title, style="bold"))
    _print_table(console, headings(standings), rows(standings))
    _print_remarks(console, explanations(standings), files)


def print_tuned(tuned: Tuned, files: list[Path]) -> None:
    """Show gains and runs before and after, what was written where, and what to do with it."""
    from cosim.league.tuning import table  # with SciPy, which a league does without

    console = new_console()
    console.print(Text(table.title_of(tuned), style="bold"))
    _print_table(console, ("gain", "as it was", "tuned", "from", "to"), table.gain_rows(tuned))
    _print_table(console, ("condition", "as it was", "tuned"), table.condition_rows(tuned))
    _print_remarks(console, table.explanations(tuned), files)
    written = next(path for path in files if path.name == table.PARAMETERS)
    console.print("next:")
    for command in ("run SCENARIO", "league"):
        console.print(Text(f"  cosim {command} --parameters {shlex.quote(str(written))}"), soft_wrap=True)


def _print_table(console: Console, headings: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Show a table, what became of nothing good in red."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for number, heading in enumerate(headings):
        table.add_column(heading, overflow="fold", justify="right" if number else "left")
    for row in rows:
        table.add_row(*(Text(each, style="red" if each in ("stuck", "fails") else "") for each in row))
    console.print(table)


def _print_remarks(console: Console, sentences: Iterable[str], files: Iterable[Path]) -> None:
    """Say what a table shows, and what was written where."""
    for sentence in sentences:
        console.print(Text(sentence, style="dim"))
    for path in files:
        console.print(Text(f"wrote {path}"), soft_wrap=True)
