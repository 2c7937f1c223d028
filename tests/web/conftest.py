"""What the tests of the console have in common: the page as `make console` builds it, and what it needs to run in."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmu_src.console.page import build_page
from tests.once import built_once
from tests.programs import CHROMIUM, program


@pytest.fixture(scope="session")
def node() -> str:
    program("npm")
    return program("node")


@pytest.fixture(scope="session")
def chromium() -> str:
    return program(*CHROMIUM)


@pytest.fixture(scope="session")
def console(node: str, run_folder: Path) -> Path:
    """The folder with the built console."""
    return built_once(run_folder / "console", build_page)
