"""Runs of any length: rows go to disk as they come, and checkpoints let an interrupted run go on."""

from __future__ import annotations

import json
import logging
import threading
import time
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, cast

from cosim.drilling import energy, metrics
from cosim.drilling.figure import default_signals
from cosim.errors import CheckpointError, CosimError, OutputError, RunInterruptedError
from cosim.master.stepping.run import Progress, Snapshot
from cosim.recording.result import Result
from cosim.recording.rows import Column, Rows
from cosim.run.assembly import Assembly, assembled
from cosim.run.interrupt import interruptible
from cosim.run.options import Choices
from cosim.run.plain import plain
from cosim.run.streaming.checkpoint import Checkpoint, read_checkpoint, write_checkpoint
from cosim.run.streaming.csv_store import create_csv, csv_file, reopen_csv
from cosim.run.streaming.decimation import decimate
from cosim.run.streaming.store import Store
from cosim.run.streaming.tail import Tail
from cosim.run.streaming.zarr_store import create_zarr, reopen_zarr, require_zarr
from cosim.scenario.scenario import Scenario

log = logging.getLogger("cosim")

CHECKPOINT = "checkpoint.npz"
TRAJECTORY = "trajectory.zarr"
INTERVAL = 30.0
"""Seconds between checkpoints."""


def stream(
    scenario: Scenario,
    folder: str | Path,
    *,
    every: Mapping[str, int] | None = None,
    csv: bool = False,
    checkpoint_interval: float = INTERVAL,
    resume: bool = False,
    progress: Progress | None = None,
    **choices: Any,
) -> Result:
    """Run one variant of a scenario, and write its rows to disk as they come.

    Memory does not grow with the length of the run. The first Ctrl-C, or request to terminate, ends the run at the
    next opportunity with all its rows on disk and a checkpoint; a second one ends it at once.

    Parameters
    ----------
    scenario : Scenario
        From `cosim.load_scenario`, or made in Python.
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
        Go on with the unfinished run in the folder, with the same scenario and choices; `every` and `csv` are as they
        were. The results have the same bits as those of an uninterrupted run.
    progress : callable, optional
        Called now and then with the part of the run that is done, from 0 to 1.
    **choices
        Others of `cosim.run.options.Choices`, as of `cosim.simulate`.

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
    folder = Path(folder)
    if not resume:
        _refuse_run(folder)
    saved = read_checkpoint(folder / CHECKPOINT) if resume else None
    if saved is not None:
        every, csv = saved.notes["every"], saved.notes["csv"]
    if not csv:
        require_zarr()
    with assembled(scenario, Choices(**choices)) as assembly:
        streaming = _Streaming(scenario, assembly, folder, every or {}, csv=csv)
        _warn_of_stateless(assembly)
        with _opened(streaming, saved):
            _advance(streaming, checkpoint_interval, progress)
            return streaming.complete()


class _Streaming:
    """A run, and what is kept of it."""

    def __init__(
        self, scenario: Scenario, assembly: Assembly, folder: Path, every: Mapping[str, int], *, csv: bool
    ) -> None:
        self.master = assembly.master
        self.folder = folder
        self._assembly = assembly
        self._every, self._csv = dict(every), csv
        self._chosen = decimate(self.master.columns, every)
        self._identity = _identity(assembly)
        self._tail = Tail(_watched(self.master.columns, scenario.signals))
        self._title = scenario.title or scenario.name
        self._store: Store

    @property
    def can_resume(self) -> bool:
        """Whether all components can give their states."""
        return all(known.can_serialize_state for known in self._assembly.descriptions.values())

    def begin(self) -> None:
        """Initialise the components and begin to store."""
        self.master.begin()
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(f"output folder {self.folder} cannot be written: {error.strerror or error}") from error
        if self._csv:
            self._store = create_csv(self.folder, self._chosen)
        else:
            source = f"drillstring-cosim {self._assembly.provenance['versions']['drillstring-cosim']}"
            head = {"title": self._title, "source": source, "created": datetime.now(UTC).isoformat(timespec="seconds")}
            attributes = {**head, "state": "running", **self._assembly.provenance, **self.master.plan}
            self._store = create_zarr(self.folder / TRAJECTORY, self._chosen, plain(attributes))

    def go_on(self, saved: Checkpoint) -> None:
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
            "identity": self._identity, "every": self._every, "csv": self._csv,
            "position": dict(position), "snapshot": snapshot.notes,
        }  # fmt: skip
        write_checkpoint(self.folder / CHECKPOINT, Checkpoint(notes, {**snapshot.arrays, **self._tail.arrays()}))

    def close(self, state: str) -> dict[str, Any]:
        """Bring all rows to disk with what is to be told of the run so far, which is returned."""
        record = self._assembly.record(self.master.account())
        self._store.close(plain({"state": state, "reached": self.master.time, **record}))
        return record

    def complete(self) -> Result:
        """End the run, of which no checkpoint is needed any more."""
        self.master.end()
        record = self.close("complete")
        (self.folder / CHECKPOINT).unlink(missing_ok=True)
        return self._tail.result(record)


@contextmanager
def _opened(streaming: _Streaming, saved: Checkpoint | None) -> Generator[None]:
    """Begin or go on; should a component fail, leave what was stored before readable."""
    if saved is None:
        streaming.begin()
    else:
        streaming.go_on(saved)
    try:
        yield
    except CosimError as error:
        streaming.close(f"failed: {error}")
        raise


def _advance(streaming: _Streaming, interval: float, progress: Progress | None) -> None:
    """Take all steps, with a checkpoint now and then."""
    saved = time.monotonic()
    with _signals() as check:
        for rows in streaming.master.rows():
            streaming.take(rows)
            try:
                check()
                if progress is not None:
                    progress(streaming.master.done)
            except KeyboardInterrupt:
                _pause(streaming)
            if time.monotonic() - saved >= interval:
                streaming.save()
                saved = time.monotonic()


def _pause(streaming: _Streaming) -> None:
    """Leave a run that can be resumed."""
    streaming.save()
    streaming.close("interrupted")
    raise RunInterruptedError(streaming.folder, streaming.master.time, can_resume=streaming.can_resume)


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


def _watched(columns: tuple[Column, ...], signals: tuple[str, ...]) -> list[Column]:
    """Choose what the end of a run is kept of: what measures and figure need."""
    shown = signals or default_signals({column.name: column.dtype for column in columns})
    needed = {*metrics.NEEDED, *energy.NEEDED, *energy.LOSSES, energy.FOLDED}
    return [column for column in columns if column.name in shown or column.name.partition(".")[2] in needed]


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
