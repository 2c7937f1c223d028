"""Examines all laws and tries all claims, and keeps what each took."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from tests.verify.claim import Claim, Trial, Verdict, verdict
from tests.verify.finding import Finding, Law


@dataclass(frozen=True)
class Examined:
    """A law and what was found, in how long [s]."""

    law: Law
    finding: Finding
    duration: float


@dataclass(frozen=True)
class Tried:
    """A claim and its trials, in how long [s]."""

    claim: Claim
    trials: list[Trial]
    duration: float

    @property
    def verdict(self) -> Verdict:
        """What follows from the trials."""
        return verdict(self.trials)


def examine(laws: Iterable[Law], note: Callable[[str], None]) -> list[Examined]:
    """Examine laws one after another, noting each before; what one finds out others may use.

    A law whose examination raises is broken, and those after it are examined all the same.
    """
    done: list[Examined] = []
    for law in laws:
        note(law.statement)
        begun = time.perf_counter()
        try:
            finding = law.examine()
        except Exception as error:
            finding = Finding.broken_by(error)
        done.append(Examined(law, finding, time.perf_counter() - begun))
    return done


def try_claims(claims: Iterable[Claim], note: Callable[[str], None]) -> list[Tried]:
    """Try claims one after another, noting each before; one that raises came out as nothing that was claimed."""
    done: list[Tried] = []
    for claim in claims:
        note(claim.statement)
        begun = time.perf_counter()
        try:
            trials = claim.try_it()
        except Exception as error:
            trials = [Trial("all of it", f"{type(error).__name__}: {error}", False)]
        done.append(Tried(claim, trials, time.perf_counter() - begun))
    return done
