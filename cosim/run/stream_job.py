"""A streamed run from scenario to folder, and back from an unfinished folder to a run.

The folder is there from the beginning. Its manifest tells what is being run, so that the run can be resumed from the
folder alone, and which variants are complete.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from cosim.drilling.figure import draw
from cosim.errors import CheckpointError, InputError, OutputError, RunInterruptedError
from cosim.fmi2.isolation import Limits
from cosim.run.assembly import versions
from cosim.run.job import Job, Outcome, Progress, assess, measures_from_json
from cosim.run.options import Choices
from cosim.run.run_folder import (
    FIGURE,
    MANIFEST,
    UNFINISHED,
    commit,
    read_manifest,
    refuse_occupied,
    variant_entry,
    write_manifest,
)
from cosim.run.store import csv_file
from cosim.run.stream import CHECKPOINT, INTERVAL, TRAJECTORY, stream
from cosim.scenario.file import opened_scenario

Started = Callable[[Job], None]
"""Told what is run before it begins."""


@dataclass(frozen=True)
class Streaming:
    """How to stream; see `cosim.stream`."""

    every: Mapping[str, int] = field(default_factory=dict[str, int])
    csv: bool = False
    checkpoint_interval: float = INTERVAL


def stream_job(job: Job, source: str, streaming: Streaming, folder: Path, progress: Progress) -> dict[str, Outcome]:
    """Run all variants, and write their rows to a folder as they come.

    Parameters
    ----------
    job : Job
        What to run.
    source : str
        Where its scenario is from, as `cosim.scenario.file.opened_scenario` takes it.
    streaming : Streaming
        How to stream.
    folder : Path
        Made if need be; must be empty.
    progress : callable
        Called now and then.

    Returns
    -------
    dict of str to Outcome
        By variant.

    Raises
    ------
    OutputError
        If the folder holds anything, or cannot be written.
    InputError, RunError, RunInterruptedError
        As `cosim.stream` does.
    """
    for name in job.variants:
        job.scenario.variant(name)
    refuse_occupied(folder)
    given = Path(source)
    written = {
        "source": str(given.absolute()) if given.suffix else source,
        "choices": asdict(job.choices),
        "variants": list(job.variants),
        "streaming": asdict(streaming),
    }
    head = {
        "scenario": job.scenario.name,
        "title": job.scenario.title,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "versions": versions(),
        "commit": commit(),
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_manifest(folder, {**head, "state": UNFINISHED, "job": written, "variants": []})
    except OSError as error:
        raise OutputError(f"output folder {folder} cannot be written: {error.strerror or error}") from error
    try:
        return _run(job, streaming, folder, progress)
    except InputError:
        _remove_unbegun(folder)
        raise


def resume_job(folder: Path, started: Started, progress: Progress) -> dict[str, Outcome]:
    """Go on with an unfinished run.

    Parameters
    ----------
    folder : Path
        Of a run that `stream_job` has begun.
    started : callable
        Called with what is run.
    progress : callable
        Called now and then.

    Raises
    ------
    CheckpointError
        If the folder holds no unfinished run.
    InputError, RunError, RunInterruptedError
        As `cosim.stream` does.
    """
    manifest = read_manifest(folder)
    if manifest is None or manifest.get("state") != UNFINISHED:
        raise CheckpointError(f"{folder} holds no unfinished run")
    written, limits = manifest["job"], manifest["job"]["choices"]["limits"]
    chosen: dict[str, Any] = {**written["choices"], "limits": Limits(**limits) if limits else None}
    choices = Choices(**chosen)
    streaming = Streaming(**written["streaming"])
    with opened_scenario(written["source"], choices.stop_time, choices.step_size) as scenario:
        job = Job(scenario, choices, tuple(written["variants"]))
        started(job)
        return _run(job, streaming, folder, progress)


def _run(job: Job, streaming: Streaming, folder: Path, progress: Progress) -> dict[str, Outcome]:
    """Run the variants that are not complete."""
    manifest = dict(read_manifest(folder) or {})
    entries: list[dict[str, Any]] = list(manifest["variants"])
    outcomes = {_label(job, entry): Outcome(entry, measures_from_json(entry["measures"])) for entry in entries}
    for label in job.labels:
        if label in outcomes:
            continue
        subfolder = label if len(job.labels) > 1 else ""
        outcome, entry = _run_variant(job, label, streaming, folder, subfolder, progress)
        outcomes[label] = outcome
        entries.append(entry)
        write_manifest(folder, {**manifest, "variants": entries})
    del manifest["state"], manifest["job"]
    write_manifest(folder, {**manifest, "variants": entries})
    return outcomes


def _run_variant(
    job: Job, label: str, streaming: Streaming, folder: Path, subfolder: str, progress: Progress
) -> tuple[Outcome, dict[str, Any]]:
    """Run a variant, or go on with it; return what came of it and its entry for the manifest."""
    choices = replace(job.choices, variant=label if job.scenario.variants else None)
    place = folder / subfolder
    resume = (place / CHECKPOINT).exists()
    if not resume:
        _clear(place)
    try:
        result = stream(
            job.scenario,
            place,
            every=streaming.every,
            csv=streaming.csv,
            checkpoint_interval=streaming.checkpoint_interval,
            resume=resume,
            progress=lambda part: progress(label, part),
            **{name: getattr(choices, name) for name in choices.__dataclass_fields__},
        )
    except RunInterruptedError as error:
        raise RunInterruptedError(folder, error.time, can_resume=error.can_resume) from None
    except KeyboardInterrupt:
        raise RunInterruptedError(folder, None, can_resume=True) from None
    outcome = assess(result)
    title = job.scenario.title or job.scenario.name
    draw(place / FIGURE, title, {label: result}, job.scenario.signals)
    trajectory = Path(subfolder, csv_file(Path(), 1).name if streaming.csv else TRAJECTORY).as_posix()
    entry = variant_entry(result, outcome.measures, outcome.energy, trajectory)
    return outcome, {**json.loads(json.dumps(entry)), "figure": Path(subfolder, FIGURE).as_posix()}


def _remove_unbegun(folder: Path) -> None:
    """Remove a run that was refused before any row was stored."""
    if [path.name for path in folder.iterdir()] == [MANIFEST]:
        (folder / MANIFEST).unlink()
        folder.rmdir()


def _clear(place: Path) -> None:
    """Remove what a run has left that ended before its first checkpoint."""
    shutil.rmtree(place / TRAJECTORY, ignore_errors=True)
    for path in place.glob("trajectory*.csv"):
        path.unlink()


def _label(job: Job, entry: Mapping[str, Any]) -> str:
    """Return the name of a variant, or of the scenario, from its entry."""
    return entry["variant"] or job.scenario.name
