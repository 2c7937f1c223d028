"""What the tests of the console have in common: the page as `make console` builds it, and what it needs to run in."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from fmu_src.console.page import build_page
from tests.once import built_once


def program(*names: str) -> str:
    """Return the path of a program by any of its names; where it lacks, the test is skipped, but not in CI."""
    found = next(filter(None, map(shutil.which, names)), None)
    if found is None:
        reason = f"{names[0]} is missing"
        assert not os.environ.get("CI"), f"{reason}: .ci/run installs it"
        pytest.skip(reason)
    return found


@pytest.fixture(scope="session")
def node() -> str:
    program("npm")
    return program("node")


@pytest.fixture(scope="session")
def chromium() -> str:
    return program("chromium", "chromium-browser", "google-chrome")


@pytest.fixture(scope="session")
def console(node: str, run_folder: Path) -> Path:
    """The folder with the built console."""
    return built_once(run_folder / "console", build_page)
