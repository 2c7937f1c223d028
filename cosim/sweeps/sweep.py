"""Run a scenario over everything that varies, and keep what comes of it."""

from __future__ import annotations

import logging
import pickle
import time
from collections.abc import Generator, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from cosim.errors import InputError, SweepInterruptedError
from cosim.processes import is_of_main
from cosim.progress import Progress, shown
from cosim.run.options import OptionKeywords, RunOptions, chosen
from cosim.scenario.file import opened_scenario
from cosim.scenario.scenario import Scenario
from cosim.sweeps.design import METHODS, Axis, Spread, Values, product, read_values, refuse_twice, sampled
from cosim.sweeps.measures import Beginning, MeasureSet, final_values
from cosim.sweeps.reading import SAMPLE, SERIES, TIME, open_sweep
from cosim.sweeps.series import POINTS, Wanted

if TYPE_CHECKING:
    from cosim.sweeps.plan import Opened, Sweep
    from cosim.sweeps.store import SweepStore
    from cosim.sweeps.workers.crew import Crew
    from cosim.sweeps.workers.work import Done

log = logging.getLogger("cosim")

_OF_BANDS = ("quantile", "samples")
_OF_INDICES = ("variable", "first", "total", "first_confidence", "total_confidence", "left_out")
_TAKEN = frozenset(("failed", "message", SERIES, SAMPLE, TIME, *_OF_BANDS, *_OF_INDICES))
"""Names that a store has for something else, or what is made of it."""
_FLUSH = 10.0
"""Seconds after which what is done is written for readers, though its regions are not complete."""


def sweep(
    scenario: Scenario | str | Path,
    output: str | Path,
    *,
    grid: Mapping[str, Values] | None = None,
    samples: Mapping[str, Spread] | None = None,
    count: int = 1000,
    sampling: str = METHODS[0],
    seed: int = 0,
    branch: str = "rest",
    along: str | None = None,
    measures: MeasureSet | None = None,
    beginning: Beginning | None = None,
    keep: Sequence[str] = (),
    keep_every: float | None = None,
    keep_points: int = POINTS,
    workers: int = 0,
    scheduler: str | None = None,
    executor: tuple[Executor, int] | None = None,
    progress: Progress | bool | None = None,
    options: RunOptions | None = None,
    **keywords: Unpack[OptionKeywords],
) -> Any:
    """Run a scenario at many points, each by its FMUs, and keep some numbers of each.

    A sweep that was interrupted or killed is gone on with by the same call; one that is done is returned at once.

    Parameters
    ----------
    scenario : Scenario, str or Path
        As of `cosim.simulate`.
    output : str or Path
        The store, a folder by Zarr.
    grid : mapping of str to text or values
        By ``component.variable``: ``"2:20:65"`` or values of a parameter or input; or by component: names or paths of
        FMUs to take its place. Each is a dimension.
    samples : mapping of str to text, (float, float) or Distribution
        Least and greatest value by ``component.variable``, or how it is distributed; they are drawn together: one
        dimension, ``sample``.
    count : int
        How many samples; of ``"saltelli"``, for each of them as many as there are variables, and two.
    sampling : str
        ``"latin-hypercube"``, ``"sobol"``, or ``"saltelli"``, of whose samples `cosim.sobol_indices` are estimated.
    seed : int
        Draws the same samples again.
    branch : str
        ``"rest"``: each point begins anew. ``"up"`` or ``"down"``: each goes on from the state in which the one before
        has ended, towards greater or less values of `along`.
    along : str, optional
        Of the grid, an input; by default the first of it.
    measures : MeasureSet, optional
        What to keep of each point: by default severity of stick-slip, if a component has a bit, else final values.
    beginning : Beginning, optional
        What else is set where a line of points begins; by default, for ``"down"``, steady rotation of what has a bit.
    keep : sequence of str
        Outputs that are kept over time of some points, as ``component.variable``, for `cosim.open_series`.
    keep_every : float, optional
        Between the times that are kept, s; by default 0.1 s, or what comes next to it in the steps of the scenario.
    keep_points : int
        At how many points of the grid, spread evenly over it; of each all samples are kept.
    workers : int
        Processes to use; 0: one for each processor; 1: this one alone.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers are used instead.
    executor : (Executor, int), optional
        Any other executor, and how many it runs at once.
    progress : callable or bool, optional
        Called several times a second with how far it is, in words, and the part that is done; True: a bar is shown,
        False: none. By default there is one in notebooks and in IPython, after two seconds.
    options : RunOptions, optional
        How to run each point; and so other keywords, as of `cosim.simulate`: Python functions as components among
        them, as far as `pickle` can send them to workers. What is for single runs is refused: `isolate` and `limits`.

    Returns
    -------
    xarray.Dataset
        What was kept, over the dimensions; read when it is asked for.

    Raises
    ------
    InputError
        If something asked for does not exist or does not fit, or the store is of another sweep.
    RunError
        If no worker can do the work.
    SweepInterruptedError
        If it was interrupted; a KeyboardInterrupt.
    """
    # with fmpy, which importing this module for its names does without
    from cosim.sweeps.store import opened_store
    from cosim.sweeps.workers.crew import refuse_in_import

    refuse_in_import()
    choice = chosen(options, keywords)
    _refuse_apart(choice)
    with opened_scenario(scenario, choice.stop_time, choice.step_size) as given:
        points = grid or {}, samples or {}, count, sampling, seed
        wanted = _wanted(keep, keep_every, keep_points)
        made = _made(given, choice, points, (branch, along), measures, beginning, wanted)
    path = Path(output)
    with ExitStack() as stack:
        plan = pickle.dumps(made.plan)
        begin = partial(_crew, workers, scheduler, executor, made.design.lines, plan)
        crew = None if path.exists() else stack.enter_context(begin())  # who starts while a store is begun
        store = stack.enter_context(opened_store(path, made))
        if store.done < made.design.points:
            told = stack.enter_context(shown(progress, "sweeping"))
            _run(made, plan, store, crew or stack.enter_context(begin()), path, told)
    return open_sweep(path)


