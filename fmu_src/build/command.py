"""The command that builds FMUs: `python build_fmu.py` in a checkout, `cosim build` where the package is installed."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

from ..errors import BuildError
from ..fmus import MODELS
from ..schema import Model, Packaging
from .building import build
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
        list[str] | None, typer.Argument(metavar="MODEL", help=f"Any of {', '.join(MODELS)}; none: all.")
    ] = None,
    output: Annotated[Path, typer.Option(help="Folder the FMUs go to, by packaging.")] = Path("dist"),
    packaging: Annotated[PackagingChoice, typer.Option(help="How the computation is put in.")] = PackagingChoice.ALL,
    platform: Annotated[
        PlatformChoice, typer.Option(help="Platforms a native FMU runs on: this one, or all five.")
    ] = PlatformChoice.HOST,
) -> None:
    """Build, validate and pack the FMUs.

    Each goes to OUTPUT/PACKAGING/MODEL.fmu once it is known to be good; until then what was there stays.
    """
    console = Console(stderr=True)
    models = _models(model or list(MODELS))
    packagings = list(Packaging) if packaging is PackagingChoice.ALL else [Packaging(packaging.value)]
    try:
        needs_target = Packaging.NATIVE in packagings
        targets = list(TARGETS) if platform is PlatformChoice.ALL else [host_target()] if needs_target else []
    except BuildError as error:
        console.print(f"error: {error}", style="red", markup=False)
        raise typer.Exit(1) from error
    built, failures = _build_all(console, models, packagings, targets, output)
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
    built, failures = _build_all(Console(stderr=True), list(MODELS.values()), [Packaging.NATIVE], list(TARGETS), output)
    if failures:
        raise failures[0]
    return built


def _models(names: Sequence[str]) -> list[Model]:
    unknown = [name for name in names if name not in MODELS]
    if unknown:
        expected = ", ".join(MODELS)
        raise typer.BadParameter(f"{', '.join(unknown)}: no such model; expected any of {expected}", param_hint="MODEL")
    return [MODELS[name] for name in dict.fromkeys(names)]


def _build_all(
    console: Console, models: list[Model], packagings: list[Packaging], targets: list[Target], output: Path
) -> tuple[list[Path], list[BuildError]]:
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
        jobs: dict[Future[Path], str] = {
            pool.submit(build, model, packaging, targets, output): f"{packaging}/{model.name}"
            for packaging in packagings
            for model in models
        }
        task = progress.add_task("building FMUs", total=len(jobs))
        for job in as_completed(jobs):
            try:
                built.append(job.result())
            except BuildError as error:
                failures.append(error)
            progress.update(task, advance=1, description=escape(jobs[job]))
    return sorted(built), sorted(failures, key=str)


def main() -> None:
    """Run the command line."""
    app()
