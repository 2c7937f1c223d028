"""Run to any length: rows go to disk as they come, and checkpoints let an interrupted run go on.

Ctrl-C and a request to terminate are taken between steps. An FMU may run Python of its own, which would swallow a
KeyboardInterrupt raised within it and report a failed step instead. So the signal is only noted, and the run is left at
the next report of progress.

A checkpoint is all that a run needs to go on, in one file: an .npz archive of NumPy, arrays by name and JSON text among
them. It is written beside its place and takes it when it is complete, so a program that is killed on the way leaves the
checkpoint before.
"""

from __future__ import annotations

import json
import logging
import os
import shutil
import signal
import struct
import threading
import time
import zipfile
import zlib
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from types import FrameType
from typing import Any, Unpack, cast

import numpy as np

from cosim.drilling import reporting
from cosim.errors import CheckpointError, CosimError, OutputError, RunInterruptedError
from cosim.master.run import Progress, Snapshot
from cosim.recording.result import Result, Rows, Tail
from cosim.run.assembly import Assembly, assembled
from cosim.run.options import INTERVAL, OptionKeywords, RunOptions, Streaming, chosen
from cosim.run.report import plain
from cosim.run.run_folder import make_folders, remove_empty
from cosim.run.store import Store, create_csv, csv_file, decimate, reopen_csv
from cosim.run.zarr_store import TRAJECTORY, create_zarr, reopen_zarr, require_zarr
from cosim.scenario.file import opened_scenario
from cosim.scenario.scenario import Scenario

log = logging.getLogger("cosim")

CHECKPOINT = "checkpoint.npz"


def stream(
    scenario: Scenario | str | Path,
    folder: str | Path,
    *,
    every: Mapping[str, int] | None = None,
    csv: bool = False,
    checkpoint_interval: float = INTERVAL,
    resume: bool = False,
    progress: Progress | None = None,
    options: RunOptions | None = None,
    **keywords: Unpack[OptionKeywords],
) -> Result:
    """Run one variant of a scenario, and write its rows to disk as they come.

    Memory does not grow with the length of the run. The first Ctrl-C, or request to terminate, ends the run at the
    next opportunity with all its rows on disk and a checkpoint; a second one ends it at once.

    Parameters
    ----------
    scenario : Scenario, str or Path
        From `cosim.load_scenario`, or made in Python; or the name of one, or the path of a .toml or .ssp file.
    folder : str or Path
        Where to write: ``trajectory.zarr``, which `open_trajectory` and xarray read, and until the run is complete
        ``checkpoint.npz``. Made if need be; must hold neither.
    every : mapping of str to int, optional
        By name or pattern of columns, how many rows apart to store them, 0 for never; by default all of them.
    csv : bool
        Write ``trajectory.csv`` instead.
    checkpoint_interval : float
        Seconds between checkpoints.
    resume : bool
        Go on with the unfinished run in the folder, with the same scenario and options; `every` and `csv` are as they
        were. The results have the same bits as those of an uninterrupted run.
    progress : callable, optional
        Called now and then with the part of the run that is done, from 0 to 1.
    options : RunOptions, optional
        How to run it.
    **keywords
        Options one by one, as of `cosim.simulate`.

    Returns
    -------
    Result
        The last minute of the run, of what is needed to measure and draw it; the record tells of the whole run.

    Raises
    ------
    InputError
        If something asked for does not exist or does not fit, or the folder cannot be written.
    CheckpointError
        If there is no unfinished run, or it is one of something else.
    RunError
        If a component fails on the way. The rows before are on disk, and so is the last checkpoint.
    RunInterruptedError
        If the run was interrupted. It is a KeyboardInterrupt.
    """
    streaming = Streaming(every or {}, csv, checkpoint_interval)
    choice = chosen(options, keywords)
    with opened_scenario(scenario, choice.stop_time, choice.step_size) as opened:
        return run_streamed(opened, choice, streaming, Path(folder), resume=resume, progress=progress)


def run_streamed(
    scenario: Scenario,
    options: RunOptions,
    streaming: Streaming,
    folder: Path,
    *,
    resume: bool = False,
    progress: Progress | None = None,
) -> Result:
    """Run one variant of a scenario to disk; as `stream`, with all options in one."""
    if not resume:
        _refuse_run(folder)
    saved = read_checkpoint(folder / CHECKPOINT) if resume else None
    if saved is not None:
        streaming = replace(streaming, strides=saved.notes["every"], csv=saved.notes["csv"])
    if not streaming.csv:
        require_zarr()
    with assembled(scenario, options) as assembly:
        run = _StreamedRun(scenario, assembly, folder, streaming)
        _warn_of_stateless(assembly)
        with _opened(run, saved):
            _advance(run, streaming.checkpoint_interval, progress)
            return run.complete()


