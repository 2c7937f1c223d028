"""Every law of the verification report, judged by the function that the report runs."""

from __future__ import annotations

import pytest

import tests.verify.laws  # noqa: F401
from tests.verify.finding import LAWS, Law

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_law_holds(law: Law) -> None:
    finding = law.examine()
    assert finding.found <= finding.allowed, f"{law.statement}: {finding}"
    assert finding.reason
