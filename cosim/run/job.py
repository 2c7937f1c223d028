"""Do a job from scenario to folder: simulate, measure, write and draw every variant.

All jobs go one way; where rows go is up to a sink. `_MemorySink` keeps them, and the folder appears when all is done.
`_DiskSink` streams them, so the folder is there from the beginning, and its manifest tells what is being run and which
variants are complete. An unfinished job is resumed from the folder alone.
"""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from cosim.drilling import reporting
from cosim.errors import CheckpointError, CosimError, OutputError, RunInterruptedError
from cosim.master.run import Progress
from cosim.recording.result import Result
from cosim.run.assembly import refuse_unfit_variants
from cosim.run.options import RunOptions, Streaming
from cosim.run.report import MANIFEST, Manifest, RunReport, VariantReport, undamaged
from cosim.run.run_folder import make_folders, refuse_occupied, remove_empty, run_folder
from cosim.run.simulation import run
from cosim.run.store import csv_file
from cosim.run.stream import CHECKPOINT, run_streamed
from cosim.run.zarr_store import TRAJECTORY
from cosim.scenario.file import opened_scenario
from cosim.scenario.scenario import Scenario

FIGURE = "figure.png"
JobProgress = Callable[[str, float], None]
"""Told now and then which part, from 0 to 1, of which variant is done."""


@dataclass(frozen=True)
class Job:
    """A scenario to be run, with options, into a folder.

    Parameters
    ----------
    scenario : Scenario
        What is run.
    options : RunOptions
        How; the variants are chosen here.
    variants : sequence of str
        By default all.
    streaming : Streaming, optional
        How to write rows to disk as they come; by default they are kept in memory.
    source : str
        Where the scenario is from, as `cosim.scenario.file.opened_scenario` takes it; needed to resume.
    """

    scenario: Scenario
    options: RunOptions = field(default_factory=RunOptions)
    variants: Sequence[str] = ()
    streaming: Streaming | None = None
    source: str = ""

    @property
    def labels(self) -> tuple[str, ...]:
        """Name what will be run: the chosen variants, or the scenario itself if it has none."""
        names = [variant.name for variant in self.scenario.variants]
        return tuple(self.variants) or tuple(names) or (self.scenario.name,)

    @property
    def subfolders(self) -> tuple[str, ...]:
        """Name the folder of each label within that of the job: its own, if there are several."""
        return self.labels if len(self.labels) > 1 else ("",)

    def options_of(self, label: str) -> RunOptions:
        """Return the options for one of the labels."""
        return replace(self.options, variant=label if self.scenario.variants else None)

    def to_json(self) -> dict[str, Any] | None:
        """Return what a job is resumed from; None if it cannot be."""
        if self.streaming is None:
            return None
        given = Path(self.source)
        return {
            "source": str(given.absolute()) if given.suffix else self.source,
            "choices": self.options.to_json(),
            "variants": list(self.variants),
            "streaming": self.streaming.to_json(),
        }


@contextmanager
def _opened_job(content: Mapping[str, Any], folder: Path) -> Generator[Job]:
    """Read back what `Job.to_json` returned, and load the scenario for as long as it is needed."""
    with undamaged(folder):
        options, streaming = RunOptions.from_json(content["choices"]), Streaming.from_json(content["streaming"])
        source, variants = str(content["source"]), tuple(map(str, content["variants"]))
    with opened_scenario(source, options.stop_time, options.step_size) as scenario:
        yield Job(scenario, options, variants, streaming, source)


def run_job(job: Job, folder: Path, progress: JobProgress) -> Manifest:
    """Run all variants and write trajectories, manifest and figures to a folder.

    Parameters
    ----------
    job : Job
        What to run.
    folder : Path
        Appears when all is done, in the place of an earlier run; of a streamed job it is made at once, and must be new
        or empty.
    progress : callable
        Called now and then.

    Returns
    -------
    Manifest
        What was written.

    Raises
    ------
    OutputError
        If the folder cannot be written, or holds what must stay; before anything is simulated.
    InputError, RunError
        As `cosim.simulate` does; nothing is written then, but for what was streamed before an error of a run.
    RunInterruptedError
        As `cosim.stream` does.
    """
    for name in job.variants:
        job.scenario.variant(name)
    if len(job.labels) > 1:
        refuse_unfit_variants(job.scenario, job.labels, job.options.packaging)
    sink, manifest = _sink(job, folder), Manifest.begun(job.scenario, job.to_json())
    with sink.opened(manifest) as place:
        return _complete(job, sink, place, manifest, progress)


def resume_job(folder: Path, started: Callable[[Job], None], progress: JobProgress) -> Manifest:
    """Go on with an unfinished job.

    Parameters
    ----------
    folder : Path
        Of a streamed job that `run_job` has begun.
    started : callable
        Told what is run before it goes on.
    progress : callable
        Called now and then.

    Raises
    ------
    CheckpointError
        If the folder holds no unfinished run.
    InputError, RunError, RunInterruptedError
        As `cosim.stream` does.
    """
    manifest = Manifest.read(folder)
    if manifest is None or manifest.job is None:
        raise CheckpointError(f"{folder} holds no unfinished run")
    with _opened_job(manifest.job, folder) as job:
        started(job)
        return _complete(job, _sink(job, folder), folder, manifest, progress)


