"""What the log shows on the terminal: sentences, and each thing once."""

from __future__ import annotations

import logging
from collections.abc import Generator
from io import StringIO

import pytest
from rich.console import Console

from cosim.cli.terminal import SentenceHandler


@pytest.fixture
def shown() -> Generator[StringIO]:
    """What is written while the handler listens."""
    text = StringIO()
    handler = SentenceHandler(Console(file=text, width=200))
    logging.getLogger("cosim").addHandler(handler)
    yield text
    logging.getLogger("cosim").removeHandler(handler)


def test_what_an_fmu_says_again_in_a_repeated_step_is_shown_once(shown: StringIO) -> None:
    for name in ("plant", "plant", "law", "plant"):
        logging.getLogger(f"cosim.fmi2.{name}").warning("t = %s s: too much", 0.5)
    logging.getLogger("cosim.fmi2.plant").warning("t = %s s: too much", 0.75)
    assert shown.getvalue().splitlines() == [
        "warning: plant: t = 0.5 s: too much",
        "warning: law: t = 0.5 s: too much",
        "warning: plant: t = 0.75 s: too much",
    ]


@pytest.mark.parametrize("message", ["plant at t = 0.50 s: too much", "plant: too much"])
def test_a_name_that_an_fmu_says_itself_is_not_said_twice(shown: StringIO, message: str) -> None:
    for _ in range(2):
        logging.getLogger("cosim.fmi2.plant").warning(message)
    logging.getLogger("cosim.fmi2.plant").warning("plants at t = 1 s: none")
    assert shown.getvalue().splitlines() == [f"warning: {message}", "warning: plant: plants at t = 1 s: none"]
