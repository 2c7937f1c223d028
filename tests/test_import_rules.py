"""Which part of the project may import which: build_fmu -> fmu_src -> models, and the master on FMUs alone."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PARTS = ("build_fmu", "cosim", "fmu_src", "models", "tests")

# Presets and theory may come from models here; the master knows an FMU by its modelDescription alone.
MAY_USE_MODELS = ("scenario", "preset", "map", "sweep", "tuning", "tune", "report")


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
            preset = any(word in part for part in relative.parts[1:] for word in MAY_USE_MODELS)
            return {"cosim", "models"} if preset else {"cosim"}
        case _:
            return {"fmu_src", "models"}


SOURCES = sorted(path for part in ("models", "fmu_src", "cosim") for path in (ROOT / part).rglob("*.py"))


@pytest.mark.parametrize("path", [*SOURCES, ROOT / "build_fmu.py"], ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_point_one_way(path: Path) -> None:
    assert imported(path) <= allowed(path)
