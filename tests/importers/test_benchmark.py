"""The loops that `make bench` compares take their steps: no other test runs them, and what they call may move."""

from __future__ import annotations

import pytest

from tests.bench.coupled import LOOPS

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("form", list(LOOPS))
def test_a_loop_of_the_benchmark_takes_all_its_steps(form: str) -> None:
    with LOOPS[form]() as loop:
        loop.run()