class _StreamedRun:
    """A run whose rows go to a store, and the tail of them that is kept."""

    def __init__(self, scenario: Scenario, assembly: Assembly, folder: Path, streaming: Streaming) -> None:
        self.master = assembly.master
        self.folder = folder
        self._assembly = assembly
        self._strides, self._csv = dict(streaming.strides), streaming.csv
        self._chosen = decimate(self.master.columns, streaming.strides)
        self._identity = _identity(assembly)
        self._tail = Tail(reporting.watched(self.master.columns, scenario.signals))
        self._title = scenario.title or scenario.name
        self._store: Store

    @property
    def can_resume(self) -> bool:
        """Tell whether all components can give their states."""
        return all(known.can_serialize_state for known in self._assembly.descriptions.values())

    def begin(self) -> None:
        """Initialise the components and begin to store."""
        self.master.begin()
        made: list[Path] = []
        try:
            made = make_folders(Path(os.path.realpath(self.folder)))
            self._store = self._new_store()
        except OSError as error:
            raise OutputError(f"output folder {self.folder} cannot be written: {error.strerror or error}") from error
        except CosimError:
            shutil.rmtree(self.folder / TRAJECTORY, ignore_errors=True)
            remove_empty(made)
            raise

    def _new_store(self) -> Store:
        """Begin to store."""
        if self._csv:
            return create_csv(self.folder, self._chosen)
        source = f"drillstring-cosim {self._assembly.provenance['versions']['drillstring-cosim']}"
        head = {"title": self._title, "source": source, "created": datetime.now(UTC).isoformat(timespec="seconds")}
        attributes = {**head, "state": "running", **self._assembly.provenance, **self.master.plan}
        return create_zarr(self.folder / TRAJECTORY, self._chosen, plain(attributes))

    def go_on(self, saved: Snapshot) -> None:
        """Go on from a checkpoint."""
        difference = _difference(saved.notes["identity"], self._identity)
        if difference:
            raise CheckpointError(f"{self.folder / CHECKPOINT} is of another run: {difference}")
        self.master.begin()
        self.master.resume(Snapshot(saved.notes["snapshot"], saved.arrays))
        self._tail.restore(saved.arrays)
        reopen = reopen_csv if self._csv else reopen_zarr
        place = self.folder if self._csv else self.folder / TRAJECTORY
        self._store = reopen(place, self._chosen, saved.notes["position"])

    def take(self, rows: Rows) -> None:
        """Keep rows."""
        self._store.take(rows)
        self._tail.take(rows)

    def save(self) -> None:
        """Write a checkpoint, if one can be made."""
        position = self._store.commit()
        if not self.can_resume:
            return
        snapshot = self.master.snapshot()
        notes = {
            "identity": self._identity, "every": self._strides, "csv": self._csv,
            "position": dict(position), "snapshot": snapshot.notes,
        }  # fmt: skip
        write_checkpoint(self.folder / CHECKPOINT, Snapshot(notes, {**snapshot.arrays, **self._tail.arrays()}))

    def close(self, state: str) -> dict[str, Any]:
        """Bring all rows to disk with what is to be told of the run so far, which is returned."""
        record = self._assembly.report(self.master.account()).record()
        self._store.close(plain({"state": state, "reached": self.master.time, **record}))
        return record

    def complete(self) -> Result:
        """End the run, of which no checkpoint is needed any more."""
        self.master.end()
        record = self.close("complete")
        (self.folder / CHECKPOINT).unlink(missing_ok=True)
        return self._tail.result(record)


@contextmanager
def _opened(run: _StreamedRun, saved: Snapshot | None) -> Generator[None]:
    """Begin or go on; should a component fail, leave what was stored before readable."""
    if saved is None:
        run.begin()
    else:
        run.go_on(saved)
    try:
        yield
    except CosimError as error:
        run.close(f"failed: {error}")
        raise


def _advance(run: _StreamedRun, interval: float, progress: Progress | None) -> None:
    """Take all steps, with a checkpoint now and then."""
    saved = time.monotonic()
    with _signals() as check:
        for rows in run.master.rows():
            run.take(rows)
            try:
                check()
                if progress is not None:
                    progress(run.master.done)
            except KeyboardInterrupt:
                _pause(run)
            if time.monotonic() - saved >= interval:
                run.save()
                saved = time.monotonic()


def _pause(run: _StreamedRun) -> None:
    """Leave a run that can be resumed."""
    run.save()
    run.close("interrupted")
    raise RunInterruptedError(run.folder, run.master.time, can_resume=run.can_resume)


