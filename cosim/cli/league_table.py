"""Show the standings of a league on a terminal."""

from __future__ import annotations

from pathlib import Path

from rich.table import Table
from rich.text import Text

from cosim.cli.terminal import new_console
from cosim.league.playing import Standings
from cosim.league.table import explanations, headings, rows


def print_standings(standings: Standings, files: list[Path]) -> None:
    """Show who frees the string under which condition, and what was written where."""
    console = new_console()
    console.print(Text(standings.league.title, style="bold"))
    table = Table(box=None, pad_edge=False, header_style="bold")
    for number, heading in enumerate(headings(standings)):
        table.add_column(heading, overflow="fold", justify="right" if number else "left")
    for row in rows(standings):
        table.add_row(*(Text(each, style="red" if each in ("stuck", "fails") else "") for each in row))
    console.print(table)
    for sentence in explanations(standings):
        console.print(Text(sentence, style="dim"))
    for path in files:
        console.print(Text(f"wrote {path}"), soft_wrap=True)
