"""Do a job from scenario to folder: simulate, measure, write and draw every variant.

All jobs go one way; where rows go is up to a sink. `_MemorySink` keeps them, and the folder appears when all is done.
`_DiskSink` streams them, so the folder is there from the beginning, and its manifest tells what is being run and which
variants are complete. An unfinished job is resumed from the folder alone.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from cosim.drilling import reporting
from cosim.errors import CheckpointError, CosimError, OutputError, RunInterruptedError
from cosim.files import refuse_links, why
from cosim.master.run import Progress
from cosim.recording.result import Result
from cosim.run.assembly import refuse_unfit_variants
from cosim.run.checkpoint import CHECKPOINT
from cosim.run.options import RunOptions, Streaming, WrittenOptions
from cosim.run.report import (
    MANIFEST,
    Manifest,
    RunReport,
    VariantReport,
    fitting,
    read_content,
    undamaged,
    was_streamed,
    written_files,
)
from cosim.run.run_folder import held, make_folders, refuse_occupied, remove_empty, run_folder
from cosim.run.simulation import run
from cosim.run.store import csv_file
from cosim.run.stream import finish, forget, has_rows, run_streamed, saved_run
from cosim.run.zarr_layout import TRAJECTORY
from cosim.scenario.file import opened_scenario
from cosim.scenario.scenario import Scenario

log = logging.getLogger("cosim")

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
        """Name the folder of each label within that of the job."""
        return _subfolders(self.labels)

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
            "labels": list(self.labels),
            "streaming": self.streaming.to_json(),
        }


@dataclass(frozen=True)
class _Plan:
    """A job as a manifest tells it, before its scenario is loaded."""

    source: str
    choices: WrittenOptions
    variants: list[str]
    labels: list[str]
    streaming: Streaming

    @classmethod
    def from_json(cls, content: Mapping[str, Any], folder: Path) -> _Plan:
        """Read back what `Job.to_json` returned; OutputError if it is damaged."""
        with undamaged(folder):
            options, streaming = RunOptions.from_json(content["choices"]), Streaming.from_json(content["streaming"])
            rest = {name: content[name] for name in ("source", "variants", "labels")}
            plan = fitting(cls(choices=options, streaming=streaming, **rest))
            for label in plan.labels if len(plan.labels) > 1 else ():
                if label in ("", ".", "..") or Path(label).name != label:
                    raise ValueError(f"{label!r} is no name of a folder")
            if not plan.labels or len(set(plan.labels)) < len(plan.labels):
                raise ValueError("labels are missing, or there twice")
            return replace(plan, choices=replace(plan.choices, overrides=options.overrides))

    @property
    def places(self) -> list[tuple[str, Path]]:
        """Pair each label with the folder of its rows, within that of the job."""
        return list(zip(self.labels, map(Path, _subfolders(self.labels)), strict=True))

    @contextmanager
    def opened(self) -> Generator[Job]:
        """Load the scenario for as long as it is needed."""
        with opened_scenario(self.source, self.choices.stop_time, self.choices.step_size) as scenario:
            job = Job(scenario, RunOptions.of(self.choices), tuple(self.variants), self.streaming, self.source)
            if list(job.labels) != self.labels:
                told = f"its variants are {', '.join(job.labels)} now; expected {', '.join(self.labels)}"
                raise CheckpointError(f"{self.source} is another scenario than the one that was begun: {told}")
            yield job


def _subfolders(labels: Sequence[str]) -> tuple[str, ...]:
    """Name the folder of each label within that of the job: its own, if there are several."""
    return tuple(labels) if len(labels) > 1 else ("",)


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
    with held(folder):
        manifest = Manifest.read(folder)
        if manifest is None or manifest.job is None:
            _forget_finished(folder)
            raise CheckpointError(f"{folder} holds no unfinished run")
        plan = _Plan.from_json(manifest.job, folder)
        _refuse_links(folder, plan)
        manifest = _report_complete(plan, folder, manifest)
        if manifest.job is None:
            return manifest
        with plan.opened() as job:
            started(job)
            return _complete(job, _sink(job, folder), folder, manifest, progress)


def _forget_finished(folder: Path) -> None:
    """Remove checkpoints that a run has left which was killed between its manifest and its end."""
    content = read_content(folder)
    for name in written_files(content) if content is not None and was_streamed(content) else ():
        place = Path(name).parent
        if Path(name).name in (TRAJECTORY, csv_file(Path(), 1).name) and not (folder / place).is_symlink():
            forget(folder / place)


def _refuse_links(folder: Path, plan: _Plan) -> None:
    """Refuse a folder from elsewhere that leads out of itself, before anything is written to it."""
    try:
        refuse_links(folder, *(str(subfolder / CHECKPOINT) for _, subfolder in plan.places))
    except OSError as error:
        raise CheckpointError(f"output folder {folder}: {why(error)}") from None


def _report_complete(plan: _Plan, folder: Path, manifest: Manifest) -> Manifest:
    """Report the variants that lack nothing else: what they were run from may be gone by now."""
    done = {variant.label for variant in manifest.variants}
    sink = _DiskSink(folder, plan.streaming)
    for label, subfolder in plan.places:
        place = folder / subfolder
        if label in done:
            forget(place)
        elif (place / CHECKPOINT).exists():
            saved = saved_run(place)
            if saved.notes.record is not None:
                report = _Report(sink, folder, manifest.title or manifest.scenario, saved.notes.signals or [])
                manifest = report.of(manifest, len(plan.labels), finish(place, saved), subfolder)
    if len(manifest.variants) == len(plan.labels):
        manifest = replace(manifest, job=None)
        manifest.write(folder)
    return manifest


@dataclass(frozen=True)
class _Report:
    """A report of streamed variants, one by one: figure and entry of the manifest, and no checkpoint any more."""

    sink: _DiskSink
    folder: Path
    title: str
    signals: Sequence[str]

    def of(self, manifest: Manifest, variants: int, result: Result, subfolder: Path) -> Manifest:
        """Add a variant to the manifest, which is that of a complete job with the last of them."""
        made = RunReport.from_record(result.record)
        label = made.variant or made.scenario
        figure = _drawn(self.folder, (subfolder / FIGURE).as_posix(), self.title, {label: result}, self.signals)
        trajectory = (subfolder / self.sink.trajectory).as_posix()
        manifest = manifest.with_variant(VariantReport.of(result, trajectory, figure or ""))
        if len(manifest.variants) == variants:
            manifest = replace(manifest, job=None)
        manifest.write(self.folder)
        forget(self.folder / subfolder)
        return manifest


def _drawn(folder: Path, name: str, title: str, results: Mapping[str, Result], signals: Sequence[str]) -> str | None:
    """Draw a figure and return its name; None if it cannot be drawn, which is no reason to lose results."""
    try:
        reporting.draw(folder / name, title, results, signals)
    except Exception as error:  # whatever matplotlib makes of what it is given
        log.warning("there is no figure %s: %s", name, why(error))
        return None
    return name


def _complete(job: Job, sink: _Sink, folder: Path, manifest: Manifest, progress: JobProgress) -> Manifest:
    """Run the variants that are not complete, and write the manifest after each, or at the end."""
    title, signals = job.scenario.title or job.scenario.name, job.scenario.signals
    complete = {variant.label for variant in manifest.variants}
    results: dict[str, Result] = {}
    for label, subfolder in zip(job.labels, map(Path, job.subfolders), strict=True):
        if label in complete:
            continue
        result = sink.run(job.scenario, job.options_of(label), folder / subfolder, partial(progress, label))
        if isinstance(sink, _DiskSink):
            manifest = _Report(sink, folder, title, signals).of(manifest, len(job.labels), result, subfolder)
            continue
        results[label] = result
        manifest = manifest.with_variant(VariantReport.of(result, (subfolder / sink.trajectory).as_posix()))
    if results:
        manifest = replace(manifest, figure=_drawn(folder, FIGURE, title, results, signals))
        manifest.write(folder)
    return manifest


class _Sink(Protocol):
    """A place for the rows of a job."""

    @property
    def trajectory(self) -> str:
        """Name the file or folder of a variant's rows."""
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

    def opened(self, manifest: Manifest) -> AbstractContextManager[Path]:
        """Give a draft that takes the folder's name if all goes well."""
        del manifest
        rows = ((Path(name) / self.trajectory).as_posix() for name in self.subfolders)
        return run_folder(self.folder, [MANIFEST, FIGURE, *rows])

    def run(self, scenario: Scenario, options: RunOptions, place: Path, progress: Progress) -> Result:
        """Run a variant and write its rows."""
        result = run(scenario, options, progress)
        try:
            place.mkdir(exist_ok=True)
            result.to_csv(place / self.trajectory)
        except OSError as error:
            raise OutputError(f"output folder {self.folder} cannot be written: {why(error)}") from error
        return result