@contextmanager
def _signals() -> Generator[Callable[[], None]]:
    """Note signals where they can be: in the main thread."""
    if threading.current_thread() is threading.main_thread():
        with interruptible(to_the_end=False) as check:  # a run that is complete by then shall be so
            yield check
    else:
        yield lambda: None


def _refuse_run(folder: Path) -> None:
    """Refuse to write over another run."""
    for name in (CHECKPOINT, TRAJECTORY, csv_file(Path(), 1).name):
        if (folder / name).exists():
            raise OutputError(f"{folder / name} is there already; expected a folder without a run")


def _warn_of_stateless(assembly: Assembly) -> None:
    """Name the components for which there can be no checkpoints."""
    names = [name for name, known in assembly.descriptions.items() if not known.can_serialize_state]
    if names:
        what = "which lacks canSerializeFMUstate" if len(names) == 1 else "which lack canSerializeFMUstate"
        log.warning("no checkpoints, as %s cannot give a state, %s", " and ".join(names), what)


def _identity(assembly: Assembly) -> dict[str, Any]:
    """Return all that decides what the results are, as it comes back from JSON."""
    provenance = {name: value for name, value in assembly.provenance.items() if name != "versions"}
    components = {
        name: {key: value for key, value in component.items() if key != "file"}
        for name, component in provenance["components"].items()
    }
    return json.loads(json.dumps(plain({**provenance, "components": components, **assembly.master.plan})))


def _difference(saved: object, present: object, path: str = "") -> str:
    """Say in which first thing two identities differ; nothing if they do not."""
    if isinstance(saved, dict) and isinstance(present, dict):
        one, other = cast(dict[str, Any], saved), cast(dict[str, Any], present)
        for name in dict.fromkeys([*one, *other]):
            inner = f"{path}.{name}" if path else name
            if found := _difference(one.get(name), other.get(name), inner):
                return found
        return ""
    return "" if saved == present else f"{path} is {present!r} now; expected {saved!r}"


@contextmanager
def interruptible(*, to_the_end: bool = True) -> Generator[Callable[[], None]]:
    """Note SIGINT and SIGTERM while the block runs; a second one acts at once.

    Parameters
    ----------
    to_the_end : bool
        Raise KeyboardInterrupt at the end of the block as well, for a signal since the last look.

    Yields
    ------
    callable
        To be called now and then; raises KeyboardInterrupt if there was a signal.
    """
    noted: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        """Take the first signal down, and act on the second."""
        del frame
        if noted:
            raise KeyboardInterrupt
        noted.append(number)

    def check() -> None:
        """Act on a signal that was taken down."""
        if noted:
            raise KeyboardInterrupt

    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield check
        if to_the_end:
            check()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


FORMAT = "cosim-checkpoint-1"
_HEAD = "head"
# What zipfile and NumPy raise on damaged archives.
_DAMAGE = (
    OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, OverflowError, RuntimeError, struct.error,
    zipfile.BadZipFile, zlib.error,
)  # fmt: skip


def write_checkpoint(path: Path, snapshot: Snapshot) -> None:
    """Write a snapshot as a checkpoint, in place of an earlier one.

    Raises
    ------
    OutputError
        If it cannot be written; the earlier one is left alone.
    """
    head = {"format": FORMAT, "arrays": sorted(snapshot.arrays), "notes": snapshot.notes}
    content = np.frombuffer(json.dumps(head).encode(), np.uint8)
    plain = {name: values.astype(str) if values.dtype == object else values for name, values in snapshot.arrays.items()}
    draft = path.with_name(f".{path.name}.new")
    try:
        with draft.open("wb") as file:
            np.savez(file, allow_pickle=False, **{_HEAD: content}, **plain)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(path)
    except OSError as error:
        with suppress(OSError):
            draft.unlink()
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from error


def read_checkpoint(path: Path) -> Snapshot:
    """Read what a checkpoint holds.

    Raises
    ------
    CheckpointError
        If it is not there, is none, is damaged, or is of another version.
    """
    try:
        # opened here: NumPy leaves the file open where the archive turns out to be none
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        head = json.loads(arrays.pop(_HEAD).tobytes())
        found, names, notes = head["format"], head["arrays"], head["notes"]
    except FileNotFoundError:
        raise CheckpointError(f"{path}: there is no such file") from None
    except _DAMAGE as error:
        raise CheckpointError(f"{path} is no checkpoint, or is damaged: {error}") from error
    if found != FORMAT:
        raise CheckpointError(f"{path} is a checkpoint of format {found}; expected {FORMAT}")
    if sorted(arrays) != names:
        raise CheckpointError(f"{path} is damaged: it holds {', '.join(sorted(arrays))}; expected {', '.join(names)}")
    return Snapshot(notes, arrays)
