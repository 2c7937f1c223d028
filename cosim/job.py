"""One run from scenario to folder: every variant simulated, measured, written and drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar

from cosim.energy import energy_balance
from cosim.figure import draw
from cosim.isolated_process import Limits
from cosim.metrics import Measures, measure
from cosim.result import Result
from cosim.scenario import Scenario
from cosim.signals import Value
from cosim.simulation import simulate, versions
from cosim.store import FIGURE, run_folder, write_manifest, write_variant

Found = TypeVar("Found")
Progress = Callable[[str, float], None]
"""Told now and then which part, from 0 to 1, of which variant is done."""


@dataclass(frozen=True)
class Job:
    """What to run and how; None leaves the scenario's own choice."""

    scenario: Scenario
    packaging: str = "native"
    algorithm: str | None = None
    step_size: float | None = None
    stop_time: float | None = None
    overrides: Mapping[str, Value] | None = None
    variants: Sequence[str] = ()
    tolerance: float | None = None
    on_failure: str | None = None
    isolate: bool = False
    limits: Limits | None = None

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of what will be run: the chosen variants, or the scenario itself if it has none."""
        names = [variant.name for variant in self.scenario.variants]
        return tuple(self.variants) or tuple(names) or (self.scenario.name,)


@dataclass(frozen=True)
class Outcome:
    """One variant's result and measures."""

    result: Result
    measures: Measures | None


def run_job(job: Job, output: Path, progress: Progress) -> dict[str, Outcome]:
    """Run all variants and write trajectories, manifest and figure to a folder, which appears when all is done.

    Parameters
    ----------
    job : Job
        What to run.
    output : Path
        The folder; an earlier run in it is replaced.
    progress : callable
        Called now and then.

    Returns
    -------
    dict of str to Outcome
        By variant.

    Raises
    ------
    OutputError
        If the folder cannot be written; before anything is simulated.
    InputError, RunError
        As `cosim.simulate` does; nothing is written then.
    """
    scenario = job.scenario
    for name in job.variants:
        scenario.variant(name)
    outcomes: dict[str, Outcome] = {}
    entries: list[dict[str, Any]] = []
    with run_folder(output) as folder:
        for label in job.labels:
            result = _simulate(job, label, progress)
            outcomes[label] = Outcome(result, _of_plant(result, measure))
            subfolder = label if len(job.labels) > 1 else ""
            energy = _of_plant(result, energy_balance)
            entries.append(write_variant(folder, subfolder, result, outcomes[label].measures, energy))
        title = scenario.title or scenario.name
        draw(folder / FIGURE, title, {label: outcomes[label].result for label in outcomes}, scenario.signals)
        created = datetime.now(UTC).isoformat(timespec="seconds")
        head = {"scenario": scenario.name, "title": scenario.title, "created": created, "versions": versions()}
        write_manifest(folder, {**head, "figure": FIGURE, "variants": entries})
    return outcomes


def _simulate(job: Job, label: str, progress: Progress) -> Result:
    """Run one variant."""
    return simulate(
        job.scenario,
        packaging=job.packaging,
        algorithm=job.algorithm,
        tolerance=job.tolerance,
        on_failure=job.on_failure,
        step_size=job.step_size,
        stop_time=job.stop_time,
        overrides=job.overrides,
        variant=label if job.scenario.variants else None,
        isolate=job.isolate,
        limits=job.limits,
        progress=lambda part: progress(label, part),
    )


def _of_plant(result: Result, look: Callable[[Result, str], Found | None]) -> Found | None:
    """Return what is found of the first component that has it."""
    components = dict.fromkeys(name.partition(".")[0] for name in result.names)
    found = (look(result, component) for component in components)
    return next((one for one in found if one is not None), None)
