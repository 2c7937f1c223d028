"""Programs that tests need beside Python."""

from __future__ import annotations

import os
import shutil

import pytest

CHROMIUM = ("chromium", "chromium-browser", "google-chrome")


def program(*names: str) -> str:
    """Return the path of a program by any of its names; where it lacks, the test is skipped, but not in CI."""
    found = next(filter(None, map(shutil.which, names)), None)
    if found is None:
        reason = f"{names[0]} is missing"
        assert not os.environ.get("CI"), f"{reason}: .ci/run installs it"
        pytest.skip(reason)
    return found
