"""Run points of a sweep one after the other, in FMUs that stay loaded.

Each point begins with FMUs that know nothing of the one before: reset, or instantiated anew where an FMU is not of this
project, as many of others forget to reset something. Where runs are continued, the state after a point is given to FMUs
that have been initialised for the next one, in this process or another. So the numbers of a point do not depend on what
was run before it, nor where.
"""

from __future__ import annotations

import io
import json
import math
import tempfile
import threading
from collections.abc import Generator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cosim.errors import EndRequestError, RunError, SlaveError
from cosim.fmi2.fmu_slave import FmuSlave
from cosim.fmi2.isolation import Limits
from cosim.fmi2.library import loaded_fmu
from cosim.fmi2.surroundings import Surroundings
from cosim.master.co_simulation import Master
from cosim.master.run import Snapshot
from cosim.master.slave import Slave
from cosim.recording.record import TEXT
from cosim.run.assembly import modules_apart
from cosim.run.function import FunctionSlave, functions_of
from cosim.sweeps.measures import last_window
from cosim.sweeps.point_plan import PointPlan
from cosim.sweeps.reading import SERIES
from cosim.sweeps.series import Rows
from cosim.sweeps.workers.held_run import HeldRun
from cosim.system.compatibility import check_system
from cosim.system.description import Description
from cosim.system.signals import FloatArray, Value

_surroundings_held = threading.Lock()
"""Held while a library is loaded, which changes the working folder, and while it is seen to whether one has: by no two
threads at once, as executors with threads would have it."""
_OURS = "drillstring-cosim"
"""Exporter of FMUs that are as new after a reset, as tests hold."""


@dataclass(frozen=True)
class PointOutcome:
    """Hold the numbers of a point, or why there are none, and what else is asked for.

    Attributes
    ----------
    numbers : sequence of float
        NaN where there is a message.
    message : str
        Why there are none.
    state : Snapshot or None
        After it.
    series : (bytes, str) or None
        The rows of each signal that is kept over time, float64, or why there are none.
    """

    numbers: Sequence[float]
    message: str = ""
    state: Snapshot | None = None
    series: tuple[bytes, str] | None = None


class _Place:
    """Make instances of an FMU: from its library, loaded once, or from the instance of the last run."""

    def __init__(self, name: str, path: Path, description: Description, apart: bool) -> None:
        self._name, self._path, self._description = name, path, description
        self._apart = apart
        self._library: Any = None
        self._kept = ExitStack()
        self._instance: FmuSlave | None = None
        self._isolated = ExitStack()

    def renewed(self) -> Slave:
        """Return an instance that knows nothing of the run before."""
        if self._apart:
            from cosim.fmi2.isolation.isolated_slave import open_isolated_fmu

            self._isolated.close()
            opened = open_isolated_fmu(self._name, self._path, self._description, Limits())
            return self._isolated.enter_context(opened)
        last = self._instance
        if last is not None and last.is_sound and self._description.generation_tool.startswith(_OURS):
            last.reset()
            return last
        self._drop()
        if self._library is None:
            with _surroundings_held, Surroundings(self._name).kept("while it was loaded"):
                self._library = self._kept.enter_context(loaded_fmu(self._name, self._path, self._description))
        self._instance = FmuSlave(self._name, self._description, self._library)
        return self._instance

    def _drop(self) -> None:
        if self._instance is not None:
            self._instance.close()
            self._instance = None

    def close(self) -> None:
        """Free the instance, and unload the library."""
        self._drop()
        self._isolated.close()
        self._kept.close()


