"""Runs of any length: rows go to disk as they come, and checkpoints let an interrupted run go on.

The end of a run in memory: its last minute of a few columns, from which a long run is measured and drawn.

Streamed trajectories, read back.
"""

from __future__ import annotations

import json
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from cosim.drilling import energy
from cosim.drilling import oscillation as metrics
from cosim.drilling.figure import default_signals
from cosim.errors import CheckpointError, CosimError, InputError, OutputError, RunInterruptedError, require
from cosim.master.run import Progress, Snapshot
from cosim.recording.result import Column, Result, RowMemory, Rows
from cosim.run.assembly import Assembly, assembled
from cosim.run.checkpoint import Checkpoint, read_checkpoint, write_checkpoint
from cosim.run.interrupt import interruptible
from cosim.run.options import Choices
from cosim.run.run_folder import plain
from cosim.run.store import Store, create_csv, csv_file, decimate, reopen_csv
from cosim.run.zarr_store import create_zarr, reopen_zarr, require_zarr
from cosim.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray


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


SECONDS = 60.0
"""How much is kept at least, s; measures look at the last 20 s, or at a period if that is longer."""
_TIMES = "time"


class Tail:
    """Takes rows, and forgets those that are older than a minute.

    Parameters
    ----------
    columns : sequence of Column
        What to keep of them.
    """

    def __init__(self, columns: Sequence[Column]) -> None:
        self._columns = tuple(columns)
        self._parts: deque[Rows] = deque()

    def take(self, rows: Rows) -> None:
        """Keep some more rows."""
        kept = {column.name: rows.columns[column.name].copy() for column in self._columns}
        self._parts.append(Rows(rows.first, rows.times.copy(), kept))
        oldest = rows.times[-1] - SECONDS
        while len(self._parts) > 1 and self._parts[1].times[0] <= oldest:
            self._parts.popleft()

    def result(self, record: Mapping[str, Any]) -> Result:
        """Return what is kept, with what is to be told of the run."""
        memory = RowMemory(self._columns, sum(part.times.size for part in self._parts))
        for part in self._parts:
            memory.take(part)
        return memory.result(record)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return what is kept by name, for a checkpoint."""
        whole = self.result({})
        return {_name(_TIMES): whole.time, **{_name(name): values for name, values in whole.columns.items()}}

    def restore(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Keep what another kept."""
        times = np.asarray(arrays[_name(_TIMES)], dtype=np.float64)
        values = {column.name: arrays[_name(column.name)] for column in self._columns}
        self._parts = deque([Rows(0, times, values)])


def _name(column: str) -> str:
    """Return the name of a column in a checkpoint."""
    return f"tail {column}"


def open_trajectory(folder: str | Path) -> xarray.Dataset:
    """Open what a streamed run has written, while it goes on, or when it is over.

    Parameters
    ----------
    folder : str or Path
        Of the run, or of one of its variants.

    Returns
    -------
    xarray.Dataset
        A variable for each column, by ``component.variable``, with its unit, over ``time``, or ``time_10`` where every
        tenth row is stored [s]. Values are read when they are asked for. Attributes tell how the run was made, JSON
        where they are not plain numbers or text.

    Raises
    ------
    InputError
        If there is no such trajectory, it cannot be read, or a package is missing that reads it.
    """
    path = Path(folder)
    path = path if path.suffix == ".zarr" else path / TRAJECTORY
    if not path.is_dir():
        raise InputError(f"{path}: there is no such trajectory")
    # Both take a while to import.
    reader, zarr = (require(name, extra="stream", purpose="reading Zarr") for name in ("xarray", "zarr"))
    try:
        group = zarr.open_group(path, mode="r", use_consolidated=False)
        lengths: dict[str, set[int]] = {}
        for array in group.array_values():
            lengths.setdefault(_axis(array), set()).add(array.shape[0])
        if all(len(found) == 1 for found in lengths.values()):
            return reader.open_zarr(path, consolidated=False)
        names = list(group.array_keys())
        parts = [reader.open_zarr(path, consolidated=False, drop_variables=set(names) - {name}) for name in names]
        shortest = {axis: slice(0, min(found)) for axis, found in lengths.items()}
        return reader.merge([part.isel({axis: shortest[axis] for axis in part.dims}) for part in parts])
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} cannot be read: {error}") from error


def _axis(array: Any) -> str:
    """Return the name of an array's axis."""
    return str(array.attrs["_ARRAY_DIMENSIONS"][0])
