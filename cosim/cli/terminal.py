"""What the command line shows: sentences when something goes wrong, progress, and what came of a run."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from cosim.cli.console_log import SentenceHandler, plain
from cosim.cli.statement import statement
from cosim.errors import CosimError, RunInterruptedError
from cosim.run.interrupt import interruptible

if TYPE_CHECKING:
    from cosim.run.job import Job, Outcome
    from cosim.scenario.scenario import Scenario

_WIDTH_OF_FILES = 120
_INTERRUPTED = 130


def new_console() -> Console:
    """Return a console on the present standard output; a file is wide enough for every table."""
    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=_WIDTH_OF_FILES)


@contextmanager
def sentences() -> Generator[None]:
    """Show what goes wrong as one sentence on standard error, and exit accordingly."""
    errors = Console(stderr=True, highlight=False, soft_wrap=True)
    handler = SentenceHandler(errors)
    logger = logging.getLogger("cosim")
    logger.addHandler(handler)
    try:
        yield
        handler.show_failures()
    except CosimError as error:
        errors.print(Text.assemble(("error: ", "bold red"), plain(str(error))))
        raise typer.Exit(error.exit_code) from None
    except RunInterruptedError as interrupted:
        how = f"go on with: cosim resume {interrupted.folder}" if interrupted.can_resume else "it cannot be resumed"
        errors.print(f"{interrupted}; {how}")
        raise typer.Exit(_INTERRUPTED) from None
    except KeyboardInterrupt:
        errors.print("interrupted; nothing was written")
        raise typer.Exit(_INTERRUPTED) from None
    finally:
        logger.removeHandler(handler)


def prepare_step_loop(job: Job) -> None:
    """Get the compiled step loop if the job takes it, and show that one waits where it has to be compiled first."""
    from cosim.master.stepping.step_library import step_library
    from cosim.run.assembly import chosen_method

    method = chosen_method(job.scenario, job.choices)
    isolated = job.choices.isolate or any(part.isolate for part in job.scenario.system.components)
    if method.compiled and not method.implicit and method.tolerance is None and not isolated:
        with Console(stderr=True).status("preparing the step loop; compiling it, once, takes some seconds"):
            step_library()


class Bar:
    """A progress bar for each variant."""

    def __init__(self, bars: Progress, check: Callable[[], None]) -> None:
        self._bars, self._check = bars, check
        self._tasks: dict[str, TaskID] = {}

    def show(self, job: Job) -> None:
        """Begin with all that will be run."""
        self._tasks = {label: self._bars.add_task(label, total=1.0) for label in job.labels}

    def progress(self, label: str, part: float) -> None:
        """Show which part of a variant is done; raises KeyboardInterrupt if there was a signal."""
        self._check()
        self._bars.update(self._tasks[label], completed=part)


@contextmanager
def progress_bar() -> Generator[Bar]:
    """Show progress, with the time left, if anybody watches."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
    with (
        interruptible() as check,
        Progress(
            *columns, TimeRemainingColumn(), console=console, transient=True, disable=not console.is_terminal
        ) as bars,
    ):
        yield Bar(bars, check)


def print_outcomes(scenario: Scenario, outcomes: dict[str, Outcome], folder: Path) -> None:
    """Show what came of a run."""
    console = new_console()
    console.print(Text(scenario.title or scenario.name, style="bold"))
    console.print(_summary(outcomes))
    _print_remarks(console, outcomes)
    _print_paths(console, folder)


def _summary(outcomes: dict[str, Outcome]) -> Table:
    """Tabulate the measures."""
    table = Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2))
    table.add_column("run", no_wrap=True)
    for heading in ("period [s]", "peak [rad/s]", "stuck fraction", "mean speed [rad/s]", "SSI"):
        table.add_column(Text(heading), justify="right", no_wrap=True)
    for label, outcome in outcomes.items():
        found = outcome.measures
        if found is None:
            table.add_row(label, *("-" * 5))
            continue
        period = "-" if found.period is None else f"{found.period:.7f}"
        numbers = (f"{found.peak:.4f}", f"{found.stuck_fraction:.6f}", f"{found.mean_speed:.6f}", f"{found.ssi:.4f}")
        table.add_row(label, period, *numbers)
    return table


def _print_remarks(console: Console, outcomes: dict[str, Outcome]) -> None:
    """Say over which window each was measured, how long the runs took, and how the coupling was computed."""
    for label, outcome in outcomes.items():
        record = outcome.record
        window = f"measured over {outcome.measures.window}" if outcome.measures else "nothing to measure"
        steps, seconds = record["steps"], record["timings"]["step"]
        size = f"{'at most ' if 'tolerance' in record else ''}{record['step_size']:g} s"
        took = f"{steps} steps of {size} ({record['algorithm']}) in {seconds:.3g} s"
        for sentence in (f"{window}; {took}", *statement(record)):
            console.print(Text(f"{label}: {sentence}", style="dim"), soft_wrap=True)


def _print_paths(console: Console, folder: Path) -> None:
    """Say what was written where, by the manifest."""
    from cosim.run.run_folder import MANIFEST, read_manifest

    manifest = read_manifest(folder) or {}
    variants = manifest["variants"]
    figures = [manifest["figure"]] if "figure" in manifest else [entry["figure"] for entry in variants]
    for name in (*(entry["trajectory"] for entry in variants), MANIFEST, *figures):
        console.print(Text(f"wrote {folder / name}"), soft_wrap=True)
