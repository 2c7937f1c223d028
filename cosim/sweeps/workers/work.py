"""Do a batch of a sweep's work: called in the workers, which keep what they need for the next one.

A worker is asked by the name of a plan, which it may not know yet: then it says so, and is sent the plan, with the FMUs
in it. So nothing is sent twice without need, any executor will do, and no disk is shared.
"""

from __future__ import annotations

import atexit
import logging
import pickle
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from cosim.sweeps.point_plan import PointPlan
from cosim.sweeps.workers.workbench import Workbench, packed, unpacked
from cosim.system.signals import Value


@dataclass(frozen=True)
class Stretch:
    """Points of a line that are run one after the other.

    Attributes
    ----------
    line : int
        Which line.
    first : int
        The first point of it to be run.
    values : sequence of tuple of value
        What is set at the points from there on, in the order of the plan.
    begins : mapping of str to value
        What else is set at the first point of the line.
    state : bytes or None
        After the point before `first`, if there is one.
    kept : tuple of int
        Which points of the line have signals that are kept over time.
    """

    line: int
    first: int
    values: Sequence[tuple[Value, ...]]
    begins: Mapping[str, Value] = field(default_factory=dict[str, Value])
    state: bytes | None = None
    kept: tuple[int, ...] = ()


@dataclass(frozen=True)
class Done:
    """Hold what has come of a stretch, as far as it got.

    Attributes
    ----------
    line, first : int
        Where it began.
    numbers : list of sequence of float
        Of each point.
    messages : dict of int to str
        By place in `numbers`: why there are none.
    state : bytes or None
        After the last point, if the line goes on.
    series : dict of int to (bytes, str)
        By place in `numbers`, of points that are kept: the rows of each signal, float64, or why there are none.
    """

    line: int
    first: int
    numbers: list[Sequence[float]]
    messages: dict[int, str]
    state: bytes | None = None
    series: dict[int, tuple[bytes, str]] = field(default_factory=dict[int, tuple[bytes, str]])


@dataclass(frozen=True)
class BatchReply:
    """Hold what has come of a batch, None if the worker does not know the plan, and how long it took, s."""

    done: list[Done] | None
    seconds: float = 0.0


_own = threading.local()


def run_batch(name: str, plan: bytes | None, stretches: Sequence[Stretch], budget: float) -> BatchReply:
    """Run stretches.

    Parameters
    ----------
    name : str
        Of the plan.
    plan : bytes, optional
        The plan itself, pickled.
    stretches : sequence of Stretch
        What to run.
    budget : float
        Seconds, after which no other point of a line is begun; the rest is left to another batch.
    """
    bench = _bench(name, plan)
    if bench is None:
        return BatchReply(None)
    began = time.perf_counter()
    with _silence, bench.turn():
        done = [_run(bench, stretch, began + budget) for stretch in stretches]
    return BatchReply(done, time.perf_counter() - began)


def _bench(name: str, content: bytes | None) -> Workbench | None:
    """Return the workbench of a plan in this thread; the one of another plan is cleared away."""
    if getattr(_own, "name", None) == name:
        return _own.bench
    if content is None:
        return None
    leave()
    try:
        plan: PointPlan = pickle.loads(content)  # from whoever may run anything here, as any job of an executor is
    except AttributeError as error:  # of a module that is another one here, as that of a notebook is
        raise ImportError(f"{error}; expected functions in a module that workers can import") from error
    _own.bench, _own.name = Workbench(plan), name
    atexit.register(_own.bench.close)
    return _own.bench


def leave() -> None:
    """Clear away what this thread has kept."""
    if getattr(_own, "name", None) is not None:
        atexit.unregister(_own.bench.close)
        _own.bench.close()
        _own.name = _own.bench = None


def _run(bench: Workbench, stretch: Stretch, until: float) -> Done:
    """Run the points of a stretch, until a time of the clock if they are more than one."""
    names = bench.names
    state = None if stretch.state is None else unpacked(stretch.state)
    numbers: list[Sequence[float]] = []
    messages: dict[int, str] = {}
    series: dict[int, tuple[bytes, str]] = {}
    for place, given in enumerate(stretch.values):
        step = stretch.first + place
        values: Mapping[str, Value] = dict(zip(names, given, strict=True))
        if step and state is None:
            outcome = bench.failed("the run could not be continued from the point before")
        else:
            kept = step in stretch.kept
            outcome = bench.run({**values, **stretch.begins}, step, state, keep=bench.goes_on(step), series=kept)
            if outcome.series is not None:
                series[place] = outcome.series
        state = outcome.state
        numbers.append(outcome.numbers)
        if outcome.message:
            messages[place] = outcome.message
        if time.perf_counter() > until and place + 1 < len(stretch.values) and state is not None:
            return Done(stretch.line, stretch.first, numbers, messages, packed(state), series)
    return Done(stretch.line, stretch.first, numbers, messages, None, series)


class _Silence:
    """Let runs not warn, each by itself; what ends one is the message of its point.

    Several threads may ask for it at once: the last one lets the process warn again.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._askers = self._before = 0

    def __enter__(self) -> None:
        with self._lock:
            if not self._askers:
                self._before = logging.root.manager.disable
                logging.disable(logging.WARNING)
            self._askers += 1

    def __exit__(self, *raised: object) -> None:
        with self._lock:
            self._askers -= 1
            if not self._askers:
                logging.disable(self._before)


_silence = _Silence()
