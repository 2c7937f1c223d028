"""Run to any length: rows go to disk as they come, and checkpoints let an interrupted run go on.

Ctrl-C and a request to terminate are taken between steps. An FMU may run Python of its own, which would swallow a
KeyboardInterrupt raised within it and report a failed step instead. So the signal is only noted, and the run is left at
the next report of progress.

There is a checkpoint from the first rows on, and the last one, of a run that is complete, has all that is to be
reported of it. It goes only when that has been written: whenever a program is killed, nothing that was stored is lost.
"""

from __future__ import annotations

import json
import logging
import math
import os
import re
import shutil
import signal
import threading
import time
from collections.abc import Callable, Generator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from types import FrameType
from typing import Any, Unpack, cast

from cosim.drilling import reporting
from cosim.errors import CheckpointError, CosimError, OutputError, RunInterruptedError
from cosim.files import refuse_links, why
from cosim.master.run import Progress, Snapshot
from cosim.progress import part_shown
from cosim.recording.result import Result, Rows, Tail, kept_result
from cosim.run.assembly import Assembly, assembled
from cosim.run.checkpoint import CHECKPOINT, Checkpoint, checkpoint_of, snapshot_of, write_checkpoint
from cosim.run.options import INTERVAL, OptionKeywords, RunOptions, Streaming, chosen
from cosim.run.report import RunReport, fitting, plain
from cosim.run.run_folder import held, make_folders, remove_empty
from cosim.run.store import Store, create_csv, csv_file, decimate, reopen_csv, stride_of
from cosim.run.zarr_layout import TRAJECTORY, require_codecs
from cosim.run.zarr_store import create_zarr, reopen_zarr
from cosim.scenario.file import opened_scenario
from cosim.scenario.scenario import Scenario

log = logging.getLogger("cosim")

# What a snapshot that another program has made up can make a restored run raise.
_SENSELESS = (KeyError, ValueError, TypeError, IndexError, AttributeError, OverflowError)


def stream(
    scenario: Scenario | str | Path,
    folder: str | Path,
    *,
    every: Mapping[str, int] | None = None,
    csv: bool = False,
    checkpoint_interval: float = INTERVAL,
    resume: bool = False,
    progress: Progress | bool | None = None,
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
    progress : callable or bool, optional
        Called now and then with the part of the run that is done, from 0 to 1; True: a bar is shown, False: none. By
        default there is one in notebooks and in IPython, after two seconds.
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
    with (
        opened_scenario(scenario, choice.stop_time, choice.step_size) as opened,
        part_shown(progress, f"streaming {opened.name}") as told,
    ):
        result = run_streamed(opened, choice, streaming, Path(folder), resume=resume, progress=told)
    forget(Path(folder))
    return result


def run_streamed(
    scenario: Scenario,
    options: RunOptions,
    streaming: Streaming,
    folder: Path,
    *,
    resume: bool = False,
    anew: bool = False,
    hold: bool = True,
    progress: Progress | None = None,
) -> Result:
    """Run one variant of a scenario to disk; as `stream`, with all options in one.

    The last checkpoint is left, of a run that is complete as well, until `forget` is called.

    Parameters
    ----------
    anew : bool
        Replace what a run has left that ended before its first checkpoint.
    hold : bool
        Keep other programs from going on with the run; the caller may have seen to it.
    """
    with ExitStack() as stack:
        if hold and resume:
            stack.enter_context(held(folder))
        if not resume and not anew:
            _refuse_run(folder)
        saved = saved_run(folder) if resume else None
        if saved is not None:
            streaming = replace(streaming, strides=saved.notes.every, csv=saved.notes.csv)
        if not streaming.csv:
            require_codecs("writing Zarr")
        assembly = stack.enter_context(assembled(scenario, options))
        run = _StreamedRun(scenario, assembly, folder, streaming, anew=anew)
        run.refuse_other(saved)
        if saved is not None and saved.notes.record is not None:
            return finish(folder, saved)
        _warn_of_stateless(assembly)
        with _opened(run, saved):
            if hold and not resume:
                stack.enter_context(held(folder))
            _advance(run, streaming.checkpoint_interval, progress, first=saved is None)
            return run.complete()


def saved_run(folder: Path) -> Checkpoint:
    """Read the checkpoint of a run; CheckpointError if there is none to be gone on from."""
    try:
        refuse_links(folder, CHECKPOINT, TRAJECTORY)
    except OSError as error:
        raise CheckpointError(f"output folder {folder}: {why(error)}") from None
    return checkpoint_of(folder / CHECKPOINT)


def forget(folder: Path) -> None:
    """Remove the checkpoint of a run that has been reported.

    Raises
    ------
    OutputError
        If it cannot be removed.
    """
    try:
        (folder / CHECKPOINT).unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"{folder / CHECKPOINT} cannot be removed: {why(error)}") from error


