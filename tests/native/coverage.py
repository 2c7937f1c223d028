"""Measures which branches of the C code the driver takes, and fails below a limit: python -m tests.native.coverage."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from fmu_src import project
from fmu_src.build.native import NATIVE
from fmu_src.fmus import MODELS
from tests.native.programs import BUILD, COVERAGE, ROOT, SEED, MissingToolError, compile_linked, run

LEAST = 95.0
"""Per cent of the branches of core and adapter, no branch left out."""

CALLS = 20_000


def drive_models() -> None:
    """Make the calls that are written down, calls at random, lives, and allocations that fail, for every model."""
    for model in MODELS:
        program = compile_linked(model, COVERAGE)
        for counts in program.parent.glob("*.gcda"):
            counts.unlink()
        for mode in (["walks", "walks.txt"], ["random", SEED, CALLS], ["cycles", 3], ["starve"]):
            run([program, *mode], program.parent)


def report(summary: Path) -> str:
    """Return the table of all files; their numbers, and those of all together, go to a JSON file."""
    options = [
        "--root",
        ROOT,
        "--filter",
        f"{NATIVE}/",
        "--filter",
        f"{project.FMUS}/",
        "--txt",
        "-",
        "--txt-metric",
        "branch",
        "--json-summary",
        summary,
    ]
    return run([sys.executable, "-m", "gcovr", *options, BUILD / COVERAGE.name], ROOT)


def measure() -> tuple[str, dict[str, Any]]:
    """Drive every model; return the table, and what gcovr writes as its summary."""
    drive_models()
    summary = BUILD / "coverage.json"
    return report(summary), json.loads(summary.read_text())


if __name__ == "__main__":
    try:
        table, found = measure()
    except MissingToolError as error:
        sys.exit(str(error))
    print(table)
    sys.exit(found["branch_percent"] < LEAST)
