"""One run from scenario to folder: every variant simulated, measured, written and drawn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar

from cosim.drilling.energy import EnergyBalance, energy_balance
from cosim.drilling.figure import draw
from cosim.drilling.oscillation import Measures, measure
from cosim.recording.result import Result
from cosim.run.assembly import versions
from cosim.run.options import Choices
from cosim.run.run_folder import FIGURE, commit, run_folder, write_manifest, write_variant
from cosim.run.simulation import run
from cosim.scenario.scenario import Scenario

Found = TypeVar("Found")
Progress = Callable[[str, float], None]
"""Told now and then which part, from 0 to 1, of which variant is done."""


@dataclass(frozen=True)
class Job:
    """What to run and how; the variants, by default all, are chosen here."""

    scenario: Scenario
    choices: Choices = field(default_factory=Choices)
    variants: Sequence[str] = ()

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of what will be run: the chosen variants, or the scenario itself if it has none."""
        names = [variant.name for variant in self.scenario.variants]
        return tuple(self.variants) or tuple(names) or (self.scenario.name,)


@dataclass(frozen=True)
class Outcome:
    """What is to be told of one variant's run, its measures, and where its energy went."""

    record: Mapping[str, Any]
    measures: Measures | None
    energy: EnergyBalance | None = None


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
    results: dict[str, Result] = {}
    entries: list[dict[str, Any]] = []
    with run_folder(output) as folder:
        for label in job.labels:
            results[label] = result = _simulate(job, label, progress)
            outcomes[label] = outcome = assess(result)
            subfolder = label if len(job.labels) > 1 else ""
            entries.append(write_variant(folder, subfolder, result, outcome.measures, outcome.energy))
        title = scenario.title or scenario.name
        draw(folder / FIGURE, title, results, scenario.signals)
        created = datetime.now(UTC).isoformat(timespec="seconds")
        head = {"scenario": scenario.name, "title": scenario.title, "created": created}
        made_by = {"versions": versions(), "commit": commit()}
        write_manifest(folder, {**head, **made_by, "figure": FIGURE, "variants": entries})
    return outcomes


def _simulate(job: Job, label: str, progress: Progress) -> Result:
    """Run one variant."""
    choices = replace(job.choices, variant=label if job.scenario.variants else None)
    return run(job.scenario, choices, lambda part: progress(label, part))


def assess(result: Result) -> Outcome:
    """Measure the first component that has a bit, and balance the energy of the first that tells it."""
    return Outcome(result.record, _of_plant(result, measure), _of_plant(result, energy_balance))


def measures_from_json(content: Mapping[str, Any] | None) -> Measures | None:
    """Read measures back from a manifest."""
    if content is None:
        return None
    values: dict[str, Any] = {**content, "ssi": float(content["ssi"])}
    return Measures(**values)


def _of_plant(result: Result, look: Callable[[Result, str], Found | None]) -> Found | None:
    """Return what is found of the first component that has it."""
    components = dict.fromkeys(name.partition(".")[0] for name in result.names)
    found = (look(result, component) for component in components)
    return next((one for one in found if one is not None), None)
