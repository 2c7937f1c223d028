"""The command that builds FMUs: `python build_fmu.py` in a checkout, `cosim build` where the package is installed."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from ..errors import BuildError
from ..fmus import MODELS
from ..fmus.own import read_law
from ..schema import Model, Packaging
from .building import build, build_own
from .native import TARGETS, Target, host_target


class PackagingChoice(StrEnum):
    """Values of --packaging."""

    NATIVE = "native"
    PYTHON = "python"
    ALL = "all"


class PlatformChoice(StrEnum):
    """Values of --platform."""

    HOST = "host"
    ALL = "all"


app = typer.Typer(add_completion=False, rich_markup_mode=None)


@app.command()
def build_fmus(
    model: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="MODEL", help=f"Any of {', '.join(MODELS)}; none: all. Or the file of a law of your own."
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(
            help="Folder the FMUs go to, by packaging; by default dist, and beside its file for a law of your own."
        ),
    ] = None,
    packaging: Annotated[PackagingChoice, typer.Option(help="How the computation is put in.")] = PackagingChoice.ALL,
    platform: Annotated[
        PlatformChoice, typer.Option(help="Platforms a native FMU runs on: this one, or all five.")
    ] = PlatformChoice.HOST,
) -> None:
    """Build, validate and pack the FMUs.

    Each goes to OUTPUT/PACKAGING/MODEL.fmu once it is known to be good; until then what was there stays. A law of your
    own is a file LAW.py, as `cosim new-law LAW` writes it, and goes to LAW.fmu beside it, in the python packaging.
    """
    console = Console(stderr=True)
    files = [Path(name) for name in model or () if name.endswith(".py")]
    if files and packaging is PackagingChoice.NATIVE:
        raise typer.BadParameter(f"{files[0]} has no C code; expected --packaging python", param_hint="--packaging")
    models = _models([name for name in model or (() if files else MODELS) if not name.endswith(".py")])
    packagings = list(Packaging) if packaging is PackagingChoice.ALL else [Packaging(packaging.value)]
    try:
        laws = {file: read_law(file) for file in files}
        needs_target = Packaging.NATIVE in packagings and bool(models)
        targets = list(TARGETS) if platform is PlatformChoice.ALL else [host_target()] if needs_target else []
    except BuildError as error:
        console.print(f"error: {error}", style="red", markup=False, soft_wrap=True)
        raise typer.Exit(1) from error
    jobs = _jobs(models, packagings, targets, output or Path("dist"))
    for file, law in laws.items():
        folder = file.parent if output is None else output / Packaging.PYTHON.value
        jobs[f"{Packaging.PYTHON.value}/{law.model.name}"] = partial(build_own, law, folder)
    built, failures = _build_all(console, jobs)
    for path in built:
        typer.echo(path)
    for failure in failures:
        console.print(f"error: {failure}", style="red", markup=False, soft_wrap=True)
    if failures:
        raise typer.Exit(1)


def build_all(output: Path) -> list[Path]:
    """Build every native FMU for every platform below a folder; return their paths.

    Raises
    ------
    BuildError
        One of them could not be built.
    """
    jobs = _jobs(list(MODELS.values()), [Packaging.NATIVE], list(TARGETS), output)
    built, failures = _build_all(Console(stderr=True), jobs)
    if failures:
        raise failures[0]
    return built


def _models(names: Sequence[str]) -> list[Model]:
    unknown = [name for name in names if name not in MODELS]
    if unknown:
        expected = ", ".join(MODELS)
        raise typer.BadParameter(f"{', '.join(unknown)}: no such model; expected any of {expected}", param_hint="MODEL")
    return [MODELS[name] for name in dict.fromkeys(names)]


def _jobs(
    models: list[Model], packagings: list[Packaging], targets: list[Target], output: Path
) -> dict[str, Callable[[], Path]]:
    """Return what builds each FMU in each packaging, by its name."""
    return {
        f"{packaging}/{model.name}": partial(build, model, packaging, targets, output)
        for packaging in packagings
        for model in models
    }


def _build_all(console: Console, jobs: Mapping[str, Callable[[], Path]]) -> tuple[list[Path], list[BuildError]]:
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
    )
    built: list[Path] = []
    failures: list[BuildError] = []
    # compiler and trial run are processes of their own, so threads are enough to keep all processors busy
    with Progress(*columns, console=console) as progress, ThreadPoolExecutor(os.cpu_count()) as pool:
        begun: dict[Future[Path], str] = {pool.submit(job): name for name, job in jobs.items()}
        task = progress.add_task("building FMUs", total=len(begun))
        for job in as_completed(begun):
            try:
                built.append(job.result())
            except BuildError as error:
                failures.append(error)
            progress.update(task, advance=1, description=escape(begun[job]))
    return sorted(built), sorted(failures, key=str)


def main() -> None:
    """Run the command line."""
    app()
