"""Define the command `cosim`; each of its commands imports what it needs, so that help and lists are there at once."""

from __future__ import annotations

import math
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from cosim.cli.arguments import (
    AlgorithmOption,
    CheckpointOption,
    EveryOption,
    FoldsOption,
    MemoryLimitOption,
    OnFailureOption,
    PackagingOption,
    ParametersOption,
    ScenarioArgument,
    SetOption,
    StepSizeOption,
    StopTimeOption,
    StreamOption,
    TimeLimitOption,
    ToleranceOption,
    WorkersOption,
    read_override,
    read_overrides,
    read_streaming,
    seconds,
)
from cosim.cli.sweeping import draw_map, sensitivity, sweep
from cosim.cli.terminal import SafeConsole, new_console, prepare_step_loop, print_manifest, progress_bar, sentences
from cosim.errors import InputError
from cosim.fmi2.isolation import Limits
from cosim.fmi2.locate import PACKAGINGS, promised_fmus

if TYPE_CHECKING:
    from cosim.drilling.reporting import Looks


app = typer.Typer(
    help="Couple drillstring FMUs, run scenarios, and measure stick-slip.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)


def _show_version(wanted: bool) -> None:
    """Write the version and leave."""
    if wanted:
        from importlib.metadata import version

        new_console().print(f"cosim {version('drillstring-cosim')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", help="Show the version and exit.", callback=_show_version, is_eager=True)
    ] = False,
) -> None:
    """Take the options that go before any command."""


@app.command("list")
def list_scenarios() -> None:
    """List the scenarios that come with the package."""
    from cosim.scenario.file import load_scenario, scenario_names

    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("scenario", no_wrap=True)  # to be typed as it stands, on a narrow terminal too
    for heading in ("what it shows", "variants"):
        table.add_column(heading, overflow="fold")
    with sentences():
        for name in scenario_names():
            scenario = load_scenario(name)
            table.add_row(name, scenario.title, ", ".join(variant.name for variant in scenario.variants))
        new_console().print(table)


@app.command()
def info(
    what: Annotated[str, typer.Argument(help="An .fmu file, the name of an FMU or a scenario, or its file.")],
    packaging: PackagingOption = "native",
    variant: Annotated[str | None, typer.Option(help="Of a scenario; by default the first.")] = None,
) -> None:
    """Show what an FMU or a scenario is made of: variables, units, ranges; connections, loops, stepping order."""
    from cosim.cli.information import print_information

    with sentences():
        print_information(new_console(), what, packaging, variant)


@app.command()
def run(
    scenario: ScenarioArgument,
    packaging: PackagingOption = "native",
    algorithm: AlgorithmOption = None,
    step_size: StepSizeOption = None,
    tolerance: ToleranceOption = None,
    on_failure: OnFailureOption = None,
    stop_time: StopTimeOption = None,
    set_: SetOption = None,
    parameters: ParametersOption = None,
    variant: Annotated[list[str] | None, typer.Option(help="Only this variant; repeatable.")] = None,
    output: Annotated[Path | None, typer.Option(help="Folder for the results, by default runs/<scenario>.")] = None,
    isolate: Annotated[bool, typer.Option("--isolate", help="Run each FMU in a process of its own.")] = False,
    time_limit: TimeLimitOption = Limits.time,
    memory_limit: MemoryLimitOption = Limits.memory / 1e6,
    stream: StreamOption = False,
    every: EveryOption = None,
    csv: Annotated[bool, typer.Option("--csv", help="With --stream: write CSV instead of Zarr.")] = False,
    checkpoint: CheckpointOption = None,
) -> None:
    """Run a scenario: show its measures, and write trajectory, manifest and figure."""
    from cosim.run.job import Job, run_job
    from cosim.run.options import RunOptions
    from cosim.scenario.file import opened_scenario

    with sentences(), opened_scenario(scenario, stop_time, step_size) as loaded:
        options = RunOptions(
            packaging=packaging,
            algorithm=algorithm,
            step_size=step_size,
            stop_time=stop_time,
            overrides=read_overrides(loaded, packaging, parameters, set_),
            tolerance=tolerance,
            on_failure=on_failure,
            isolate=isolate,
            limits=Limits(time_limit, 1e6 * memory_limit),
        )
        streaming = read_streaming(stream, every, csv, checkpoint)
        job = Job(loaded, options, tuple(dict.fromkeys(variant or ())), streaming, scenario)
        folder = output or Path("runs", loaded.name)
        prepare_step_loop(job)
        with progress_bar() as bar:
            bar.show(job)
            manifest = run_job(job, folder.absolute(), bar.progress)
        print_manifest(manifest, folder)


