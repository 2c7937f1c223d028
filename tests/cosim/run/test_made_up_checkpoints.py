"""Checkpoints that somebody has made up, whole and in order as files: each is refused in a sentence, or makes sense."""

from __future__ import annotations

import copy
import random
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim import RunOptions, load_scenario
from cosim.errors import CosimError, RunInterruptedError
from cosim.master.run import Snapshot
from cosim.run.checkpoint import read_checkpoint, write_checkpoint
from cosim.run.job import Job, resume_job, run_job
from cosim.run.options import Streaming
from cosim.run.report import Manifest
from tests.cosim.run.faults import KilledError
from tests.cosim.run.jobs import FEW, nothing, sketch, small

pytestmark = pytest.mark.hardening
VALUES: tuple[Any, ...] = (
    None, "x", -1, 0, [], {}, 1e308, 2**70, float("nan"), True, [1, 2, 3], {"a": 1}, "\x1b",
)  # fmt: skip
ARRAYS = ("missing", "short", "long", "deep", "rounded", "nan", "empty", "text")


@pytest.fixture
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Folders of an explicit and of an implicit run that were interrupted, and of one that lacks its report."""
    monkeypatch.setattr("cosim.drilling.reporting.draw", sketch)

    def interrupt(label: str, part: float) -> None:
        if part > 0.5:
            raise KeyboardInterrupt

    for algorithm in ("jacobi", "implicit"):
        options = RunOptions(algorithm=algorithm, step_size=0.02, stop_time=2.0)
        streaming = Streaming(FEW, algorithm == "implicit", 0.0)
        job = Job(load_scenario("dissipative-law"), options, ("tracking",), streaming, "dissipative-law")
        with pytest.raises(RunInterruptedError):
            run_job(job, tmp_path / algorithm, interrupt)
    written = Manifest.write

    def killed(manifest: Manifest, folder: Path) -> None:
        if manifest.variants:
            raise KilledError
        written(manifest, folder)

    with monkeypatch.context() as patch:
        patch.setattr(Manifest, "write", killed)
        with pytest.raises(KilledError):
            run_job(small(tmp_path, "light"), tmp_path / "complete", nothing)
    return [tmp_path / name for name in ("jacobi", "implicit", "complete")]


def paths(value: Any, above: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Give the way to each part of what JSON holds."""
    yield above
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from paths(inner, (*above, key))
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from paths(inner, (*above, index))


def with_other_note(notes: dict[str, Any], rng: random.Random) -> str:
    """Change or remove a part of some notes, and say which."""
    way = rng.choice([each for each in paths(notes) if each and each[0] != "identity"])
    inner = notes
    for key in way[:-1]:
        inner = inner[key]
    if rng.random() < 0.3 and isinstance(inner, dict):
        del inner[way[-1]]
        return f"{way} missing"
    inner[way[-1]] = rng.choice(VALUES)
    return f"{way} = {inner[way[-1]]!r}"


def with_other_array(arrays: dict[str, Any], rng: random.Random) -> str:
    """Change or remove one of some arrays, and say which."""
    name, way = rng.choice(list(arrays)), rng.choice(ARRAYS)
    old = arrays.pop(name)
    if way != "missing":
        arrays[name] = {
            "short": old[:-1], "long": np.concatenate([old, old]), "deep": old[None], "empty": old[:0],
            "rounded": old if old.dtype.kind == "U" else old.astype(np.float32),
            "nan": np.full(old.shape, np.nan), "text": np.full(old.shape, "x"),
        }[way]  # fmt: skip
    return f"{name} {way}"


def test_a_checkpoint_that_was_made_up_is_one_sentence_or_makes_sense(folders: list[Path], tmp_path: Path) -> None:
    rng, refused = random.Random(5), 0
    for _ in range(150):
        copied = tmp_path / "copy"
        shutil.copytree(rng.choice(folders), copied)
        path = copied / "checkpoint.npz"
        saved = read_checkpoint(path)
        notes, arrays = copy.deepcopy(dict(saved.notes)), dict(saved.arrays)
        how = with_other_note(notes, rng) if rng.random() < 0.7 else with_other_array(arrays, rng)
        write_checkpoint(path, Snapshot(notes, arrays))
        try:
            resume_job(copied, lambda job: None, nothing)
        except CosimError as error:
            refused += "\n" not in str(error)
        except BaseException as error:
            error.add_note(how)
            raise
        shutil.rmtree(copied)
    assert refused > 75, "most of what is in a checkpoint is needed"
