"""Say which arguments commands share, and read those that are more than a word or a number."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from cosim.errors import InputError

if TYPE_CHECKING:
    from cosim.run.options import Streaming
    from cosim.scenario.scenario import Scenario
    from cosim.system.signals import Value


def seconds(text: str) -> float:
    """Read a time in s, or with a unit, as ``2 min``."""
    from cosim.system.field_units import in_unit

    try:
        return in_unit(text, "s", "it")
    except InputError as error:
        raise typer.BadParameter(str(error)) from None


ScenarioArgument = Annotated[
    str, typer.Argument(help="A name from `cosim list`, or a .toml or .ssp file.", metavar="SCENARIO")
]
PackagingOption = Annotated[str, typer.Option(help="Which build of the FMUs: native or python.")]
AlgorithmOption = Annotated[str | None, typer.Option(help="Master algorithm: jacobi, gauss-seidel or implicit.")]
StepSizeOption = Annotated[
    float | None,
    typer.Option(
        help="Communication step size, in s or with a unit; with a tolerance, the greatest.",
        parser=seconds,
        metavar="TIME",
    ),
]
StopTimeOption = Annotated[
    float | None, typer.Option(help="End of the run, in s or with a unit.", parser=seconds, metavar="TIME")
]
ToleranceOption = Annotated[
    float | None, typer.Option(help="Error allowed in a step, relative to values; the step size varies.")
]
OnFailureOption = Annotated[
    str | None,
    typer.Option(help="Where a loop has no solution: fail, halve the step, or go on with an explicit one."),
]
SetOption = Annotated[
    list[str] | None, typer.Option("--set", help="Parameter or input, component.variable=value; repeatable.")
]
ParametersOption = Annotated[
    list[Path] | None,
    typer.Option(help="Values for the component that is the FMU of this file, as of `cosim tune`; repeatable."),
]
TimeLimitOption = Annotated[float, typer.Option(min=0.1, help="Seconds that each call into an isolated FMU may take.")]
MemoryLimitOption = Annotated[float, typer.Option(min=1.0, help="MB that an isolated FMU may hold.")]
WorkersOption = Annotated[int, typer.Option(min=0, help="Processes to use; 0: one for each processor.")]
StreamOption = Annotated[
    bool, typer.Option("--stream", help="Write rows to disk as they come (Zarr), to be resumed if interrupted.")
]
EveryOption = Annotated[
    list[str] | None,
    typer.Option(help="With --stream: store every Nth row; name=N or pattern=N for some columns; repeatable."),
]
CheckpointOption = Annotated[
    float | None, typer.Option(min=0.0, help="With --stream: seconds between checkpoints, by default 30.")
]
FoldsOption = Annotated[
    int,
    typer.Option(
        min=0,
        help="At how many weights to look for the end of the cycles, over maps of a string; each takes ten seconds.",
    ),
]
GridOption = Annotated[
    list[str] | None,
    typer.Option(
        "--grid", help="What varies: name=first:last:count or name=value,value; repeatable, each a dimension."
    ),
]
SampleOption = Annotated[
    list[str] | None,
    typer.Option("--sample", help="What is sampled: name=least:greatest; repeatable, all in one dimension."),
]


def read_streaming(stream: bool, every: list[str] | None, csv: bool, checkpoint: float | None) -> Streaming | None:
    """Read how to stream, if at all."""
    from cosim.run.options import INTERVAL, Streaming

    asked = {"--every": every, "--csv": csv, "--checkpoint": checkpoint is not None}
    if not stream:
        for name, given in asked.items():
            if given:
                raise InputError(f"{name} is for streamed runs; expected --stream as well")
        return None
    return Streaming(dict(_stride(text) for text in every or ()), csv, INTERVAL if checkpoint is None else checkpoint)


def _stride(text: str) -> tuple[str, int]:
    """Read ``N``, for all columns, or ``pattern=N``."""
    pattern, _, number = text.rpartition("=")
    if not number.strip().isdigit():
        raise InputError(f"--every {text}: expected a number of rows, or the form pattern=number")
    return pattern.strip() or "*", int(number)


def read_overrides(
    scenario: Scenario, packaging: str, parameters: list[Path] | None, set_: list[str] | None
) -> dict[str, Value]:
    """Read values from parameter files, and those given one by one on top of them."""
    from cosim.scenario.parameters import load_parameters

    given: dict[str, Value] = {}
    for path in parameters or ():
        given |= load_parameters(path).overrides(scenario, packaging)
    return given | dict(read_override(text) for text in set_ or ())


def read_override(text: str) -> tuple[str, Value]:
    """Take ``component.variable=value`` apart; the value is read by the type of the variable."""
    from cosim.system.compatibility import Written

    name, equals, value = text.partition("=")
    if not equals:
        raise InputError(f"--set {text}: expected the form component.variable=value")
    return name.strip(), Written(value.strip())
