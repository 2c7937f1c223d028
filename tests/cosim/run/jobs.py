"""Small streamed jobs for attacks on their folders, and what must come of them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim import RunOptions, load_scenario, open_trajectory
from cosim.files import replace_file
from cosim.run.job import Job, resume_job, run_job
from cosim.run.options import Streaming

FEW = {"*": 0, "plant.bit_speed": 1, "plant.bit_stuck": 1, "plant.slip_count": 10}
"""Columns that small jobs store: all types of numbers, in two distances."""
SCENARIO = """
stop_time = 0.96
step_size = 0.01
components.plant.fmu = "DrillstringNeutral"

[[variants]]
name = "light"
set = { "plant.WOB" = 6e4, "plant.Omega" = 5.0 }

[[variants]]
name = "heavy"
set = { "plant.WOB" = 9e4, "plant.Omega" = 5.0 }
"""


def small(folder: Path, *variants: str, csv: bool = False, **options: Any) -> Job:
    """A job of 97 rows a variant, with a checkpoint after each 32 of them; its scenario is written to a folder."""
    path = folder / "small.toml"
    path.write_text(SCENARIO, encoding="utf-8")
    return Job(load_scenario(path), RunOptions(**options), variants, Streaming(FEW, csv, 0.0), str(path))


def nothing(label: str, part: float) -> None:
    """Show no progress."""


def sketch(path: Path, title: str, *rest: Any) -> None:
    """Write a figure the way `reporting.draw` does, without drawing it for a third of a second."""
    replace_file(path, f"a figure of {title}".encode())


def go_on(job: Job, folder: Path) -> None:
    """Begin a job, or go on with it."""
    if (folder / "manifest.json").exists():
        resume_job(folder, lambda job: None, nothing)
    else:
        run_job(job, folder, nothing)


@dataclass(frozen=True)
class Outcome:
    """What a job leaves: rows by file and column, and what its manifest tells but for times."""

    rows: dict[str, NDArray[Any]]
    told: dict[str, Any]

    def assert_same(self, other: Outcome) -> None:
        assert self.told == other.told
        assert self.rows.keys() == other.rows.keys()
        for name, values in self.rows.items():
            assert values.dtype == other.rows[name].dtype
            assert values.tobytes() == other.rows[name].tobytes(), name

    def assert_begins_with(self, found: Outcome) -> None:
        """Assert that what is there of a run that is not complete are its first rows."""
        for name, values in found.rows.items():
            assert values.tobytes() == self.rows[name][: values.size].tobytes(), name


def manifest_of(folder: Path) -> dict[str, Any]:
    """What a manifest tells, but for when it was written, how long it took, and whether a figure could be drawn."""
    told = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    del told["created"], told["sha256"]
    for variant in told["variants"]:
        del variant["timings"], variant["figure"]
    return told


def rows_of(folder: Path) -> dict[str, NDArray[Any]]:
    """All rows in a folder, by file and column."""
    rows: dict[str, NDArray[Any]] = {}
    for path in sorted(folder.rglob("trajectory.zarr")):
        with open_trajectory(path) as found:
            for name in (*found.coords, *found.data_vars):
                rows[f"{path.relative_to(folder)} {name}"] = found[name].values
    for path in sorted(folder.rglob("trajectory*.csv")):
        rows[str(path.relative_to(folder))] = np.frombuffer(path.read_bytes(), np.uint8)
    return rows


def outcome(folder: Path) -> Outcome:
    """Read what a job has left."""
    return Outcome(rows_of(folder), manifest_of(folder))
