"""The command `cosim`."""

from __future__ import annotations

import logging
import tomllib
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from cosim.check import TIME_LIMIT, check_fmu
from cosim.check.junit import write_junit
from cosim.check.table import print_report
from cosim.console_log import SentenceHandler, plain
from cosim.container import export_container
from cosim.errors import CosimError, InputError
from cosim.interrupt import interruptible
from cosim.isolated_process import Limits
from cosim.job import Job, Outcome, run_job
from cosim.scenario import Scenario
from cosim.scenario_file import load_scenario, scenario_names
from cosim.signals import Value
from cosim.ssp.reading import open_ssp
from cosim.ssp.writing import export_ssp
from cosim.statement import statement
from cosim.store import FIGURE, MANIFEST, TRAJECTORY

_WIDTH_OF_FILES = 120
_INTERRUPTED = 130

app = typer.Typer(
    help="Couple drillstring FMUs, run scenarios, and measure stick-slip.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)


@app.command("list")
def list_scenarios() -> None:
    """List the scenarios that come with the package."""
    table = Table("scenario", "what it shows", "variants", box=None, pad_edge=False, header_style="bold")
    with _sentences():
        for name in scenario_names():
            scenario = load_scenario(name)
            table.add_row(name, scenario.title, ", ".join(variant.name for variant in scenario.variants))
        _console().print(table)


@app.command()
def run(
    scenario: Annotated[
        str, typer.Argument(help="A name from `cosim list`, or a .toml or .ssp file.", metavar="SCENARIO")
    ],
    packaging: Annotated[str, typer.Option(help="Which build of the FMUs: native or python.")] = "native",
    algorithm: Annotated[str | None, typer.Option(help="Master algorithm: jacobi, gauss-seidel or implicit.")] = None,
    step_size: Annotated[
        float | None, typer.Option(help="Communication step size in s; with a tolerance, the greatest.")
    ] = None,
    tolerance: Annotated[
        float | None, typer.Option(help="Error allowed in a step, relative to values; the step size varies.")
    ] = None,
    on_failure: Annotated[
        str | None,
        typer.Option(help="Where a loop has no solution: fail, halve the step, or go on with an explicit one."),
    ] = None,
    stop_time: Annotated[float | None, typer.Option(help="End of the run in s.")] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Parameter or input, component.variable=value; repeatable.")
    ] = None,
    variant: Annotated[list[str] | None, typer.Option(help="Only this variant; repeatable.")] = None,
    output: Annotated[Path | None, typer.Option(help="Folder for the results, by default runs/<scenario>.")] = None,
    isolate: Annotated[bool, typer.Option("--isolate", help="Run each FMU in a process of its own.")] = False,
    time_limit: Annotated[
        float, typer.Option(min=0.1, help="Seconds that each call into an isolated FMU may take.")
    ] = Limits.time,
    memory_limit: Annotated[float, typer.Option(min=1.0, help="MB that an isolated FMU may hold.")] = Limits.memory
    / 1e6,
) -> None:
    """Run a scenario: show its measures, and write trajectory, manifest and figure."""
    with _sentences(), _opened(scenario, stop_time, step_size) as loaded:
        overrides = dict(_override(text) for text in set_ or ())
        job = Job(
            loaded,
            packaging=packaging,
            algorithm=algorithm,
            step_size=step_size,
            stop_time=stop_time,
            overrides=overrides,
            variants=tuple(dict.fromkeys(variant or ())),
            tolerance=tolerance,
            on_failure=on_failure,
            isolate=isolate,
            limits=Limits(time_limit, 1e6 * memory_limit),
        )
        folder = output or Path("runs", loaded.name)
        outcomes = _run_with_bar(job, folder)
        console = _console()
        console.print(Text(loaded.title or loaded.name, style="bold"))
        console.print(_summary(outcomes))
        _print_remarks(console, outcomes)
        _print_paths(console, folder, job.labels)


