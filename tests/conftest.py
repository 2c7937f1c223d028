"""Order the tests, give their workers a folder to share, and report at the end what was skipped and measured."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Generator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import settings

from cosim.processes import processors
from tests.once import built_once, shared_folder
from tests.programs import CHROMIUM, program

if TYPE_CHECKING:
    from playwright.sync_api import Browser

# A run tries the same examples as the run before it, whoever makes it; `make hunt` looks for new ones.
settings.register_profile("same", derandomize=True, deadline=None, database=None)
settings.register_profile("hunt", deadline=None, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))

ROOT = Path(__file__).parents[1]
MADE = ("build", "dist", "runs")
"""Folders at the top of the checkout that what runs in it has made."""
# zig gives up where it cannot write its cache, which is in the home by default: the tests use the caches of the build.
for _cache in ("local", "global"):
    os.environ.setdefault(f"ZIG_{_cache.upper()}_CACHE_DIR", str(ROOT / "build" / "zig" / _cache))
FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip
"""Of Chromium: it asks nobody for anything."""
COSTLY = ("cross_build", "hardening", "slow")


@pytest.fixture(scope="session")
def run_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder that all workers of this run share: to be filled by `tests.once.built_once`."""
    return shared_folder(tmp_path_factory)


def _untracked(folder: str, names: list[str]) -> set[str]:
    """Return what of a folder is none of the sources."""
    made = {*MADE} if Path(folder) == ROOT else {"built", "node_modules"}
    return {name for name in names if name[0] == "." or name.endswith((".egg-info", "__pycache__")) or name in made}


@pytest.fixture(scope="session")
def wheel(run_folder: Path) -> Path:
    """Build the wheel of the project, with the FMUs for all platforms."""

    def build(folder: Path) -> None:
        # of a copy: other processes run what stands in the checkout, where a build puts its own FMUs and step loop
        with TemporaryDirectory() as temporary:
            copy = shutil.copytree(ROOT, Path(temporary) / "checkout", ignore=_untracked)
            options = ["--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder)]
            subprocess.run(
                [sys.executable, "-m", "pip", "wheel", *options, str(copy)], env=_compiled_before(), check=True
            )

    return next(built_once(run_folder / "wheel", build).glob("*.whl"))


@pytest.fixture(scope="module")
def browser() -> Generator[Browser]:
    """Start Chromium; where there is none, the test is skipped, but not in CI."""
    from playwright.sync_api import sync_playwright

    found = program(*CHROMIUM)
    with sync_playwright() as play:
        started = play.chromium.launch(executable_path=found, args=FLAGS)
        yield started
        started.close()


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Have one worker more than there are processors: many tests wait for processes that they have started."""
    return processors() + 1


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put modules that hold costly tests first, so that no worker begins one when the others are about to end."""
    costly = {item.path for item in items if any(item.get_closest_marker(mark) for mark in COSTLY)}
    items.sort(key=lambda item: item.path not in costly)


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Say what tests/native was skipped for and what it has measured."""
    # not in tests/native/conftest.py, which the process that gathers the reports of workers does not load
    here = [report for reports in terminalreporter.stats.values() for report in reports if _is_native(report)]
    lines = {report.longrepr[2] for report in here if report.skipped}
    lines |= {value for report in here if report.when == "call" for _, value in report.user_properties}
    for line in sorted(lines):
        terminalreporter.write_line(f"tests/native: {line}")


def _compiled_before() -> dict[str, str]:
    """Return an environment in which zig finds what it has compiled for the checkout."""
    cache = ROOT / "build" / "zig"
    folders = {"ZIG_LOCAL_CACHE_DIR": str(cache / "local"), "ZIG_GLOBAL_CACHE_DIR": str(cache / "global")}
    return folders | os.environ


def _is_native(report: object) -> bool:
    return isinstance(report, pytest.TestReport) and report.nodeid.startswith("tests/native/")