@dataclass(frozen=True)
class _DiskSink:
    """A sink that writes rows as they come; a run that was begun in the folder goes on."""

    folder: Path
    streaming: Streaming

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
        except OSError as error:
            raise OutputError(f"output folder {self.folder} cannot be written: {why(error)}") from error
        with held(place):
            try:
                manifest.write(place)
                yield self.folder
            except CosimError:
                if not any(path.is_file() for path in place.rglob("*") if path != place / MANIFEST):
                    (place / MANIFEST).unlink(missing_ok=True)
                    remove_empty([*(path for path in place.iterdir() if path.is_dir()), *made])
                raise

    def run(self, scenario: Scenario, options: RunOptions, place: Path, progress: Progress) -> Result:
        """Run a variant, or go on with it; an interrupt tells the folder to resume."""
        resume = (place / CHECKPOINT).exists()
        try:
            return run_streamed(
                scenario,
                options,
                self.streaming,
                place,
                resume=resume,
                anew=not resume,
                hold=False,
                progress=progress,
            )
        except RunInterruptedError as error:
            raise RunInterruptedError(self.folder, error.time, can_resume=error.can_resume) from None
        except KeyboardInterrupt:
            can_resume = (place / CHECKPOINT).exists() or not has_rows(place)
            raise RunInterruptedError(self.folder, None, can_resume=can_resume) from None
