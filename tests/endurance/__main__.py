"""Let laws drill one after the other, show how they bore it, and say by the exit code whether all did."""

from __future__ import annotations

import logging
from functools import partial
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress, TaskID, TimeRemainingColumn
from rich.table import Table

from tests.endurance.endure import Outcome, endure
from tests.endurance.rigs import RIGS

WIDTH = 160
"""Of the table where it does not go to a terminal."""


def main(
    laws: Annotated[list[str] | None, typer.Argument(help=f"Any of {', '.join(RIGS)}; by default all.")] = None,
    hours: Annotated[float, typer.Option(min=0.0, help="How long each is to drill.")] = 24.0,
    seed: Annotated[int, typer.Option(min=0, help="Of what is drawn at random.")] = 1,
) -> None:
    """Let laws drill for hours, under weights and formations that change at random every 5 s."""
    for law in laws or ():
        if law not in RIGS:
            raise typer.BadParameter(f"there is no law '{law}'; expected one of {', '.join(RIGS)}")
    console = Console(width=None if Console().is_terminal else WIDTH)
    outcomes: dict[str, Outcome] = {}
    with Progress(*Progress.get_default_columns()[:3], TimeRemainingColumn(), console=console) as progress:
        for law in laws or RIGS:
            task = progress.add_task(law, total=1.0)
            outcomes[law] = endure(RIGS[law], hours, seed, partial(_show, progress, task))
            if not console.is_terminal:
                progress.console.print(f"{law}: {'; '.join(outcomes[law].faults) or 'held'}")
    console.print(_table(outcomes))
    for law, outcome in outcomes.items():
        for fault in outcome.faults:
            console.print(f"{law}: {fault}", style="red")
    raise typer.Exit(1 if any(outcome.faults for outcome in outcomes.values()) else 0)


def _show(progress: Progress, task: TaskID, done: float) -> None:
    """Show which part of a law's hours is over."""
    progress.update(task, completed=done)


def _table(outcomes: dict[str, Outcome]) -> Table:
    """Lay out how laws bore it."""
    table = Table(title="Laws that drill under weights and formations that change at random")
    headings = ("law", "hours", "times real time", "least Omega [rad/s]", "greatest", "at limits", "stuck", "verdict")
    for number, heading in enumerate(headings):
        table.add_column(heading, justify="right" if 0 < number < len(headings) - 1 else "left")
    for law, one in outcomes.items():
        table.add_row(
            law,
            f"{one.hours:.4g}",
            f"{one.rate:.0f}",
            f"{one.least_speed:.2f}",
            f"{one.greatest_speed:.2f}",
            f"{100.0 * one.limited:.1f} %",
            f"{100.0 * one.stuck:.1f} %",
            "failed" if one.faults else "held",
        )
    return table


if __name__ == "__main__":
    logging.disable(logging.WARNING)  # a day has breaks that are folded
    typer.run(main)