class Workbench:
    """A place where points of one sweep are run.

    Parameters
    ----------
    plan : PointPlan
        The sweep.

    Raises
    ------
    OSError
        If FMUs cannot be unpacked.
    """

    def __init__(self, plan: PointPlan) -> None:
        self._plan = plan
        self._stack = ExitStack()
        folder = Path(self._stack.enter_context(tempfile.TemporaryDirectory(prefix="cosim-sweep-")))
        self._paths: dict[str, Path] = {}
        for digest, file in plan.files.items():
            (folder / digest).mkdir()
            self._paths[digest] = folder / digest / file.name
            self._paths[digest].write_bytes(file.content)
        self._surroundings = Surroundings("an FMU of the sweep")
        self._places: dict[tuple[str, str], _Place] = {}
        self._held: dict[tuple[str, ...], HeldRun] = {}

    def run(
        self, values: Mapping[str, Value], step: int, state: Snapshot | None, *, keep: bool, series: bool = False
    ) -> PointOutcome:
        """Run a point.

        Parameters
        ----------
        values : mapping of str to value
            All that is set at it.
        step : int
            How many points the run has gone over before.
        state : Snapshot, optional
            After the point before; None where a run begins.
        keep : bool
            Whether the state after it is needed.
        series : bool
            Whether signals are kept over time.

        Raises
        ------
        InputError
            If no point can be run here.
        """
        chosen, rest = self._plan.split(values)
        try:
            if not self._plan.takes_long_steps:
                return self._run_coupled(chosen, rest, step, state, keep, series)
            outcome = self._run_long(chosen, rest, step, state, keep)
            return replace(outcome, series=self._series_of(chosen, rest, step, state)) if series else outcome
        except RunError as error:
            self._held.pop(tuple(chosen.values()), None)  # it holds an instance that is none any more
            return self.failed(str(error))
        except MemoryError:
            return self.failed("there is not enough memory")

    @contextmanager
    def turn(self) -> Generator[None]:
        """Give the context of some points, after which this process is as it was before."""
        kept = self._surroundings.kept("in points of a sweep")
        with _surroundings_held:
            kept.__enter__()
        try:
            yield
        finally:
            with _surroundings_held:
                kept.__exit__(None, None, None)

    def close(self) -> None:
        """Free and unload everything."""
        for place in self._places.values():
            place.close()
        self._stack.close()

    @property
    def names(self) -> tuple[str, ...]:
        """Return what varies, in the order in which values are given."""
        return self._plan.names

    def goes_on(self, step: int) -> bool:
        """Tell whether a run goes on after a point."""
        return step + 1 < self._plan.points_per_run

    def failed(self, message: str) -> PointOutcome:
        """Return the outcome of a point that has no numbers."""
        return PointOutcome([np.nan] * len(self._plan.measures.quantities), message)

    def _slaves(self, chosen: Mapping[str, str], known: Mapping[str, Description]) -> dict[str, Slave]:
        """Return an instance for each component that knows nothing of what was run before."""
        files = {name: self._plan.choices[name][fmu] for name, fmu in chosen.items()}
        keys = [(name, files[name]) for name in known if name in files]
        if any(key not in self._places for key in keys):
            paths = {name: self._paths[file] for name, file in files.items()}
            apart = modules_apart(paths, frozenset())
            for name, file in keys:
                place = _Place(name, self._paths[file], known[name], name in apart)
                self._places.setdefault((name, file), place)
        slaves: dict[str, Slave] = {key[0]: self._places[key].renewed() for key in keys}
        if self._plan.functions:
            repeats = self._plan.method.implicit or self._plan.method.tolerance is not None
            for name, callee in functions_of(self._plan.system).items():
                slaves[name] = FunctionSlave(name, callee, known[name], repeats=repeats)
        return {name: slaves[name] for name in known}

    def _run_long(
        self, chosen: Mapping[str, str], values: Mapping[str, Value], step: int, state: Snapshot | None, keep: bool
    ) -> PointOutcome:
        """Run a point of components that are not coupled, in one step up to the window that is measured."""
        plan = self._plan
        known = plan.descriptions(chosen)
        slaves = self._slaves(chosen, known)
        key = tuple(chosen.values())
        held = self._held.get(key)
        if held is None or not held.is_of(slaves):
            system = plan.system_of(chosen)
            starts = check_system(system.with_values(values), known)
            times, first = long_steps(
                plan.start_time, plan.duration, plan.measures.window, plan.measures.sampling or 1.0
            )
            held = self._held[key] = HeldRun(system, slaves, starts, times, first, plan.measures.columns)
        stop = plan.start_time + plan.duration * plan.points_per_run
        try:
            columns = held.run(values, step * plan.duration, stop, state)
        except EndRequestError as error:
            raise RunError(str(error)) from None
        numbers = plan.measures.of(held.window + step * plan.duration, columns)
        return PointOutcome(numbers, "", held.state() if keep else None)

    def _series_of(
        self, chosen: Mapping[str, str], values: Mapping[str, Value], step: int, state: Snapshot | None
    ) -> tuple[bytes, str]:
        """Run a point that takes one long step once more, in the steps that are kept."""
        plan = self._plan
        assert plan.series is not None
        known = plan.descriptions(chosen)
        key = (*chosen.values(), SERIES)
        try:
            slaves = self._slaves(chosen, known)
            held = self._held.get(key)
            if held is None or not held.is_of(slaves):
                system = plan.system_of(chosen)
                starts = check_system(system.with_values(values), known)
                times = replace(plan.series, first=0).times(plan.start_time, plan.start_time + plan.duration)
                rows = plan.series
                held = HeldRun(system, slaves, starts, times, rows.first, rows.signals, rows.every)
                self._held[key] = held
            stop = plan.start_time + plan.duration * plan.points_per_run
            columns = held.run(values, step * plan.duration, stop, state)
        except (RunError, EndRequestError, MemoryError) as error:
            self._held.pop(key, None)
            return b"", "there is not enough memory" if isinstance(error, MemoryError) else str(error)
        return np.stack([columns[name] for name in plan.series.signals]).tobytes(), ""

    def _run_coupled(
        self,
        chosen: Mapping[str, str],
        values: Mapping[str, Value],
        step: int,
        state: Snapshot | None,
        keep: bool,
        series: bool,
    ) -> PointOutcome:
        """Run a point as any run, in the compiled loop if it can be; only its window is kept, or its series."""
        plan = self._plan
        known = plan.descriptions(chosen)
        stop = plan.start_time + plan.duration * (step + 1)
        master = Master(
            plan.system_of(chosen).with_values(values),
            self._slaves(chosen, known),
            stop_time=stop,
            step_size=plan.step_size,
            start_time=plan.start_time,
            method=plan.method,
        )
        master.begin()
        if state is not None:
            master.resume(state)
        rows = _Window(plan.measures.columns, stop - plan.measures.window)
        whole = _Window(plan.series.signals, -math.inf) if plan.series is not None and series else None
        for each in master.rows():
            rows.take(each)
            if whole is not None:
                whole.take(each)
        account = master.account()
        if "ended" in account:
            ended = account["ended"]
            raise RunError(str(SlaveError(ended["component"], ended["time"], "fmi2DoStep", "the end", ended["reason"])))
        time, columns = rows.values()
        part = last_window(time, plan.measures.window)
        numbers = plan.measures.of(time[part], {name: column[part] for name, column in columns.items()})
        kept = (
            None
            if whole is None or plan.series is None
            else _picked(plan.series, *whole.values(), stop - plan.duration)
        )
        return PointOutcome(numbers, "", _storable(master.snapshot()) if keep else None, kept)


