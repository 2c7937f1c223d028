"""What not every machine has is asked for: a test that needs it is skipped, and in continuous integration it fails."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any

import pytest

from tests.native.programs import MissingToolError


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call() -> Iterator[None]:
    try:
        return (yield)
    except MissingToolError as error:
        if "CI" in os.environ:
            raise
        pytest.skip(str(error))


def pytest_terminal_summary(terminalreporter: Any) -> None:
    here = [report for reports in terminalreporter.stats.values() for report in reports if _is_here(report)]
    lines = {report.longrepr[2] for report in here if report.skipped}
    lines |= {value for report in here if report.when == "call" for _, value in report.user_properties}
    for line in sorted(lines):
        terminalreporter.write_line(f"tests/native: {line}")


def _is_here(report: object) -> bool:
    return isinstance(report, pytest.TestReport) and report.nodeid.startswith("tests/native/")
