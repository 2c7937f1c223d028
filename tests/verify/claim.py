"""A claim of the paper, what was run to judge it, and the verdict that follows."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum


class Verdict(Enum):
    """Of a claim: it came out in all trials, in some, or in none."""

    HOLDS = "holds"
    CONDITIONS = "holds with conditions"
    FAILS = "does not hold"


@dataclass(frozen=True)
class Trial:
    """One thing that was run: what, what came out, and whether that is as claimed."""

    ran: str
    came_out: str
    as_claimed: bool


@dataclass(frozen=True)
class Claim:
    """A claim and its trials.

    Attributes
    ----------
    name, statement, source : str
        Of the function that tries it, its docstring's first paragraph, and where in the paper it stands.
    remark : str
        The docstring's second paragraph: what decides, where a claim holds with conditions.
    try_it : callable
        Returns the trials.
    """

    name: str
    statement: str
    source: str
    remark: str
    try_it: Callable[[], list[Trial]]


def verdict(trials: list[Trial]) -> Verdict:
    """Return the verdict that follows from trials."""
    outcomes = {trial.as_claimed for trial in trials}
    if outcomes == {True}:
        return Verdict.HOLDS
    return Verdict.CONDITIONS if True in outcomes else Verdict.FAILS


CLAIMS: list[Claim] = []
"""In the order of the paper's equations and figures."""


def claim(source: str) -> Callable[[Callable[[], list[Trial]]], Callable[[], list[Trial]]]:
    """Enter a function into the list of claims; its docstring states the claim, and below what decides."""

    def entered(try_it: Callable[[], list[Trial]]) -> Callable[[], list[Trial]]:
        statement, _, remark = (try_it.__doc__ or "").partition("\n\n")
        texts = (" ".join(text.split()) for text in (statement, remark))
        name, (claimed, decides) = try_it.__name__, texts
        CLAIMS.append(Claim(name, claimed.rstrip("."), source, decides, try_it))
        return try_it

    return entered
