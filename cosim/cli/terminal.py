"""Write to the terminal: sentences, progress, and the report of a run.

Errors and log messages are one sentence each. Of a run, measures are shown as a table, and then how well the coupling
was computed and what is not known of it.
"""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.console import Console, ConsoleOptions, RenderableType
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from cosim.errors import (
    CosimError,
    RunError,
    RunInterruptedError,
    SweepInterruptedError,
    TuningInterruptedError,
    printable,
)
from cosim.report.statement import count, statement

if TYPE_CHECKING:
    from cosim.run.job import Job
    from cosim.run.report import CouplingReport, Manifest

_WIDTH_OF_FILES = 120
_WIDE = 10_000
_INTERRUPTED = 130


class SafeConsole(Console):
    """A console on which texts act upon nothing, wherever they are from, and whose reader may leave.

    All that is shown goes through one place. Where nobody reads any more, what is being done goes on.
    """

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterator[Segment]:
        """Write out, in every piece of text, what a terminal would be led astray by; what rich adds stays."""
        for segment in super().render(renderable, options):
            harmless = segment.control is not None or segment.text.isprintable()
            yield segment if harmless else Segment(printable(segment.text), segment.style)

    def on_broken_pipe(self) -> None:
        """Write nothing more, and leave nothing for the interpreter to write at its end; rich would exit with 1."""
        self.quiet = True
        with suppress(OSError, ValueError), open(os.devnull, "w", encoding="utf-8") as nowhere:
            os.dup2(nowhere.fileno(), sys.stdout.fileno())


def new_console() -> Console:
    """Return a console on the present standard output; a file is wide enough for every table."""
    console = SafeConsole(highlight=False)
    return console if console.is_terminal else SafeConsole(highlight=False, width=_WIDTH_OF_FILES)


@contextmanager
def sentences() -> Generator[None]:
    """Show what goes wrong as one sentence on standard error, and exit accordingly."""
    errors = SafeConsole(stderr=True, highlight=False, soft_wrap=True)
    handler = SentenceHandler(errors)
    logger = logging.getLogger("cosim")
    logger.addHandler(handler)
    try:
        yield
        handler.show_failures()
    except CosimError as error:
        errors.print(Text.assemble(("error: ", "bold red"), one_line(str(error)) or type(error).__name__))
        raise typer.Exit(error.exit_code) from None
    except MemoryError:
        errors.print(Text.assemble(("error: ", "bold red"), "there is not enough memory for what is asked for"))
        raise typer.Exit(RunError.exit_code) from None
    except RunInterruptedError as interrupted:
        how = f"go on with: cosim resume {interrupted.folder}" if interrupted.can_resume else "it cannot be resumed"
        errors.print(Text(one_line(f"{interrupted}; {how}")))
        raise typer.Exit(_INTERRUPTED) from None
    except SweepInterruptedError as interrupted:
        errors.print(Text(one_line(f"{interrupted}; the same command goes on with it")))
        raise typer.Exit(_INTERRUPTED) from None
    except TuningInterruptedError as interrupted:
        errors.print(Text(one_line(str(interrupted))))
        raise typer.Exit(_INTERRUPTED) from None
    except KeyboardInterrupt:
        errors.print("interrupted; nothing was written")
        raise typer.Exit(_INTERRUPTED) from None
    finally:
        logger.removeHandler(handler)


def prepare_step_loop(job: Job) -> None:
    """Get the compiled step loop if the job takes it, and show that one waits where it has to be compiled first."""
    from cosim.master.compiled_loop import step_library

    method = job.options.method(job.scenario)
    isolated = job.options.isolate or any(part.isolate for part in job.scenario.system.components)
    if method.compiled and not method.implicit and method.tolerance is None and not isolated:
        with SafeConsole(stderr=True).status("preparing the step loop; compiling it, once, takes some seconds"):
            step_library()


class Bar:
    """A progress bar for each variant."""

    def __init__(self, bars: Progress, check: Callable[[], None]) -> None:
        self._bars, self._check = bars, check
        self._tasks: dict[str, TaskID] = {}

    def show(self, job: Job) -> None:
        """Begin with all that will be run."""
        self._tasks = {label: self._bars.add_task(escape(label), total=1.0) for label in job.labels}

    def progress(self, label: str, part: float) -> None:
        """Show which part of a variant is done; raises KeyboardInterrupt if there was a signal."""
        self._check()
        self._bars.update(self._tasks[label], completed=part)

    def one_task(self, title: str, *, at_once: bool = True) -> Callable[[str, float], None]:
        """Begin a bar for all of a task; what is returned takes what has been done last, and which part is done."""
        task = self._bars.add_task(title, total=1.0, visible=at_once)

        def update(done: str, part: float) -> None:
            self._check()
            self._bars.update(task, description=f"{title}: {done}", completed=part, visible=True)

        return update