@app.command()
def resume(
    folder: Annotated[Path, typer.Argument(help="Of an unfinished run with --stream.", metavar="FOLDER")],
) -> None:
    """Go on with a streamed run that was interrupted, from its last checkpoint."""
    from cosim.run.job import resume_job

    with sentences():
        with progress_bar() as bar:
            manifest = resume_job(folder.absolute(), bar.show, bar.progress)
        print_manifest(manifest, folder)


@app.command()
def plot(
    folders: Annotated[
        list[Path], typer.Argument(help="Of finished runs, or stores of sweeps with --keep.", metavar="FOLDER...")
    ],
    signal: Annotated[list[str] | None, typer.Option(help="What to show, component.variable; repeatable.")] = None,
    at: Annotated[
        list[str] | None, typer.Option(help="Of sweeps: which point, component.variable=value; repeatable.")
    ] = None,
    quantile: Annotated[
        list[float] | None,
        typer.Option(help="Of sweeps with samples: in per cent, by default 5 25 50 75 95; repeatable."),
    ] = None,
    variant: Annotated[list[str] | None, typer.Option(help="Only this variant; repeatable.")] = None,
    begin: Annotated[
        float | None, typer.Option("--from", help="When to begin.", parser=seconds, metavar="TIME")
    ] = None,
    end: Annotated[float | None, typer.Option("--to", help="When to end.", parser=seconds, metavar="TIME")] = None,
    overlay: Annotated[bool, typer.Option("--overlay", help="Draw runs over each other, not beside.")] = False,
    units: Annotated[str, typer.Option(help="si, metric: rpm, kN, or field: rpm, klbf, kft.lbf.")] = "si",
    format_: Annotated[str | None, typer.Option("--format", help="png, svg or pdf, by default as the file.")] = None,
    output: Annotated[Path | None, typer.Option(help="File for the figure, by default plot.png.")] = None,
) -> None:
    """Draw finished runs, or points and quantiles of sweeps, over time, beside or over each other, into one figure."""
    from cosim.cli.figure import draw_runs

    with sentences():
        times = (-math.inf if begin is None else begin, math.inf if end is None else end)
        looks: Looks = {"begin": times[0], "end": times[1], "overlay": overlay, "units": units}
        places = tuple(at or ()), tuple(quantile or ())
        target = draw_runs(folders, signal or (), variant or (), looks, format_, output, places)
        new_console().print(Text(f"wrote {target}"), soft_wrap=True)


@app.command()
def report(
    folders: Annotated[list[Path], typer.Argument(help="Of finished runs, leagues or sweeps.", metavar="FOLDER...")],
    output: Annotated[Path, typer.Option(help="The .html file to write.")] = Path("report.html"),
    units: Annotated[str, typer.Option(help="si, or field: rpm, klbf, kft.lbf.")] = "si",
    title: Annotated[str, typer.Option(help="By default that of what was run.")] = "",
    folds: FoldsOption = 5,
) -> None:
    """Write what was run and what came of it as one HTML file to send on: plots, system, verdicts, commands."""
    from cosim.cli.reports import write_report

    with sentences():
        with progress_bar() as bar:
            follow = bar.one_task("following cycles", at_once=False)
            target = write_report(folders, output, units=units, title=title, folds=folds, progress=follow)
        new_console().print(Text(f"wrote {target}"), soft_wrap=True)


