"""Enough of the C code is driven: its branches, counted by gcov over all models."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from fmu_src import project
from fmu_src.build.native import NATIVE
from tests.native import coverage

pytestmark = pytest.mark.hardening


def test_nearly_all_branches_of_core_and_adapter_are_taken(record_property: Callable[[str, object], None]) -> None:
    table, found = coverage.measure()
    counted = {file["filename"].rpartition("/")[2] for file in found["files"]}
    hand_written = [*NATIVE.glob("*.c"), *project.FMUS.glob("*/*.c")]
    assert {path.name for path in hand_written} <= counted
    record_property("branches", "{branch_percent} % of {branch_total} branches of the C code are taken".format(**found))
    assert found["branch_percent"] >= coverage.LEAST, table
