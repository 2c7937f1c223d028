"""Whatever interrupts a streamed run, nothing that was stored is lost, and what comes of it is what would have come.

Full disks and deaths are put at every single operation that changes the folder.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from collections.abc import Generator
from pathlib import Path

import pytest

from cosim.errors import CheckpointError, InputError, OutputError
from tests.cosim.run.faults import MODES, KilledError, faults
from tests.cosim.run.jobs import Outcome, go_on, manifest_of, outcome, rows_of, sketch, small

pytestmark = [
    pytest.mark.hardening,
    pytest.mark.skipif(sys.platform != "linux", reason="what a descriptor belongs to is asked of /proc"),
]
FORMATS = {"zarr": ("light",), "csv": ("light", "heavy")}


@pytest.fixture
def place(monkeypatch: pytest.MonkeyPatch) -> Generator[Path]:
    """A folder in memory, where there is one: what is waited for a disk thousands of times tells nothing."""
    with tempfile.TemporaryDirectory(dir="/dev/shm" if os.access("/dev/shm", os.W_OK) else None) as folder:
        monkeypatch.setattr(tempfile, "tempdir", folder)
        yield Path(folder)


@pytest.fixture(autouse=True)
def quick_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cosim.drilling.reporting.draw", sketch)


def assert_readable(folder: Path, truth: Outcome) -> None:
    """Assert that what is there is right, and that there is something as soon as there is a checkpoint."""
    try:
        truth.assert_begins_with(Outcome(rows_of(folder), {}))
    except InputError:
        assert not list(folder.rglob("checkpoint.npz"))


@pytest.mark.parametrize("store", FORMATS)
@pytest.mark.parametrize("mode", MODES)
def test_a_fault_at_any_operation_leaves_a_folder_that_is_read_and_gone_on_with(
    store: str, mode: str, place: Path
) -> None:
    job = small(place, *FORMATS[store], csv=store == "csv")
    with faults(place / "truth", mode, 0) as counted:
        go_on(job, place / "truth")
    truth = outcome(place / "truth")
    assert counted.count > 40
    failures = 0
    for at in range(1, counted.count + 1):
        folder = place / "run"
        try:
            with faults(folder, mode, at):
                go_on(job, folder)
        except (OutputError, KilledError):
            failures += 1
        if folder.exists():
            assert_readable(folder, truth)
        if not folder.exists() or "state" in manifest_or_nothing(folder):
            go_on(job, folder)
        with pytest.raises(CheckpointError, match="holds no unfinished run"):
            go_on(job, folder)
        outcome(folder).assert_same(truth)
        assert files(folder) == files(place / "truth")
        shutil.rmtree(folder)
    assert failures > 0.9 * counted.count, "a figure that fails is no failure"


def files(folder: Path) -> set[str]:
    """Name all files, but for figures, which may be missing."""
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.name != "figure.png"}


def manifest_or_nothing(folder: Path) -> dict[str, object]:
    """Return the manifest, or what stands for one that is still to be written."""
    return manifest_of(folder) if (folder / "manifest.json").exists() else {"state": "not begun"}