def _picked(series: Rows, times: FloatArray, columns: Mapping[str, FloatArray], begin: float) -> tuple[bytes, str]:
    """Return the rows that are kept of a run, or why there are none."""
    found = series.picked(times - begin, columns)
    return (b"", found) if isinstance(found, str) else (found.tobytes(), "")


def long_steps(start: float, duration: float, window: float, sampling: float) -> tuple[FloatArray, int]:
    """Lay out the communication points of a run that takes one step up to its window, s; with the first in the window.

    Times are in s. Steps within the window are as long as `sampling`, but for rounding to a whole number of them.
    """
    count = max(1, round(window / sampling)) if window else 0
    inside: FloatArray = start + duration - window + np.arange(count + 1, dtype=np.float64) * (window / max(1, count))
    inside[-1] = start + duration
    return (inside, 0) if inside[0] <= start else (np.concatenate([np.array([start]), inside]), 1)


class _Window:
    """The rows of a run from a time on, of some columns; what is before is dropped as it comes."""

    def __init__(self, columns: Sequence[str], since: float) -> None:
        self._columns, self._since = columns, since * (1.0 - 1e-9)
        self._times: list[FloatArray] = []
        self._parts: list[dict[str, FloatArray]] = []

    def take(self, rows: Any) -> None:
        """Take rows as they come; they are copied."""
        first = int(np.searchsorted(rows.times, self._since))
        first = min(first, rows.times.size - 1)  # the last row is kept in any case
        if self._times and self._times[-1][0] < self._since:
            self._times.clear()
            self._parts.clear()
        self._times.append(rows.times[first:].copy())
        self._parts.append({name: rows.columns[name][first:].astype(np.float64) for name in self._columns})

    def values(self) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Return times [s] and columns."""
        joined = {name: np.concatenate([part[name] for part in self._parts]) for name in self._columns}
        return np.concatenate(self._times), joined


def _storable(state: Snapshot) -> Snapshot:
    """Return a snapshot whose texts are arrays of text, as they are read back, and not of objects."""
    arrays = {name: a.astype(np.str_) if a.dtype == TEXT else a for name, a in state.arrays.items()}
    return Snapshot(state.notes, arrays)


def packed(state: Snapshot) -> bytes:
    """Write a state as bytes."""
    file = io.BytesIO()
    held: dict[str, Any] = {f"array {name}": values for name, values in state.arrays.items()}
    held["notes"] = np.frombuffer(json.dumps(state.notes).encode(), np.uint8)
    np.savez_compressed(file, **held)
    return file.getvalue()


def unpacked(content: bytes) -> Snapshot:
    """Read a state; ValueError or OSError if it is none."""
    with np.load(io.BytesIO(content), allow_pickle=False) as held:
        arrays = {name.removeprefix("array "): held[name] for name in held.files if name != "notes"}
        return Snapshot(json.loads(held["notes"].tobytes()), arrays)