def _complete(job: Job, sink: _Sink, folder: Path, manifest: Manifest, progress: JobProgress) -> Manifest:
    """Run the variants that are not complete, and write the manifest after each and at the end."""
    title, signals = job.scenario.title or job.scenario.name, job.scenario.signals
    complete = {variant.label for variant in manifest.variants}
    results: dict[str, Result] = {}
    for label, subfolder in zip(job.labels, map(Path, job.subfolders), strict=True):
        if label in complete:
            continue
        result = sink.run(job.scenario, job.options_of(label), folder / subfolder, partial(progress, label))
        trajectory, figure = (subfolder / sink.trajectory).as_posix(), None
        if sink.keeps_results:
            results[label] = result
        else:
            figure = (subfolder / FIGURE).as_posix()
            reporting.draw(folder / figure, title, {label: result}, signals)
        made = RunReport.from_record(result.record)
        manifest = manifest.with_variant(
            VariantReport(made, trajectory, dict(result.units), reporting.find(result), figure)
        )
        manifest.write(folder)
    manifest = replace(manifest, job=None)
    if results:
        reporting.draw(folder / FIGURE, title, results, signals)
        manifest = replace(manifest, figure=FIGURE)
    manifest.write(folder)
    return manifest


class _Sink(Protocol):
    """A place for the rows of a job."""

    @property
    def trajectory(self) -> str:
        """Name the file or folder of a variant's rows."""
        ...

    @property
    def keeps_results(self) -> bool:
        """Tell whether the results of all variants are at hand in the end, for a figure of them all."""
        ...

    def opened(self, manifest: Manifest) -> AbstractContextManager[Path]:
        """Make the folder for a new job, and give the path to write to."""
        ...

    def run(self, scenario: Scenario, options: RunOptions, place: Path, progress: Progress) -> Result:
        """Run a variant, with its rows in a place; return what is to be measured and drawn."""
        ...


def _sink(job: Job, folder: Path) -> _Sink:
    """Return the sink that a job asks for."""
    return _MemorySink(folder, job.subfolders) if job.streaming is None else _DiskSink(folder, job.streaming)


@dataclass(frozen=True)
class _MemorySink:
    """A sink that keeps rows, and writes them when a variant is complete."""

    folder: Path
    subfolders: tuple[str, ...]
    trajectory: str = csv_file(Path(), 1).name
    keeps_results: bool = True

    def opened(self, manifest: Manifest) -> AbstractContextManager[Path]:
        """Give a draft that takes the folder's name if all goes well."""
        del manifest
        rows = ((Path(name) / self.trajectory).as_posix() for name in self.subfolders)
        return run_folder(self.folder, [MANIFEST, FIGURE, *rows])

    def run(self, scenario: Scenario, options: RunOptions, place: Path, progress: Progress) -> Result:
        """Run a variant and write its rows."""
        result = run(scenario, options, progress)
        place.mkdir(exist_ok=True)
        result.to_csv(place / self.trajectory)
        return result


@dataclass(frozen=True)
class _DiskSink:
    """A sink that writes rows as they come; a run that was begun in the folder goes on."""

    folder: Path
    streaming: Streaming
    keeps_results: bool = False

    @property
    def trajectory(self) -> str:
        """Name the file or folder of a variant's rows."""
        return csv_file(Path(), 1).name if self.streaming.csv else TRAJECTORY

    @contextmanager
    def opened(self, manifest: Manifest) -> Generator[Path]:
        """Make the folder, with a manifest to resume from; a run that ends before any row leaves nothing."""
        refuse_occupied(self.folder)
        place, made = Path(os.path.realpath(self.folder)), list[Path]()
        try:
            made = make_folders(place)
            manifest.write(place)
        except OSError as error:
            remove_empty(made)
            raise OutputError(f"output folder {self.folder} cannot be written: {error.strerror or error}") from error
        try:
            yield self.folder
        except CosimError:
            if not any(path.is_file() for path in place.rglob("*") if path != place / MANIFEST):
                (place / MANIFEST).unlink(missing_ok=True)
                remove_empty([*(path for path in place.iterdir() if path.is_dir()), *made])
            raise

    def run(self, scenario: Scenario, options: RunOptions, place: Path, progress: Progress) -> Result:
        """Run a variant, or go on with it; an interrupt tells the folder to resume."""
        resume = (place / CHECKPOINT).exists()
        if not resume:
            _clear(place)
        try:
            return run_streamed(scenario, options, self.streaming, place, resume=resume, progress=progress)
        except RunInterruptedError as error:
            raise RunInterruptedError(self.folder, error.time, can_resume=error.can_resume) from None
        except KeyboardInterrupt:
            raise RunInterruptedError(self.folder, None, can_resume=True) from None


def _clear(place: Path) -> None:
    """Remove what a run has left that ended before its first checkpoint."""
    shutil.rmtree(place / TRAJECTORY, ignore_errors=True)
    for path in place.glob("trajectory*.csv"):
        if re.fullmatch(r"trajectory(_\d+)?\.csv", path.name):
            path.unlink()
