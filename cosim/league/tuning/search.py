"""Search for the gains of a law: by differential evolution, over coupled runs, within the margins of the linear model.

A run depends on gains and condition alone, and which gains are tried on the runs before. So the result is the same
whatever the number of processes, and a tuning that is begun again with what had been played goes the same way.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cosim.errors import InputError, RunError, ScenarioError, TuningInterruptedError, require, suggestion
from cosim.files import digest_of
from cosim.fmi2.locate import locate_fmu, promised_fmus
from cosim.fmi2.model_description import read_description
from cosim.league.entries import USUAL, Condition, Law, League, load_league
from cosim.league.playing import Game, Played, Progress, players
from cosim.league.rig import DRIVE, PLANT, PROGRAM
from cosim.league.score import Score
from cosim.league.tuning.gains import Gain, free_gains
from cosim.league.tuning.journal import EvaluationLog, Key, key_of, opened_journal
from cosim.league.tuning.linear import LinearModel, Margin, by_formula, settings
from cosim.league.tuning.severity import overall
from cosim.processes import processors
from cosim.provenance import versions
from cosim.system.signals import FloatArray, Value

BUDGET, REFLECTION, DAMPING = 150, 1.0, 0.0
FEWEST = 10
"""Candidates without which there is no search."""
_SMALLEST = 5
_NOTHING: dict[str, float] = {}
Players = Callable[[int], AbstractContextManager[Played]]
"""Holds who plays, as many as there are workers."""


@dataclass(frozen=True)
class Tuning:
    """State what is tuned, and how: see `prepare`.

    Attributes
    ----------
    league : League
        With the law and the conditions alone.
    model : str
        Name of the law's FMU.
    gains : tuple of Gain
        The parameters that are free.
    fixed : mapping of str to value
        Other parameters with which gains act, beside the law's own.
    linear : tuple of LinearModel
        By condition; none if the linear model does not know the law.
    seed, budget : int
        Of the search, and how many candidates it looks at.
    reflection, damping : float
        What the margin of a candidate must keep to: at most, and at least [1/s].
    """

    league: League
    model: str
    gains: tuple[Gain, ...]
    fixed: Mapping[str, Value]
    linear: tuple[LinearModel, ...]
    seed: int
    budget: int
    reflection: float
    damping: float

    @property
    def law(self) -> Law:
        """The law as it is."""
        return self.league.laws[0]

    def candidate(self, values: Mapping[str, float]) -> Law:
        """Return the law with other gains; without any, as it is."""
        if not values:
            return self.law
        return replace(self.law, parameters={**self.law.parameters, **self.fixed, **values})

    def margin(self, values: Mapping[str, float]) -> Margin | None:
        """Return the worst margin over all conditions; None if none is known."""
        if not self.linear:
            return None
        given = {**self.fixed, **values} if values else {}
        each = [model.margin(given) for model in self.linear]
        damping = [margin.damping for margin in each if not math.isnan(margin.damping)]
        return Margin(max(margin.reflection for margin in each), min(damping, default=math.nan))

    def short_of(self, margin: Margin | None) -> float:
        """Return by how much a margin is not kept; 0 if it is."""
        if margin is None:
            return 0.0
        slow = 0.0 if math.isnan(margin.damping) else min(1e6, max(0.0, self.damping - margin.damping))
        return max(0.0, margin.reflection - self.reflection) + slow

    def identity(self) -> dict[str, Any]:
        """Return all that decides which candidates are tried, and what comes of each."""
        league, law = self.league, self.law
        optimize = require("scipy", extra="theory", purpose="tuning")
        names = {"law": law.fmu, "plant": PLANT, "drive": DRIVE, "program": PROGRAM}
        made = versions()
        return {
            "law": {"name": law.name, "parameters": dict(law.parameters), "drive": dict(law.drive), **self.fixed},
            "gains": [asdict(gain) for gain in self.gains],
            "conditions": [asdict(each) for each in league.conditions],
            "times": [league.settle, league.judge, league.step_size],
            "seed": self.seed,
            "reflection": self.reflection,
            "damping": self.damping,
            "FMUs": {name: _digest(locate_fmu(fmu, "native", league.folder)) for name, fmu in names.items()},
            "drillstring-cosim": made["drillstring-cosim"],
            "numpy": made["numpy"],
            "scipy": optimize.__version__,
        }


@dataclass(frozen=True)
class Candidate:
    """A candidate, and what came of it.

    Attributes
    ----------
    values : mapping of str to float
        The gains; none of the law as it is.
    margin : Margin or None
        The worst over all conditions; None if none is known.
    kept : bool
        The margin is kept.
    scores : tuple of Score
        By condition; none if it was not run.
    severity : float
        Overall; infinite if it was not run.
    """

    values: Mapping[str, float]
    margin: Margin | None
    kept: bool
    scores: tuple[Score, ...] = ()
    severity: float = math.inf


@dataclass(frozen=True)
class Tuned:
    """Hold what has come of a tuning.

    Attributes
    ----------
    tuning : Tuning
        What was asked for.
    before, after : Candidate
        The law as it is, and the best of what keeps the margin: the law as it is if nothing is better.
    trials : tuple of Candidate
        All candidates, in the order in which they were tried.
    """

    tuning: Tuning
    before: Candidate
    after: Candidate
    trials: tuple[Candidate, ...]

    @property
    def values(self) -> dict[str, Value]:
        """The parameters of the tuned law, those that are not free too."""
        start = {gain.name: gain.start for gain in self.tuning.gains}
        return {**self.tuning.law.parameters, **self.tuning.fixed, **(self.after.values or start)}


def prepare(
    law: str,
    file: Path | None = None,
    *,
    conditions: Sequence[str] = (),
    gains: Sequence[str] = (),
    seed: int = 1,
    budget: int = BUDGET,
    reflection: float = REFLECTION,
    damping: float = DAMPING,
) -> Tuning:
    """Say what is to be tuned.

    Parameters
    ----------
    law : str
        A law of the league; or an FMU, by its name or file, with its start values.
    file : Path, optional
        The league, a TOML file; by default the one that comes with the package.
    conditions : sequence of str
        Of the league; by default those with the string of the first one that are not hard.
    gains : sequence of str
        What is free, each ``name=low:high`` or ``name``; by default what the league says.
    seed : int
        Of the search; the same seed gives the same result.
    budget : int
        Candidates that are looked at.
    reflection, damping : float
        A candidate is not run if the linear model says that more than this part of a wave comes back from the top, or
        that small motions about uniform rotation die away more slowly [1/s], under one of the conditions.

    Raises
    ------
    InputError
        If there is no such law, condition or gain, or a number is not fit for what it is.
    """
    if budget < FEWEST:
        raise InputError(f"--budget is {budget}; expected at least {FEWEST} candidates")
    if seed < 0:
        raise InputError(f"--seed is {seed}; expected a whole number >= 0")
    for name, number in (("reflection", reflection), ("damping", damping)):
        if not math.isfinite(number):
            raise InputError(f"--{name} is {number}; expected a finite number")
    league = _with_law(load_league(file or USUAL), law)
    league = replace(league.only([], list(conditions) or _usual(league)), laws=league.laws, searches=())
    described = read_description(locate_fmu(league.laws[0].fmu, "native", league.folder))
    first = settings(league, league.laws[0], league.conditions[0]).law
    fixed = by_formula(described.model_name, first)
    free = free_gains(league, league.laws[0], described, {**first, **fixed}, gains)
    if not any(gain.name in fixed for gain in free):
        fixed = {}  # the formula goes on to act
    models = [
        LinearModel(described.model_name, settings(league, league.laws[0], each), each) for each in league.conditions
    ]
    linear = tuple(models) if all(model.known for model in models) else ()
    return Tuning(league, described.model_name, free, fixed, linear, seed, budget, reflection, damping)


def tune(
    tuning: Tuning, folder: Path, workers: int = 0, progress: Progress | None = None, play: Players = players
) -> Tuned:
    """Tune a law; the same call goes on with a tuning that was interrupted.

    Parameters
    ----------
    tuning : Tuning
        From `prepare`.
    folder : Path
        Where runs are kept as they end; made if it is not there.
    workers : int
        Processes to use; 0: one for each processor there is; 1: this process alone.
    progress : callable, optional
        Called when something has been played; what it raises interrupts the tuning.
    play : callable, optional
        Who plays, by default the FMUs.

    Raises
    ------
    InputError
        If the folder holds another tuning, or something in the league does not exist.
    RunError
        If no candidate keeps the margin.
    TuningInterruptedError
        If it was interrupted; what was played is kept.
    """
    with opened_journal(folder, tuning.identity()) as journal, _told(journal, folder):
        with play(workers or processors()) as played:
            search = _Search(tuning, journal, played, progress)
            before = search.trial(_NOTHING)
            _evolve(tuning, search)
        trials = tuple(search.trials.values())
    best = min((each for each in (before, *trials) if each.kept), key=lambda each: each.severity, default=None)
    if best is None:
        raise RunError(_why_none(tuning, trials))
    return Tuned(tuning, before, best, trials)


def _why_none(tuning: Tuning, trials: Sequence[Candidate]) -> str:
    """Say what keeps every candidate from being run."""
    margins = [each.margin for each in trials if each.margin is not None]
    nearest = min(margins, key=tuning.short_of)
    return (
        f"none of {len(trials)} candidates keeps the margin; the nearest reflects {nearest.reflection:.4g} (at most "
        f"{tuning.reflection:g}) and damps by {nearest.damping:.4g} 1/s (at least {tuning.damping:g}); expected easier "
        "conditions, wider ranges, or less to be asked of the margin"
    )


@contextmanager
def _told(journal: EvaluationLog, folder: Path) -> Generator[None]:
    """Say what is kept when a tuning is interrupted."""
    try:
        yield
    except KeyboardInterrupt:
        raise TuningInterruptedError(folder, len(journal.found)) from None


class _Search:
    """Tries candidates: those that keep the margin are run under all conditions.

    Parameters
    ----------
    tuning : Tuning
        What is tuned.
    journal : EvaluationLog
        Runs that have been played.
    played : callable
        Plays others.
    progress : callable, optional
        Called when something has been played.
    """

    def __init__(self, tuning: Tuning, journal: EvaluationLog, played: Played, progress: Progress | None) -> None:
        self._tuning, self._journal, self._played, self._progress = tuning, journal, played, progress
        self.trials: dict[str, Candidate] = {}

    def values_at(self, place: FloatArray) -> dict[str, float]:
        """Return the gains at a place between zeros and ones."""
        return {gain.name: gain.at(float(each)) for gain, each in zip(self._tuning.gains, place, strict=True)}

    def short_of(self, place: FloatArray) -> float:
        """Return by how much a candidate does not keep the margin."""
        return self._tuning.short_of(self._known(self.values_at(place)).margin)

    def run(self, places: Iterable[FloatArray]) -> list[float]:
        """Return the severities of candidates, which are run together."""
        chosen = [self.values_at(place) for place in places]
        for values in chosen:
            self._known(values)
        return [trial.severity for trial in self._completed(chosen)]

    def trial(self, values: Mapping[str, float]) -> Candidate:
        """Return what comes of the law as it is, which is run in any case."""
        margin = self._tuning.margin(values)
        (completed,) = self._scored([(values, margin)])
        return completed

    def _known(self, values: Mapping[str, float]) -> Candidate:
        """Return a candidate, whose margin is looked at when it is first met."""
        name = key_of(values, "")[0]
        if name not in self.trials:
            margin = self._tuning.margin(values)
            self.trials[name] = Candidate(values, margin, not self._tuning.short_of(margin))
        return self.trials[name]

    def _completed(self, chosen: Sequence[Mapping[str, float]]) -> list[Candidate]:
        """Return candidates as they are when they have been run."""
        scored = self._scored([(values, self._known(values).margin) for values in chosen])
        for trial in scored:
            self.trials[key_of(trial.values, "")[0]] = trial
        return scored

    def _scored(self, chosen: Sequence[tuple[Mapping[str, float], Margin | None]]) -> list[Candidate]:
        """Play what has not been played, keep it, and return what came of each candidate."""
        tuning, found = self._tuning, self._journal.found
        conditions = tuning.league.conditions
        games: dict[Key, Game] = {}
        for values, _ in chosen:
            for condition in conditions:
                key = key_of(values, condition.name)
                if key not in found:
                    games[key] = Game(tuning.league, tuning.candidate(values), condition)
        names = {id(game): key for key, game in games.items()}
        waiting = {key[0] for key in games}
        for number, (game, score) in enumerate(self._played(list(games.values())), 1):
            if isinstance(score, Score):
                self._journal.append(names[id(game)], score)
            self._tell(len(waiting) * (number / len(games) - 1.0))
        self._tell(0.0)
        trials: list[Candidate] = []
        for values, margin in chosen:
            scores = tuple(found[key_of(values, condition.name)] for condition in conditions)
            severity = overall(scores, tuning.league.judge)
            trials.append(Candidate(values, margin, not tuning.short_of(margin), scores, severity))
        return trials

    def _tell(self, more: float) -> None:
        """Say how many of the candidates that are known have been looked at."""
        if self._progress is not None:
            least = min((each.severity for each in self.trials.values()), default=math.inf)
            said = f"severity {least:.4g}" if math.isfinite(least) else self._tuning.law.name
            self._progress(said, min(1.0, (1.0 + len(self.trials) + more) / (self._tuning.budget + 1)))


def _evolve(tuning: Tuning, search: _Search) -> None:
    """Go through generations of candidates, the first of them with the law's own gains."""
    optimize = require("scipy.optimize", extra="theory", purpose="tuning")
    sampling = require("scipy.stats.qmc", extra="theory", purpose="tuning")
    count = len(tuning.gains)
    size = max(_SMALLEST, min(5 * count, tuning.budget // 4))
    first: FloatArray = sampling.LatinHypercube(count, rng=tuning.seed).random(size)
    first[0] = [gain.place_of(gain.start) for gain in tuning.gains]
    constraints: Any = ()
    if tuning.linear:
        constraints = optimize.NonlinearConstraint(search.short_of, -np.inf, 0.0)

    def generation(function: Callable[..., float], places: Iterable[FloatArray]) -> list[float]:
        """Run the candidates of a generation together."""
        del function  # it stands for one candidate
        return search.run(list(places))

    optimize.differential_evolution(
        _alone,
        [(0.0, 1.0)] * count,
        init=first,
        maxiter=tuning.budget // size - 1,
        tol=0.0,
        polish=False,
        rng=tuning.seed,
        updating="deferred",
        workers=generation,
        constraints=constraints,
    )


def _alone(place: FloatArray) -> float:
    """Stand for the severity of one candidate: generations are run together."""
    raise NotImplementedError(f"a candidate at {place} by itself")


def _with_law(league: League, name: str) -> League:
    """Return the league with one law: of its own, or an FMU."""
    own = {law.name: law for law in league.laws if law.fmu}
    if name in own:
        return replace(league, laws=(own[name],))
    if Path(name).suffix == ".fmu":
        fmu = str(locate_fmu(name, "native"))
    elif name in promised_fmus("native"):
        fmu = name
    else:
        known = {*own, *promised_fmus("native")}
        if any(law.name == name for law in league.laws):
            raise ScenarioError(f"law '{name}' is the drive alone, which has nothing to tune; expected one with an FMU")
        raise ScenarioError(f"there is no law '{name}', nor an FMU of that name{suggestion(name, known)}")
    described = read_description(locate_fmu(fmu, "native"))
    gives = {each.name for each in described.variables if each.causality == "output"}
    drive: dict[str, Value] = {"mode": "torque"} if "motor_torque" in gives else {}
    return replace(league, laws=(Law(Path(name).stem, Path(name).stem, fmu, drive=drive),))


def _usual(league: League) -> list[str]:
    """Return the names of the conditions with the string of the first one that no good law is known to fail under."""

    def drilled(condition: Condition) -> tuple[object, ...]:
        return tuple(condition.plant.get(name) for name in _OF_THE_STRING)

    first = drilled(league.conditions[0])
    return [each.name for each in league.conditions if drilled(each) == first and not each.hard]


_OF_THE_STRING = ("G", "J", "I", "L", "I_B", "c_a", "beta")


def _digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    with path.open("rb") as file:
        return digest_of(file).hex()
