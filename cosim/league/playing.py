"""Play a league: every law under every condition, on all processors, with the same numbers whatever their number."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass

from cosim.errors import RunError
from cosim.league.entries import Condition, Law, League, Search
from cosim.league.rig import Rig
from cosim.league.score import Score, judge
from cosim.processes import end_pool, processors, without_main, worker_pool
from cosim.run.options import RunOptions
from cosim.run.simulation import run

Progress = Callable[[str, float], None]
"""Takes what has just been played, and which part of all is done, from 0 to 1."""


@dataclass(frozen=True)
class Limit:
    """Tell the end of a search.

    Attributes
    ----------
    value : float or None
        The last value it frees the string at; None if it fails at the easiest.
    beyond : bool
        It does so at all values that were tried.
    """

    value: float | None
    beyond: bool


@dataclass(frozen=True)
class Standings:
    """Hold what has come of a league.

    Attributes
    ----------
    league : League
        What was played.
    scores : mapping of (str, str) to Score
        By names of law and condition.
    limits : mapping of (str, str) to Limit
        By names of law and search.
    """

    league: League
    scores: Mapping[tuple[str, str], Score]
    limits: Mapping[tuple[str, str], Limit]

    def ranked(self) -> tuple[Law, ...]:
        """Return the laws: first those that free the string under most conditions, then those that do so sooner.

        Laws without a switch come after the others, since they had no stick-slip to end.
        No law is ranked by how fast the bit turns: one that makes up for the slip of the drive drills with another
        speed at the top.
        """
        return tuple(sorted(self.league.laws, key=self._rank))

    def _rank(self, law: Law) -> tuple[bool, int, float]:
        scores = [self.scores[law.name, each.name] for each in self.league.conditions]
        freed = [score.time_to_free for score in scores if score.free]
        return not scores[0].switched, -len(freed), sum(freed) / len(freed) if freed else 0.0


def play(league: League, workers: int = 0, progress: Progress | None = None) -> Standings:
    """Play a league.

    Parameters
    ----------
    league : League
        The laws and conditions.
    workers : int
        Processes to use; 0: one for each processor there is; 1: this process alone.
    progress : callable, optional
        Called when something has been played.

    Raises
    ------
    InputError
        If a law cannot be connected, or something in the file does not exist. A run that fails is a score that says so.
    """
    games = [Game(league, law, each) for law in league.laws for each in (*league.conditions, *league.searches)]
    for law in league.laws:  # what is wrong with a law is told before anything is played
        Rig(league, law, league.conditions[0])
    scores: dict[tuple[str, str], Score] = {}
    limits: dict[tuple[str, str], Limit] = {}
    with players(min(workers or processors(), len(games))) as played:
        for number, (game, found) in enumerate(played(games), start=1):
            if isinstance(found, Score):
                scores[game.key] = found
            else:
                limits[game.key] = found
            if progress is not None:
                progress(", ".join(game.key), number / len(games))
    order = [game.key for game in games]
    return Standings(
        league,
        {key: scores[key] for key in order if key in scores},
        {key: limits[key] for key in order if key in limits},
    )


@dataclass(frozen=True)
class Game:
    """One thing to be played.

    Attributes
    ----------
    league : League
        How long to run, and in which steps.
    law : Law
        The law.
    what : Condition or Search
        What it is judged under, or how far it goes.
    """

    league: League
    law: Law
    what: Condition | Search

    @property
    def key(self) -> tuple[str, str]:
        """Names of law and condition, or search."""
        return self.law.name, self.what.name


Played = Callable[[Sequence[Game]], Iterator[tuple[Game, Score | Limit]]]
"""Plays games as processes are free, and gives what has come of each."""


@contextmanager
def players(workers: int) -> Generator[Played]:
    """Hold processes that play games, as many as there are workers; with one, this process plays by itself.

    What waits for them is dropped if this process is interrupted. They leave signals from the keyboard to it.
    """
    if workers <= 1:
        yield lambda games: ((game, _play(game)) for game in games)
        return
    pool = worker_pool(workers)

    def played(games: Sequence[Game]) -> Iterator[tuple[Game, Score | Limit]]:
        with without_main():  # games are plain data
            waiting = {pool.submit(_play, game): game for game in games}
        try:
            for done in as_completed(waiting):
                yield waiting[done], done.result()
        except BrokenProcessPool:
            raise RunError("a process that played for the league has ended before its time, or was killed") from None

    try:
        yield played
    finally:
        end_pool(pool)


def _play(game: Game) -> Score | Limit:
    """Judge a law under a condition, or search for its limit."""
    league, law, what = game.league, game.law, game.what
    return score(league, law, what) if isinstance(what, Condition) else _limit(league, law, what)


def score(league: League, law: Law, condition: Condition) -> Score:
    """Judge a law under a condition; a run that fails is a score that says why."""
    rig = Rig(league, law, condition)
    try:
        with _unheard():
            result = run(rig.scenario, RunOptions())
    except RunError as error:
        return Score(failure=str(error))
    return judge(result, rig.engaged, rig.loaded, switched=rig.switched)


@contextmanager
def _unheard() -> Generator[None]:
    """Let hundreds of runs not warn, of breaks that are folded say, each by itself."""
    before = logging.root.manager.disable
    logging.disable(logging.WARNING)
    try:
        yield
    finally:
        logging.disable(before)


def _limit(league: League, law: Law, search: Search) -> Limit:
    """Go from value to value as long as the string is freed."""
    last: float | None = None
    for value in search.values:
        if not score(league, law, search.at(value)).free:
            return Limit(last, beyond=False)
        last = value
    return Limit(last, beyond=True)
