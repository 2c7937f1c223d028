"""Hand out the points of a sweep in batches, as long as a worker is busy for about half a second, and take what comes.

Whoever dies at its work costs its batch only. What was under way then is tried again point by point, each with nothing
else under way, until the one is found that kills its worker twice. That point fails, and the rest goes on.
"""

from __future__ import annotations

import hashlib
import math
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import replace

from cosim.errors import RunError
from cosim.files import why
from cosim.sweeps.plan import Sweep
from cosim.sweeps.workers.crew import Crew
from cosim.sweeps.workers.work import BatchReply, Done, Stretch, run_batch

TARGET = 0.5
"""How long a batch should take, s: long against what it costs to hand it out, and short against patience."""
_MOST_POINTS = 1000
"""Of a batch, however short they are: more would be held in memory at once, and save no time."""
_PATIENCE = 4.0
"""As many times as long a line is gone on with before it is left to another batch."""
_FALL = 8.0
_AHEAD = 2
"""Batches for each worker, so that none waits."""
_LOOK = 0.2
_MOST_STARTS = 3
"""Of workers that die before they are ready for a point."""
_LAST_CHANCE = 2

Batch = tuple[Stretch, ...]


class Dispatcher:
    """Run what is left of a sweep.

    Parameters
    ----------
    sweep : Sweep
        What to run.
    plan : bytes
        Its plan, pickled.
    crew : Crew
        Who does it.
    left : iterator of Stretch
        Where to begin on each line; values are filled in when they are handed out.
    points : int
        How many points that is.
    """

    def __init__(self, sweep: Sweep, plan: bytes, crew: Crew, left: Iterator[Stretch], points: int) -> None:
        self._sweep, self._plan, self._crew, self._left = sweep, plan, crew, left
        self._name = hashlib.sha256(plan).hexdigest()
        self._points = points
        self._again: deque[Stretch] = deque()
        self._suspects: deque[tuple[Stretch, int]] = deque()
        self._accused: tuple[Stretch, int] | None = None
        self._flying: dict[Future[BatchReply], Batch] = {}
        self._cost: float | None = None
        self._sent = self._stillborn = 0

    def run(self, take: Callable[[list[Done]], None], look: Callable[[], None]) -> None:
        """Run everything.

        Parameters
        ----------
        take : callable
            Takes what is done as it comes.
        look : callable
            Called several times a second; what it raises ends the sweep.

        Raises
        ------
        RunError
            If no worker lives long enough to run a point.
        """
        while True:
            self._hand_out()
            if not self._flying:
                return
            ready, _ = wait(self._flying, timeout=_LOOK, return_when=FIRST_COMPLETED)
            lost = [error for future in ready if (error := self._receive(future, take)) is not None]
            if lost:
                self._replace_workers(lost[0], take)
            look()

    def _hand_out(self) -> None:
        """Keep workers busy; a suspect is run alone, so that it is known who has killed a worker."""
        if self._suspects:
            if not self._flying:
                self._accused = self._suspects.popleft()
                self._submit((self._accused[0],), 0.0)
            return
        while len(self._flying) < _AHEAD * self._crew.workers and not self._suspects:
            batch = self._batch()
            if not batch:
                return
            self._submit(batch, _PATIENCE * TARGET)

    def _batch(self) -> Batch:
        """Take as many lines as fill the time of a batch, and no more than leave work for the others."""
        fair = self._points / (2.0 * self._crew.workers)
        wanted = 1.0 if self._cost is None else max(1.0, min(TARGET / self._cost, fair, _MOST_POINTS))
        batch: list[Stretch] = []
        points = 0
        while points < wanted:
            stretch = self._again.popleft() if self._again else next(self._left, None)
            if stretch is None:
                break
            if batch and points + self._sweep.design.length - stretch.first > wanted:
                self._again.appendleft(stretch)
                break
            batch.append(self._filled(stretch))
            points += len(batch[-1].values)
        return tuple(batch)

    def _filled(self, stretch: Stretch) -> Stretch:
        """Return a stretch up to the end of its line, with what is set there."""
        if stretch.values:
            return stretch
        steps = range(stretch.first, self._sweep.design.length)
        values = [tuple(self._sweep.design.values(stretch.line, step).values()) for step in steps]
        begins, kept = self._sweep.first_values(stretch.line), self._sweep.kept_steps(stretch.line)
        return replace(stretch, values=values, begins=begins, kept=kept)

    def _submit(self, batch: Batch, budget: float, *, with_plan: bool = False) -> None:
        """Hand a batch out; the first ones with the plan."""
        plan = self._plan if with_plan or self._sent < self._crew.workers else None
        self._sent += 1
        try:
            future = self._crew.executor.submit(run_batch, self._name, plan, batch, budget)
        except self._crew.lost as error:
            future = Future[BatchReply]()
            future.set_exception(error)
        self._flying[future] = batch

    def _receive(self, future: Future[BatchReply], take: Callable[[list[Done]], None]) -> BaseException | None:
        """Take the reply to a batch; or return why its worker is gone."""
        try:
            reply = future.result()
        except (MemoryError, *self._crew.lost) as error:
            return error
        except TypeError as error:
            if not self._crew.is_torn(error):
                raise
            return error
        except (OSError, ImportError) as error:
            raise RunError(f"{self._crew.where} cannot work: {why(error)}") from error
        batch = self._flying.pop(future)
        if reply.done is None:
            self._submit(batch, 0.0 if self._accused else _PATIENCE * TARGET, with_plan=True)
            return None
        self._account(reply)
        take(reply.done)
        for done, stretch in zip(reply.done, batch, strict=True):
            count = len(done.numbers)
            if count == len(stretch.values):
                continue
            rest = replace(stretch, first=stretch.first + count, values=stretch.values[count:], state=done.state)
            if self._accused is not None:
                self._suspects.appendleft((rest, 0))
            else:
                self._again.append(rest)
        self._accused = None
        return None

    def _account(self, reply: BatchReply) -> None:
        """Learn what a point costs; the estimate falls slowly, as the first points may be cheap ones."""
        count = sum(len(done.numbers) for done in reply.done or ())
        self._points -= count
        cost = max(reply.seconds, 1e-6) / max(1, count)
        self._cost = cost if self._cost is None else max(0.5 * (self._cost + cost), self._cost / _FALL)

    def _replace_workers(self, error: BaseException, take: Callable[[list[Done]], None]) -> None:
        """Get others in place of workers that are gone; suspect what was under way, or convict who was alone."""
        message = " ".join(str(error).split()).removesuffix(".") or type(error).__name__
        came_up = self._crew.came_up()
        self._stillborn = 0 if came_up else self._stillborn + 1
        if self._stillborn >= _MOST_STARTS:
            raise RunError(f"{self._crew.where} cannot start: {message}{self._crew.advice}")
        if self._accused is not None:
            stretch, deaths = self._accused
            self._flying.clear()
            if deaths + came_up < _LAST_CHANCE:
                self._suspects.appendleft((stretch, deaths + came_up))
            else:
                self._convict(stretch, message, take)
            self._accused = None
        else:
            dead = [f for f in self._flying if self._crew.renew is not None or (f.done() and f.exception() is not None)]
            for future in dead:
                self._suspects.extend((stretch, 0) for stretch in self._flying.pop(future))
        if self._crew.renew is not None:
            self._crew.executor = self._crew.renew()
            self._sent = 0
        elif isinstance(error, MemoryError):
            return
        elif not self._crew.outlives:
            raise RunError(f"{self._crew.where} is broken: {message}") from error

    def _convict(self, stretch: Stretch, message: str, take: Callable[[list[Done]], None]) -> None:
        """Let a point fail, and with it what is continued from it."""
        count, steps = len(self._sweep.quantities), len(stretch.values)
        told = {0: f"{self._crew.where} died of it: {message}"}
        told |= dict.fromkeys(range(1, steps), "the run could not be continued from the point before")
        self._points -= steps
        take([Done(stretch.line, stretch.first, [[math.nan] * count for _ in range(steps)], told)])