def _wanted(keep: Sequence[str], every: float | None, points: int) -> Wanted | None:
    """Return what is to be kept over time, if anything is; a name alone is one of several."""
    if keep:
        return Wanted((keep,) if isinstance(keep, str) else tuple(keep), every, points)
    if every is not None or points != POINTS:
        raise InputError(
            "times or points are given for series, and nothing to keep; expected --keep component.variable as well"
        )
    return None


def _made(
    scenario: Scenario,
    options: RunOptions,
    points: tuple[Mapping[str, Values], Mapping[str, Spread], int, str, int],
    branch: tuple[str, str | None],
    measures: MeasureSet | None,
    beginning: Beginning | None,
    wanted: Wanted | None,
) -> Sweep:
    """Check what is asked for, and get it ready; what measures and begins is of the field where nothing is said."""
    from cosim.drilling import reporting
    from cosim.sweeps.plan import make_sweep, open_system

    grid, samples, count, sampling, seed = points
    opened = open_system(scenario, options)
    axes = [_axis(opened, name, said) for name, said in grid.items()]
    for name in samples:
        if opened.variable(name) is None:
            raise InputError(f"{name} is a component, of which no samples are drawn; expected component.variable")
    if samples:
        axes.append(sampled(samples, count, sampling, seed))
        read = {name: opened.typed(name, list(values)) for name, values in axes[-1].values.items()}
        axes[-1] = replace(axes[-1], values=read)
    for name in (options.overrides or {}).keys() & {name for axis in axes for name in axis.values}:
        log.warning("%s varies, so that the value it is set to has no effect", name)
    design = product(axes, branch[1], branch[0])
    found = measures or reporting.severity_of(opened.descriptions) or final_values(opened.descriptions)
    _refuse_taken(grid, found)
    if beginning is None and design.down:
        beginning = reporting.rotation_of(opened.descriptions, opened.system)
    return make_sweep(opened, design, found, beginning, wanted)


def _axis(opened: Opened, name: str, said: Values) -> Axis:
    """Read the values of an axis by the type of what varies."""
    opened.variable(name)
    values = opened.typed(name, read_values(name, said))
    refuse_twice(name, values)  # which 10 and 1e1 are of a number, and 10 rad/s
    return Axis(name, {name: values})


def _refuse_taken(names: Iterable[str], measures: MeasureSet) -> None:
    """Refuse that a component varies whose name the store needs."""
    taken = _TAKEN.union(each.name for each in measures.quantities)
    for name in names:
        if name in taken:
            raise InputError(
                f"{name} is to vary, and the store has that name for something else; expected another one for the "
                "component"
            )


def _refuse_apart(options: RunOptions) -> None:
    """Refuse what is for single runs."""
    for name in ("isolate", "limits"):
        if getattr(options, name):
            raise InputError(f"{name} is for single runs; points of a sweep run in processes of their workers")


@contextmanager
def _crew(
    workers: int, scheduler: str | None, executor: tuple[Executor, int] | None, most: int, plan: bytes
) -> Generator[Crew]:
    """Get the workers that are asked for."""
    from cosim.sweeps.workers.crew import Crew, dask_cluster, process_pool

    if executor is not None:
        yield Crew(*executor)
    elif scheduler is not None:
        with dask_cluster(scheduler) as crew:
            yield crew
    else:
        with process_pool(workers, most, of_main=is_of_main(plan)) as crew:
            yield crew


def _run(made: Sweep, plan: bytes, store: SweepStore, crew: Crew, path: Path, progress: Progress | None) -> None:
    """Run what is left, and keep it."""
    from cosim.sweeps.workers.dispatch import Dispatcher

    total, before = made.design.points, store.done
    began = flushed = time.monotonic()

    def take(done: list[Done]) -> None:
        nonlocal flushed
        store.take(done)
        if time.monotonic() - flushed > _FLUSH:
            store.flush()
            flushed = time.monotonic()

    def look() -> None:
        if progress is not None:
            rate = (store.done - before) / max(1e-9, time.monotonic() - began)
            failed = f", {store.failed} failed" if store.failed else ""
            progress(f"{store.done} of {total} points, {rate:.3g} a second{failed}", store.done / total)

    try:
        Dispatcher(made, plan, crew, store.left(), total - before).run(take, look)
        look()
    except KeyboardInterrupt:
        with suppress(KeyboardInterrupt):  # once more: what is done is in the journal
            store.flush()
        raise SweepInterruptedError(path, store.done, total) from None
    except BaseException:
        store.flush()
        raise
