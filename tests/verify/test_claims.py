"""The committed table of claims is what the trials give, verdicts and figures."""

from __future__ import annotations

import logging

import pytest

import tests.verify.claims  # noqa: F401
from tests.verify.__main__ import PAGE
from tests.verify.claim import CLAIMS, Trial, Verdict, verdict
from tests.verify.examination import Tried, try_claims
from tests.verify.report import claims_page

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def tried() -> list[Tried]:
    logging.disable(logging.WARNING)
    try:
        return try_claims(CLAIMS, lambda _: None)
    finally:
        logging.disable(logging.NOTSET)


def test_committed_table_is_what_came_out(tried: list[Tried]) -> None:
    assert claims_page(tried).splitlines() == PAGE.read_text(encoding="utf-8").splitlines()


def test_every_figure_and_result_of_the_paper_is_judged(tried: list[Tried]) -> None:
    sources = " ".join(one.claim.source for one in tried)
    for named in (*(f"Fig. {number}" for number in range(2, 8)), "Proposition 1", "(21)", "section 4.1", "section 4.2"):
        assert named in sources


def test_claim_that_holds_with_conditions_says_which(tried: list[Tried]) -> None:
    for one in tried:
        assert one.claim.remark or one.verdict is Verdict.HOLDS, one.claim.name


def test_law_as_printed_is_not_said_to_hold(tried: list[Tried]) -> None:
    verdicts = {one.claim.name: one.verdict for one in tried}
    assert verdicts["law_9_as_printed"] is Verdict.FAILS
    assert verdicts["reference_can_be_achieved"] is Verdict.FAILS


@pytest.mark.parametrize(
    ("outcomes", "expected"),
    [([True, True], Verdict.HOLDS), ([True, False], Verdict.CONDITIONS), ([False], Verdict.FAILS)],
)
def test_verdict_follows_from_the_trials(outcomes: list[bool], expected: Verdict) -> None:
    assert verdict([Trial("", "", outcome) for outcome in outcomes]) is expected