@contextmanager
def progress_bar() -> Generator[Bar]:
    """Show progress, with the time left, if anybody watches."""
    from cosim.run.stream import interruptible  # with NumPy, which help and lists do without

    console = SafeConsole(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
    with (
        interruptible() as check,
        Progress(
            *columns, TimeRemainingColumn(), console=console, transient=True, disable=not console.is_terminal
        ) as bars,
    ):
        yield Bar(bars, check)


def print_manifest(manifest: Manifest, folder: Path) -> None:
    """Show what came of a run, and what was written where."""
    console = new_console()
    console.print(Text(manifest.title or manifest.scenario, style="bold"))
    _print_summary(console, manifest)
    _print_remarks(console, manifest)
    for name in manifest.files:
        console.print(Text(f"wrote {folder / name}"), soft_wrap=True)


def _print_summary(console: Console, manifest: Manifest) -> None:
    """Show the measures as a table or, where that is too wide for the terminal, one by one: numbers are never cut."""
    from cosim.drilling import reporting

    table = _summary(manifest)
    if console.measure(table, options=console.options.update(width=_WIDE)).maximum <= console.width:
        console.print(table)
        return
    for variant in manifest.variants:
        console.print(Text(variant.label, style="bold"), soft_wrap=True)
        for heading, cell in zip(reporting.headings(), variant.findings.cells(), strict=True):
            console.print(Text(f"  {heading}: {cell}"), soft_wrap=True)


def _summary(manifest: Manifest) -> Table:
    """Tabulate the measures."""
    from cosim.drilling import reporting

    table = Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2))
    table.add_column("run", no_wrap=True)
    for heading in reporting.headings():
        table.add_column(Text(heading), justify="right", no_wrap=True)
    for variant in manifest.variants:
        table.add_row(Text(printable(variant.label)), *variant.findings.cells())
    return table


def _print_remarks(console: Console, manifest: Manifest) -> None:
    """Say over which window each was measured, how long the runs took, and how the coupling was computed."""
    for variant in manifest.variants:
        coupling = variant.run.coupling
        seconds = coupling.timings.get("step", 0.0)
        size = f"{'' if _even(coupling) else 'at most '}{coupling.step_size:g} s"
        took = f"{count(coupling.steps, 'step')} of {size} ({coupling.algorithm}) in {seconds:.3g} s"
        for sentence in (f"{variant.findings.sentence()}; {took}", *statement(coupling)):
            console.print(Text(f"{variant.label}: {sentence}", style="dim"), soft_wrap=True)


def _even(coupling: CouplingReport) -> bool:
    """Tell whether all steps were of one size: none shortened to meet a jump or the end, or as a tolerance asks."""
    end = coupling.stop_time if coupling.ended is None else coupling.ended["time"]
    taken = coupling.steps * coupling.step_size
    return coupling.tolerance is None and abs(end - coupling.start_time - taken) <= 1e-6 * coupling.step_size


_FMU = "cosim.fmi2."


class SentenceHandler(logging.Handler):
    """Shows warnings as they come, but holds back what an FMU says about a failed call.

    If the failure ends the run, its error says the same; if not, `show_failures` makes up for it.

    Parameters
    ----------
    console : rich.console.Console
        Where to write.
    """

    def __init__(self, console: Console) -> None:
        super().__init__(logging.WARNING)
        self._console = console
        self._failures: list[logging.LogRecord] = []
        self._shown: set[tuple[str, str]] = set()

    def emit(self, record: logging.LogRecord) -> None:
        """Show a message, or hold it back."""
        if getattr(record, "says_why", False):
            self._failures.append(record)
        else:
            self._show(record)

    def show_failures(self) -> None:
        """Show what was held back."""
        for record in self._failures:
            self._show(record)

    def _show(self, record: logging.LogRecord) -> None:
        """Write one sentence; what an FMU says again when a step is repeated is written once."""
        name, message = record.name.removeprefix(_FMU), one_line(record.getMessage())
        said = message.startswith((f"{name} at t = ", f"{name}: "))
        instance = f"{name}: " if record.name.startswith(_FMU) and not said else ""
        is_new = not record.name.startswith(_FMU) or (name, message) not in self._shown
        level = "warning" if record.levelno < logging.ERROR else "error"
        if is_new:
            self._console.print(Text.assemble((f"{level}: ", "bold yellow"), f"{instance}{message}"))
        self._shown.add((name, message))


def one_line(text: str) -> str:
    """Return a text as `cosim.errors.printable` does, in one line."""
    return printable(text).replace("\n", "\\n")