def has_rows(folder: Path) -> bool:
    """Tell whether a run has stored anything in a folder."""
    return (folder / TRAJECTORY).exists() or csv_file(folder, 1).exists() or any(folder.glob("trajectory_*.csv"))


def finish(folder: Path, saved: Checkpoint) -> Result:
    """Return the result of a run whose last checkpoint says that it is complete, once its rows have been checked.

    Raises
    ------
    CheckpointError
        If the checkpoint makes no sense.
    OutputError
        If rows are damaged or missing.
    """
    notes = saved.notes
    try:
        record = fitting(RunReport.from_record(notes.record or {})).record()
        columns = {stride_of(name): () for name in notes.position}
        store: Store = (
            reopen_csv(folder, columns, notes.position, notes.proof)
            if notes.csv
            else reopen_zarr(folder / TRAJECTORY, None, notes.position, notes.proof)
        )
        result = kept_result(saved.arrays, notes.units or {}, record)
        reporting.find(result)
        try:
            store.close(_attributes("complete", float(result.time[-1]), record))
        finally:
            store.release()
    except _SENSELESS as error:
        raise CheckpointError(f"{folder / CHECKPOINT} is damaged: {why(error)}") from error
    return result


def _attributes(state: str, reached: float, record: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a store is to tell of a run."""
    return plain({"state": state, "reached": reached, **record})


class _StreamedRun:
    """A run whose rows go to a store, and the tail of them that is kept."""

    def __init__(
        self, scenario: Scenario, assembly: Assembly, folder: Path, streaming: Streaming, *, anew: bool
    ) -> None:
        self.master = assembly.master
        self.folder = folder
        self._assembly = assembly
        self._strides, self._csv = dict(streaming.strides), streaming.csv
        self._chosen = decimate(self.master.columns, streaming.strides)
        self._identity = _identity(assembly)
        self._watched = reporting.watched(self.master.columns, scenario.signals)
        self._tail = Tail(self._watched)
        self._title, self._signals = scenario.title or scenario.name, list(scenario.signals)
        self._anew = anew
        self._store: Store

    @property
    def can_resume(self) -> bool:
        """Tell whether all components can give their states."""
        return all(known.can_serialize_state for known in self._assembly.descriptions.values())

    def refuse_other(self, saved: Checkpoint | None) -> None:
        """Refuse to go on with what is of another run, or to replace rows that nothing could go on from."""
        path = self.folder / CHECKPOINT
        difference = saved and _difference(saved.notes.identity, self._identity)
        if difference:
            raise CheckpointError(f"{path} is of another run: {difference}")
        if self._anew and not self.can_resume and has_rows(self.folder):
            raise CheckpointError(
                f"{self.folder} holds a run that cannot be resumed, as {_stateless(self._assembly)}; its rows are left "
                "as they are, and a new run needs another folder"
            )

    def begin(self) -> None:
        """Initialise the components and begin to store."""
        self.master.begin()
        made: list[Path] = []
        try:
            made = make_folders(Path(os.path.realpath(self.folder)))
            if self._anew:
                _clear(self.folder)
            self._store = self._new_store()
        except OSError as error:
            raise OutputError(f"output folder {self.folder} cannot be written: {why(error)}") from error
        except CosimError:
            with suppress(OSError):
                _clear(self.folder)
            remove_empty(made)
            raise

    def _new_store(self) -> Store:
        """Begin to store."""
        if self._csv:
            return create_csv(self.folder, self._chosen)
        source = f"drillstring-cosim {self._assembly.provenance['versions']['drillstring-cosim']}"
        head = {"title": self._title, "source": source, "created": datetime.now(UTC).isoformat(timespec="seconds")}
        attributes = {**head, "state": "running", **self._assembly.initialised(), **self.master.plan}
        return create_zarr(self.folder / TRAJECTORY, self._chosen, plain(attributes))

    def go_on(self, saved: Checkpoint) -> None:
        """Go on from a checkpoint."""
        notes = saved.notes
        self.master.begin()
        try:
            self.master.resume(snapshot_of(saved))
            self._tail.restore(saved.arrays)
            if self._csv:
                self._store = reopen_csv(self.folder, self._chosen, notes.position, notes.proof)
            else:
                self._store = reopen_zarr(self.folder / TRAJECTORY, self._chosen, notes.position, notes.proof)
        except _SENSELESS as error:
            raise CheckpointError(f"{self.folder / CHECKPOINT} is damaged: {why(error)}") from error

    def take(self, rows: Rows) -> None:
        """Keep rows."""
        self._store.take(rows)
        self._tail.take(rows)

    def save(self) -> None:
        """Bring all rows to disk and write a checkpoint, if one can be made."""
        position = self._store.commit()
        if self.can_resume:
            snapshot = self.master.snapshot()
            self._write(position, {"snapshot": snapshot.notes}, snapshot.arrays)

    def _write(self, position: Mapping[str, int], notes: Mapping[str, Any], arrays: Mapping[str, Any]) -> None:
        """Write a checkpoint."""
        common = {
            "identity": self._identity, "every": self._strides, "csv": self._csv,
            "position": dict(position), "proof": dict(self._store.proof),
        }  # fmt: skip
        told = Snapshot({**common, **notes}, {**arrays, **self._tail.arrays()})
        write_checkpoint(self.folder / CHECKPOINT, told)

    def close(self, state: str) -> None:
        """Bring all rows to disk with what is to be told of the run so far."""
        record = self._assembly.report(self.master.account()).record()
        self._store.close(_attributes(state, self.master.time, record))

    def release(self) -> None:
        """Let go of what is open."""
        self._store.release()

    def complete(self) -> Result:
        """End the run; its last checkpoint has what is to be reported of it."""
        self.master.end()
        record = self._assembly.report(self.master.account()).record()
        units = {column.name: column.unit for column in self._watched}
        told = {"record": record, "units": units, "signals": self._signals}
        self._write(self._store.commit(), told, {})
        self._store.close(_attributes("complete", self.master.time, record))
        return self._tail.result(record)


@contextmanager
def _opened(run: _StreamedRun, saved: Checkpoint | None) -> Generator[None]:
    """Begin or go on; should a component fail, leave what was stored before readable."""
    if saved is None:
        run.begin()
    else:
        run.go_on(saved)
    try:
        yield
    except CosimError as error:
        with suppress(OutputError):  # the disk may be full, which is what is told then
            run.close(f"failed: {error}")
        raise
    finally:
        run.release()


def _advance(run: _StreamedRun, interval: float, progress: Progress | None, *, first: bool) -> None:
    """Take all steps, with a checkpoint now and then, and one of the `first` rows."""
    saved = -math.inf if first else time.monotonic()
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


def _clear(folder: Path) -> None:
    """Remove what a run has left that ended before its first checkpoint."""
    if not (folder / TRAJECTORY).is_symlink():
        shutil.rmtree(folder / TRAJECTORY, ignore_errors=True)
    for path in folder.glob("trajectory*.csv"):
        if re.fullmatch(r"trajectory(_\d+)?\.csv", path.name):
            path.unlink()


def _stateless(assembly: Assembly) -> str:
    """Say which components can give no state; nothing if all can."""
    names = [name for name, known in assembly.descriptions.items() if not known.can_serialize_state]
    what = "which lacks canSerializeFMUstate" if len(names) == 1 else "which lack canSerializeFMUstate"
    return f"{' and '.join(names)} cannot give a state, {what}" if names else ""


def _warn_of_stateless(assembly: Assembly) -> None:
    """Name the components for which there can be no checkpoints."""
    if _stateless(assembly):
        log.warning("no checkpoints, as %s", _stateless(assembly))


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
