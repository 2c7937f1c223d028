"""Define the commands that run sweeps and draw their maps."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from cosim.cli.arguments import (
    AlgorithmOption,
    FoldsOption,
    GridOption,
    PackagingOption,
    ParametersOption,
    SampleOption,
    ScenarioArgument,
    SetOption,
    StepSizeOption,
    StopTimeOption,
    read_overrides,
    seconds,
)
from cosim.cli.terminal import new_console, progress_bar, sentences
from cosim.errors import InputError, printable

if TYPE_CHECKING:
    from cosim.sweeps.design import Spread


def sweep(
    scenario: ScenarioArgument,
    grid: GridOption = None,
    sample: SampleOption = None,
    uncertain: Annotated[
        Path | None, typer.Option(help="A .toml file of distributions that are sampled as well.", metavar="FILE.toml")
    ] = None,
    count: Annotated[
        int, typer.Option(help="How many samples; by saltelli times the number of variables, and two.")
    ] = 1024,
    sampling: Annotated[
        str, typer.Option(help="How to sample: latin-hypercube, sobol, or saltelli, for `cosim sensitivity`.")
    ] = "latin-hypercube",
    seed: Annotated[int, typer.Option(min=0, help="Of the samples.")] = 0,
    branch: Annotated[
        str, typer.Option(help="rest: each point begins anew; up or down: it goes on from the one before.")
    ] = "rest",
    along: Annotated[str | None, typer.Option(help="With up or down: along which input; by default the first.")] = None,
    keep: Annotated[
        list[str] | None,
        typer.Option(help="Output to keep over time at some points, component.variable; repeatable."),
    ] = None,
    keep_every: Annotated[
        float | None,
        typer.Option(help="With --keep: time between values, by default about 0.1 s.", parser=seconds, metavar="TIME"),
    ] = None,
    keep_points: Annotated[
        int, typer.Option(help="With --keep: at how many points of the grid, spread evenly; of samples, all.")
    ] = 100,
    set_: SetOption = None,
    parameters: ParametersOption = None,
    variant: Annotated[str | None, typer.Option(help="Which variant; by default the first.")] = None,
    packaging: PackagingOption = "native",
    algorithm: AlgorithmOption = None,
    step_size: StepSizeOption = None,
    stop_time: StopTimeOption = None,
    workers: Annotated[int, typer.Option(min=0, help="Processes to use; 0: one for each processor; 1: this one.")] = 0,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, whose workers are used instead.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option(help="The store to write, or to go on with; by default runs/<scenario>.zarr.")
    ] = None,
) -> None:
    """Run a scenario over grids and samples, on all processors or a cluster; interrupted, the same command goes on."""
    from cosim.run.options import RunOptions
    from cosim.scenario.file import opened_scenario
    from cosim.sweeps.sweep import sweep as run_sweep

    with sentences():
        path = output or Path("runs", f"{Path(scenario).stem}.zarr")
        with opened_scenario(scenario, stop_time, step_size) as loaded:
            overrides = read_overrides(loaded, packaging, parameters, set_)
        options = RunOptions(
            packaging=packaging,
            algorithm=algorithm,
            step_size=step_size,
            stop_time=stop_time,
            overrides=overrides,
            variant=variant,
        )
        with progress_bar() as bar:
            found = run_sweep(
                scenario,
                path,
                grid=_named("--grid", grid),
                samples=_spreads(sample, uncertain),
                count=count,
                sampling=sampling,
                seed=seed,
                branch=branch,
                along=along,
                keep=keep or (),
                keep_every=keep_every,
                keep_points=keep_points,
                workers=workers,
                scheduler=scheduler,
                options=options,
                progress=bar.one_task("sweeping"),
            )
        _print_summary(found, path)


def _spreads(texts: list[str] | None, file: Path | None) -> dict[str, Spread]:
    """Gather all that is sampled; each name once."""
    from cosim.sweeps.distributions import read_distributions

    found: dict[str, Spread] = {**_named("--sample", texts)}
    for name, each in (read_distributions(file) if file is not None else {}).items():
        if name in found:
            raise InputError(f"{name} is sampled twice; expected each name once")
        found[name] = each
    return found


def _named(option: str, texts: list[str] | None) -> dict[str, str]:
    """Take ``name=what`` apart; each name once."""
    found: dict[str, str] = {}
    for text in texts or ():
        name, equals, said = text.partition("=")
        if not equals or not name.strip():
            raise InputError(f"{option} {text}: expected the form component.variable=values")
        if name.strip() in found:
            raise InputError(f"{option} {text}: {name.strip()} is varied twice; expected each name once")
        found[name.strip()] = said.strip()
    return found


def _print_summary(found: Any, path: Path) -> None:
    """Say how many points there are, and why the first of those failed that did."""
    console = new_console()
    failed = found["failed"].values == 1
    shape = " x ".join(str(size) for size in failed.shape)
    points = "1 point" if failed.size == 1 else f"{failed.size} points"
    console.print(Text(f"{points} ({shape}), {int(failed.sum())} failed"))
    if failed.any():
        console.print(Text(f"the first that failed: {found['message'].values[failed][0]}"), soft_wrap=True)
    console.print(Text(f"wrote {path}"), soft_wrap=True)


def draw_map(
    stores: Annotated[
        list[Path], typer.Argument(help="Stores of sweeps over two axes, such as branches of one.", metavar="STORE...")
    ],
    quantity: Annotated[
        str, typer.Option(help="Which number to show, such as ssi or torque_swing; of samples, probability.")
    ] = "",
    minus: Annotated[Path | None, typer.Option(help="A store that is subtracted from the others.")] = None,
    units: Annotated[str, typer.Option(help="Units to show: metric (rpm, kN), field (rpm, klbf) or si.")] = "metric",
    folds: FoldsOption = 5,
    output: Annotated[
        Path | None, typer.Option(help="The .png file to write; by default named like the first store.")
    ] = None,
) -> None:
    """Draw severity maps of sweeps, side by side, with what theory says of them."""
    from cosim.drilling import map_figure, severity_map
    from cosim.errors import OutputError
    from cosim.files import why
    from cosim.sweeps.reading import load_sweep

    with sentences():
        maps = [severity_map.read_map(load_sweep(path), quantity or None) for path in stores]
        if minus is not None:
            other = severity_map.read_map(load_sweep(minus), quantity or None)
            maps = [each.less(other) for each in maps]
        path = output or _named_like(stores[0], ".png")
        with progress_bar() as bar:
            lines = severity_map.find_folds(maps[0], folds, bar.one_task("following cycles")) if folds else None
        try:
            map_figure.draw_maps(path, maps, units, lines, difference=minus is not None)
        except OSError as error:
            raise OutputError(f"{path} cannot be written: {why(error)}") from error
        new_console().print(Text(f"wrote {path}"), soft_wrap=True)


def _named_like(store: Path, ending: str) -> Path:
    """Return a file beside a store, which may be the folder that this process is in."""
    place = store if store.name not in ("", "..") else store.resolve()
    return place.with_name(f"{place.stem}{ending}")


def sensitivity(
    store: Annotated[Path, typer.Argument(help="Of a sweep with --sampling saltelli.", metavar="STORE")],
    confidence: Annotated[
        float, typer.Option(help="How likely an index is to lie in its interval, in per cent.")
    ] = 95.0,
    units: Annotated[str, typer.Option(help="Units to show: metric (rpm, kN), field (rpm, klbf) or si.")] = "metric",
    output: Annotated[
        Path | None, typer.Option(help="The .png file to write, and beside it a .csv; by default named like the store.")
    ] = None,
) -> None:
    """Tell what stick-slip and its linear threshold depend on, of all that was sampled: Sobol indices of a sweep."""
    from cosim.drilling.sensitivity import indices_of_all
    from cosim.drilling.uncertainty import draw_indices, write_indices
    from cosim.errors import OutputError
    from cosim.files import why
    from cosim.sweeps.reading import load_sweep

    with sentences():
        if not 0.0 < confidence < 100.0:
            raise InputError(f"--confidence {confidence:g}: expected per cent, between 0 and 100")
        with progress_bar() as bar:
            found, left = indices_of_all(load_sweep(store), confidence / 100.0, bar.one_task("estimating"))
        path = output or _named_like(store, "-indices.png")
        try:
            draw_indices(path, {each.attrs["long_name"]: each for each in found.values()}, units)
            write_indices(path.with_suffix(".csv"), found)
        except OSError as error:
            raise OutputError(f"{path} cannot be written: {why(error)}") from error
        console = new_console()
        for each in found.values():
            print_indices(console, each, units)
        for sentence in (*left, f"wrote {path} and {path.with_suffix('.csv').name}"):
            console.print(Text(sentence), soft_wrap=True)


def print_indices(console: Console, indices: Any, units: str) -> None:
    """Show indices, of several points those in the middle; those of a whole map are for the figure."""
    from cosim.system.field_units import shown_in

    over = [str(name) for name in indices["left_out"].dims]
    if len(over) > 1:
        return
    point = indices.isel({name: indices.sizes[name] // 2 for name in over})
    title = str(indices.attrs["long_name"])
    for name in over:
        unit, factor = shown_in(str(indices[name].attrs.get("units", "")), units)
        value = point[name].item()
        title += f", at {name} = {value if isinstance(value, str) else f'{value * factor:.6g} {unit}'.strip()}"
    console.print(Text(title, style="bold"), soft_wrap=True)
    table = Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2))
    table.add_column("variable", no_wrap=True)
    for heading in ("first order", "total"):
        table.add_column(heading, justify="right", no_wrap=True)
    for name in indices["variable"].values.tolist():
        each = point.sel(variable=name)
        cells = [(float(each[kind]), float(each[f"{kind}_confidence"])) for kind in ("first", "total")]
        table.add_row(
            Text(printable(name)), *("-" if value != value else f"{value:.3f} +- {half:.3f}" for value, half in cells)
        )
    console.print(table)
    if bool(point["total"].isnull().all()):
        enough = int(indices.attrs["samples"]) - int(point["left_out"]) > 1
        console.print(Text("it does not vary" if enough else "there are too few samples that have it"))
