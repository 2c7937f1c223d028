"""Show what has come of a tuning on a terminal."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from cosim.cli.terminal import new_console
from cosim.league.tuning.search import Tuned
from cosim.league.tuning.table import PARAMETERS, condition_rows, explanations, gain_rows, title_of


def print_tuned(tuned: Tuned, files: list[Path]) -> None:
    """Show gains and runs before and after, what was written where, and what to do with it."""
    console = new_console()
    console.print(Text(title_of(tuned), style="bold"))
    _print(console, ("gain", "as it was", "tuned", "from", "to"), gain_rows(tuned))
    _print(console, ("condition", "as it was", "tuned"), condition_rows(tuned))
    for sentence in explanations(tuned):
        console.print(Text(sentence, style="dim"))
    for path in files:
        console.print(Text(f"wrote {path}"), soft_wrap=True)
    written = next(path for path in files if path.name == PARAMETERS)
    console.print("next:")
    for command in ("run SCENARIO", "league"):
        console.print(Text(f"  cosim {command} --parameters {shlex.quote(str(written))}"), soft_wrap=True)


def _print(console: Console, headings: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Show a table."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    for number, heading in enumerate(headings):
        table.add_column(heading, overflow="fold", justify="right" if number else "left")
    for row in rows:
        table.add_row(*(Text(each, style="red" if each in ("stuck", "fails") else "") for each in row))
    console.print(table)