@app.command()
def export(
    scenario: ScenarioArgument,
    file: Annotated[Path | None, typer.Argument(help="The .ssp file to write.", metavar="[FILE.ssp]")] = None,
    container: Annotated[
        Path | None, typer.Option(help="The .fmu file to write: the whole system as one FMU.", metavar="FILE.fmu")
    ] = None,
    packaging: PackagingOption = "native",
    set_: SetOption = None,
    variant: Annotated[str | None, typer.Option(help="Which variant; by default the first.")] = None,
) -> None:
    """Write a scenario, with its FMUs, as one file that other tools read: SSP 1.0, or an FMU of FMUs."""
    from cosim.scenario.container import export_container
    from cosim.scenario.file import opened_scenario
    from cosim.scenario.ssp.writing import export_ssp

    with sentences(), opened_scenario(scenario) as loaded:
        wanted = [(file, ".ssp", export_ssp), (container, ".fmu", export_container)]
        targets = [(path, suffix, write) for path, suffix, write in wanted if path is not None]
        for path, suffix, _ in targets:
            if path.suffix != suffix:
                raise InputError(f"{path}: expected a name that ends in {suffix}")
        if not targets:
            raise InputError("nothing to write; expected FILE.ssp or --container FILE.fmu")
        overrides = dict(read_override(text) for text in set_ or ())
        for path, _, write in targets:
            write(loaded, path, packaging=packaging, variant=variant, overrides=overrides)
            new_console().print(Text(f"wrote {path}"), soft_wrap=True)


@app.command()
def console(
    path: Annotated[bool, typer.Option("--path", help="Write where the page lies, and open nothing.")] = False,
) -> None:
    """Open the driller's console in the browser: turn the string, and see when it begins to stick."""
    from cosim.cli.console_page import console_page, open_page

    with sentences():
        page = console_page()
        if not path:
            open_page(page)
        new_console().print(page, soft_wrap=True, highlight=False, markup=False)


@app.command()
def check(
    fmu: Annotated[Path, typer.Argument(help="An FMU by FMI 2.0 for co-simulation, anybody's.", metavar="FILE.fmu")],
    reference: Annotated[
        Path | None, typer.Option(help="Folder with reference experiments, instead of those in the FMU.")
    ] = None,
    junit: Annotated[Path | None, typer.Option(help="Write a JUnit XML file as well.")] = None,
    time_limit: Annotated[
        float | None, typer.Option(min=0.1, help="Seconds each check may take, by default 60.")
    ] = None,
) -> None:
    """Check an FMU: file, description, claims, and reference results; exit with 0 if nothing fails, else with 1."""
    from cosim.check import TIME_LIMIT, check_fmu
    from cosim.check.report import print_report

    with sentences():
        errors = SafeConsole(stderr=True)
        with errors.status("checking") as status:
            limit = TIME_LIMIT if time_limit is None else time_limit
            report = check_fmu(
                fmu, reference, time_limit=limit, tell=lambda name: status.update(f"checking {escape(name)}")
            )
        console = new_console()
        print_report(console, report)
        if junit is not None:
            from cosim.check.report import write_junit

            write_junit(report, junit)
            console.print(Text(f"wrote {junit}"), soft_wrap=True)
    raise typer.Exit(0 if report.passed else 1)


@app.command()
def league(
    file: Annotated[
        Path | None, typer.Argument(help="A .toml file of laws and conditions; by default the field's.")
    ] = None,
    law: Annotated[list[str] | None, typer.Option(help="Only this law; repeatable.")] = None,
    condition: Annotated[list[str] | None, typer.Option(help="Only this condition; repeatable.")] = None,
    add: Annotated[list[Path] | None, typer.Option(help="An .fmu file that takes part besides; repeatable.")] = None,
    parameters: Annotated[
        list[Path] | None, typer.Option(help="A law of `cosim tune` that takes part besides; repeatable.")
    ] = None,
    workers: WorkersOption = 0,
    output: Annotated[Path, typer.Option(help="Folder for scores, limits and figure.")] = Path("runs/league"),
) -> None:
    """Judge laws against stick-slip: each under each condition, with a real drive; show who frees the string, when."""
    from cosim.cli.league_table import print_standings
    from cosim.league import table
    from cosim.league.entries import USUAL, load_league
    from cosim.league.playing import play

    with sentences():
        every = load_league(file or USUAL, add, parameters)
        besides = [each.name for each in every.laws[len(every.laws) - len([*(add or ()), *(parameters or ())]) :]]
        chosen = every.only([*law, *besides] if law else [], condition or [])
        table.prepare(output)
        with progress_bar() as bar:
            standings = play(chosen, workers, bar.one_task("playing"))
        print_standings(standings, table.write(standings, output))


app.command()(sweep)
app.command("map")(draw_map)
app.command()(sensitivity)


