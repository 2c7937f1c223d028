"""Hold what a check of an FMU finds: verdicts, findings, comparisons with a reference, and the report of them all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, TypeVar


class Verdict(StrEnum):
    """Tell the end of a check.

    Only `FAILED` fails the FMU. `NOTED` is what the standard allows and an importer should know.
    """

    PASSED = "passed"
    FAILED = "failed"
    NOTED = "noted"
    NOT_CHECKED = "not checked"


class Group(StrEnum):
    """Group checks by their subject."""

    FILE = "file"
    DESCRIPTION = "description"
    BEHAVIOUR = "behaviour"
    REFERENCE = "reference"


@dataclass(frozen=True)
class Finding:
    """One check: what was done, what was found, what is allowed.

    Attributes
    ----------
    group : Group
        What it is about.
    check : str
        Its name, a few words.
    done, found, allowed : str
        Short texts; `found` says why if nothing was checked.
    seconds : float
        Wall time it took.
    """

    group: Group
    check: str
    done: str
    found: str
    allowed: str
    verdict: Verdict
    seconds: float = 0.0


@dataclass(frozen=True)
class Comparison:
    """One variable of one experiment beside its reference, where it is worst.

    Attributes
    ----------
    experiment, variable, unit : str
        What was compared.
    time : float
        Where the difference is greatest beside what is allowed there [s].
    result, reference : float
        There, in the variable's unit.
    difference, allowed : float
        There, in the variable's unit; a difference that is not finite is never allowed.
    points : int
        Times compared.
    reason : str
        Why so much is allowed.
    """

    experiment: str
    variable: str
    unit: str
    time: float
    result: float
    reference: float
    difference: float
    allowed: float
    points: int
    reason: str

    @property
    def verdict(self) -> Verdict:
        """Passed if the difference is a number and not above what is allowed."""
        return Verdict.PASSED if self.difference <= self.allowed else Verdict.FAILED

    @property
    def share(self) -> float:
        """The difference as a share of what is allowed; infinite if nothing is allowed and there is one."""
        if self.difference == 0.0:
            return 0.0
        return self.difference / self.allowed if self.allowed > 0.0 else float("inf")


@dataclass(frozen=True)
class Report:
    """All findings about one FMU.

    Attributes
    ----------
    path : Path
        The file.
    title : str
        What it is, in a line.
    """

    path: Path
    title: str
    findings: tuple[Finding, ...]
    comparisons: tuple[Comparison, ...] = ()

    @property
    def passed(self) -> bool:
        """Tell whether nothing failed."""
        return not self.count(Verdict.FAILED)

    def count(self, verdict: Verdict) -> int:
        """Return how many findings ended so."""
        return sum(finding.verdict is verdict for finding in self.findings)


@dataclass(frozen=True)
class Outcome:
    """Hold the result of a check of the running FMU, of which name and deed are known beforehand."""

    verdict: Verdict
    found: str
    allowed: str = ""
    done: str = ""
    data: Any = None


def passed(found: str, allowed: str = "", *, done: str = "", data: Any = None) -> Outcome:
    """Return a passed outcome; `done` replaces what the check says it does, `data` is for later checks."""
    return Outcome(Verdict.PASSED, found, allowed, done, data)


def failed(found: str, allowed: str = "", *, done: str = "", data: Any = None) -> Outcome:
    """Return a failed outcome."""
    return Outcome(Verdict.FAILED, found, allowed, done, data)


def noted(found: str, allowed: str = "", *, done: str = "") -> Outcome:
    """Return an outcome that an importer should know of."""
    return Outcome(Verdict.NOTED, found, allowed, done)


def not_checked(why: str) -> Outcome:
    """Return why nothing was checked."""
    return Outcome(Verdict.NOT_CHECKED, why)


Thing = TypeVar("Thing")

_MANY = 3


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, in the plural unless there is one."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def sample(things: Sequence[Thing], most: int) -> Sequence[Thing]:
    """Return all of a few things, or as many as `most` spread evenly over many."""
    return things if len(things) <= most else [things[len(things) * place // most] for place in range(most)]


def some(texts: Sequence[str]) -> str:
    """Join the first few of many texts."""
    rest = len(texts) - _MANY
    return "; ".join(texts[:_MANY]) + (f"; and {rest} more" if rest > 0 else "")
