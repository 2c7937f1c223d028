"""Which part of the project may import which: build_fmu -> fmu_src -> models, and the master on FMUs alone."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PARTS = ("build_fmu", "cosim", "fmu_src", "models", "tests")

# The master knows an FMU by its modelDescription alone. What knows strings and bits asks one module for mathematics.
MATHEMATICS = "cosim/drilling/mathematics.py"
MAY_USE_MATHEMATICS = {
    "cosim/drilling/maps.py",
    "cosim/drilling/energy_growth.py",
}


def imported(path: Path) -> set[str]:
    """Return the parts of the project that a file imports, wherever in it the import stands."""
    depth = len(path.relative_to(ROOT).parts) - 1
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            inside = path.relative_to(ROOT).parts[0] if node.level <= depth else "outside"
            names.add(inside if node.level else str(node.module))
    return {name.split(".")[0] for name in names} & {*PARTS, "outside"}


def allowed(path: Path) -> set[str]:
    relative = path.relative_to(ROOT)
    match relative.parts[0]:
        case "models":
            return {"models"}
        case "fmu_src":
            return {"fmu_src", "models"}
        case "cosim":
            return {"cosim", "models"} if relative.as_posix() == MATHEMATICS else {"cosim"}
        case _:
            return {"fmu_src", "models"}


SOURCES = sorted(path for part in ("models", "fmu_src", "cosim") for path in (ROOT / part).rglob("*.py"))


@pytest.mark.parametrize("path", [*SOURCES, ROOT / "build_fmu.py"], ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_point_one_way(path: Path) -> None:
    assert imported(path) <= allowed(path)


def test_only_what_knows_drilling_asks_for_mathematics() -> None:
    importers = {
        path.relative_to(ROOT).as_posix()
        for path in SOURCES
        if path.is_relative_to(ROOT / "cosim")
        and "cosim.drilling.mathematics import" in path.read_text(encoding="utf-8")
    }
    assert importers == MAY_USE_MATHEMATICS


FLOORS = {"page": 1, "python": 2, "fmus": 3, "build": 4}
"""Packages of fmu_src by height; below them are its own modules: tables, and where things lie."""


def imported_floors(path: Path) -> set[int]:
    """Return the floors of fmu_src that one of its modules imports from."""
    package = path.relative_to(ROOT).parts[:-1]
    floors: set[int] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.ImportFrom):
            continue
        start = package[: len(package) - node.level + 1] if node.level else ()
        parts = [*start, *(node.module or "").split(".")]
        if parts[0] == "fmu_src":
            names = [parts[1]] if parts[1:] and parts[1] else [alias.name for alias in node.names]
            floors |= {FLOORS.get(name, 0) for name in names}
    return floors


@pytest.mark.parametrize(
    "path", sorted((ROOT / "fmu_src").rglob("*.py")), ids=lambda path: str(path.relative_to(ROOT / "fmu_src"))
)
def test_no_module_of_fmu_src_imports_from_a_package_above_it(path: Path) -> None:
    own = FLOORS.get(path.relative_to(ROOT / "fmu_src").parts[0], 0)
    assert max(imported_floors(path), default=0) <= own


def test_what_runs_and_shows_knows_drilling_by_its_reporting_alone() -> None:
    for part in ("run", "cli"):
        for path in (ROOT / "cosim" / part).glob("*.py"):
            words = re.findall(r"cosim\.drilling(?: import |\.)(\w+)", path.read_text(encoding="utf-8"))
            assert set(words) <= {"reporting"}, path.name