@app.command()
def tune(
    law: Annotated[str, typer.Argument(help="A law of the league, or an FMU: its name or file.", metavar="LAW")],
    league: Annotated[
        Path | None, typer.Option(help="A .toml file of laws and conditions; by default the field's.")
    ] = None,
    condition: Annotated[
        list[str] | None, typer.Option(help="A condition to tune for, by default those that are not hard; repeatable.")
    ] = None,
    gain: Annotated[
        list[str] | None, typer.Option(help="What is free, name=low:high; by default what the league says; repeatable.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the search: the same seed, the same result.")] = 1,
    budget: Annotated[int, typer.Option(help="Candidates to look at; a greater one goes on.")] = 150,
    reflection: Annotated[
        float, typer.Option(help="Margin: greatest part of a wave that may come back from the top, by linear theory.")
    ] = 1.0,
    damping: Annotated[
        float, typer.Option(help="Margin: least rate in 1/s at which small motions have to die away.")
    ] = 0.0,
    workers: WorkersOption = 0,
    output: Annotated[Path | None, typer.Option(help="Folder for the results, by default runs/tune/<law>.")] = None,
) -> None:
    """Tune the gains of a law under conditions of the league; goes on with a tuning that was interrupted."""
    with sentences():
        from cosim.cli.league_table import print_tuned
        from cosim.league.tuning import search, table

        tuning = search.prepare(
            law,
            league,
            conditions=condition or (),
            gains=gain or (),
            seed=seed,
            budget=budget,
            reflection=reflection,
            damping=damping,
        )
        folder = output or Path("runs", "tune", tuning.law.name)
        with progress_bar() as bar:
            tuned = search.tune(tuning, folder, workers, bar.one_task("tuning"))
        print_tuned(tuned, table.write(tuned, folder))


@app.command()
def fmus(
    folder: Annotated[
        Path | None, typer.Argument(help="Where to copy them to; without it they are listed.", metavar="[FOLDER]")
    ] = None,
    packaging: PackagingOption = "native",
    force: Annotated[bool, typer.Option("--force", help="Replace files of the same names.")] = False,
) -> None:
    """Hand out the FMU files, for the tool that is to import them."""
    from cosim.cli.fmu_files import available_fmus, copy_fmus

    with sentences():
        console = new_console()
        if folder is None:
            for path in available_fmus(packaging).values():
                console.print(Text(str(path)), soft_wrap=True)
            return
        for path in copy_fmus(folder, packaging, replace=force):
            console.print(Text(f"wrote {path}"), soft_wrap=True)


@app.command(
    context_settings={"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []},
    add_help_option=False,
)
def build(arguments: typer.Context) -> None:
    """Build the FMUs anew, of either packaging, or that of a law of your own; --help says how."""
    from cosim.cli.fmu_files import build_fmus

    with sentences():
        code = build_fmus(arguments.args)
    raise typer.Exit(code)


@app.command("new-law")
def new_law(
    name: Annotated[str, typer.Argument(help="Of the law, and of the FMU that it becomes.")],
    folder: Annotated[
        Path | None,
        typer.Argument(help="Where to write it, new or empty; by default named like it.", metavar="[FOLDER]"),
    ] = None,
) -> None:
    """Write a control law to begin your own with: one Python file, and a scenario that it acts in."""
    from cosim.cli.new_law import write_law

    with sentences():
        console = new_console()
        known = {stem for packaging in PACKAGINGS for stem in promised_fmus(packaging)}
        law, scenario = write_law(name, Path(name) if folder is None else folder, sorted(known))
        for path in (law, scenario):
            console.print(Text(f"wrote {path}"), soft_wrap=True)
        console.print("next:")
        for command, path in (("build", law), ("check", law.with_suffix(".fmu")), ("run", scenario)):
            console.print(Text(f"  cosim {command} {shlex.quote(str(path))}"), soft_wrap=True)


def main() -> None:
    """Run the command line; output that cannot be written, as to a full disk, is a sentence too."""
    try:
        app()
    except SystemExit as end:
        if end.code != 1 or "--help" not in sys.argv:
            raise  # help fails for nothing but a reader that has left, which rich exits with 1 for
    except OSError as error:
        sys.exit(f"error: the output cannot be written: {error.strerror or error}")