@app.command()
def export(
    scenario: Annotated[
        str, typer.Argument(help="A name from `cosim list`, or a .toml or .ssp file.", metavar="SCENARIO")
    ],
    file: Annotated[Path | None, typer.Argument(help="The .ssp file to write.", metavar="[FILE.ssp]")] = None,
    container: Annotated[
        Path | None, typer.Option(help="The .fmu file to write: the whole system as one FMU.", metavar="FILE.fmu")
    ] = None,
    packaging: Annotated[str, typer.Option(help="Which build of the FMUs: native or python.")] = "native",
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Parameter or input, component.variable=value; repeatable.")
    ] = None,
    variant: Annotated[str | None, typer.Option(help="Which variant; by default the first.")] = None,
) -> None:
    """Write a scenario, with its FMUs, as one file that other tools read: SSP 1.0, or an FMU of FMUs."""
    with _sentences(), _opened(scenario) as loaded:
        wanted = [(file, ".ssp", export_ssp), (container, ".fmu", export_container)]
        targets = [(path, suffix, write) for path, suffix, write in wanted if path is not None]
        for path, suffix, _ in targets:
            if path.suffix != suffix:
                raise InputError(f"{path}: expected a name that ends in {suffix}")
        if not targets:
            raise InputError("nothing to write; expected FILE.ssp or --container FILE.fmu")
        overrides = dict(_override(text) for text in set_ or ())
        for path, _, write in targets:
            write(loaded, path, packaging=packaging, variant=variant, overrides=overrides)
            _console().print(Text(f"wrote {path}"), soft_wrap=True)


@app.command()
def check(
    fmu: Annotated[Path, typer.Argument(help="An FMU by FMI 2.0 for co-simulation, anybody's.", metavar="FILE.fmu")],
    reference: Annotated[
        Path | None, typer.Option(help="Folder with reference experiments, instead of those in the FMU.")
    ] = None,
    junit: Annotated[Path | None, typer.Option(help="Write a JUnit XML file as well.")] = None,
    time_limit: Annotated[float, typer.Option(min=0.1, help="Seconds each check may take.")] = TIME_LIMIT,
) -> None:
    """Check an FMU: file, description, claims, and reference results; exit with 0 if nothing fails, else with 1."""
    with _sentences():
        errors = Console(stderr=True)
        with errors.status("checking") as status:
            report = check_fmu(
                fmu, reference, time_limit=time_limit, tell=lambda name: status.update(f"checking {escape(name)}")
            )
        console = _console()
        print_report(console, report)
        if junit is not None:
            write_junit(report, junit)
            console.print(Text(f"wrote {junit}"), soft_wrap=True)
    raise typer.Exit(0 if report.passed else 1)


def main() -> None:
    """Run the command line."""
    app()


def _console() -> Console:
    """Return a console on the present standard output; a file is wide enough for every table."""
    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=_WIDTH_OF_FILES)


@contextmanager
def _sentences() -> Generator[None]:
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
    except KeyboardInterrupt:
        errors.print("interrupted; nothing was written")
        raise typer.Exit(_INTERRUPTED) from None
    finally:
        logger.removeHandler(handler)


@contextmanager
def _opened(scenario: str, stop_time: float | None = None, step_size: float | None = None) -> Generator[Scenario]:
    """Load a scenario by name or from a file of either kind; the times matter where an .ssp file gives none."""
    if Path(scenario).suffix != ".ssp":
        yield load_scenario(scenario)
        return
    with open_ssp(scenario, stop_time=stop_time, step_size=step_size) as loaded:
        yield loaded


def _run_with_bar(job: Job, folder: Path) -> dict[str, Outcome]:
    """Run with a progress bar for each variant, if anybody watches."""
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
    with (
        interruptible() as check,
        Progress(
            *columns, TimeRemainingColumn(), console=console, transient=True, disable=not console.is_terminal
        ) as bar,
    ):
        tasks = {label: bar.add_task(label, total=1.0) for label in job.labels}

        def progress(label: str, part: float) -> None:
            check()
            bar.update(tasks[label], completed=part)

        return run_job(job, folder, progress)


def _override(text: str) -> tuple[str, Value]:
    """Read ``component.variable=value``; what is no number or Boolean is a string."""
    name, equals, value = text.partition("=")
    if not equals or not value:
        raise InputError(f"--set {text}: expected the form component.variable=value")
    try:
        parsed = tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        parsed = value.strip()
    return name.strip(), parsed if isinstance(parsed, bool | int | float) else value.strip().strip("\"'")


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
        record = outcome.result.record
        window = f"measured over {outcome.measures.window}" if outcome.measures else "nothing to measure"
        steps, seconds = record["steps"], record["timings"]["step"]
        size = f"{'at most ' if 'tolerance' in record else ''}{record['step_size']:g} s"
        took = f"{steps} steps of {size} ({record['algorithm']}) in {seconds:.3g} s"
        for sentence in (f"{window}; {took}", *statement(record)):
            console.print(Text(f"{label}: {sentence}", style="dim"), soft_wrap=True)


def _print_paths(console: Console, folder: Path, labels: Sequence[str]) -> None:
    """Say what was written where."""
    trajectories = [folder / TRAJECTORY] if len(labels) == 1 else [folder / label / TRAJECTORY for label in labels]
    for path in (*trajectories, folder / MANIFEST, folder / FIGURE):
        console.print(Text(f"wrote {path}"), soft_wrap=True)
