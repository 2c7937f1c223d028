"""Which package may import which, and how large the parts may grow: the walls of the house."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PRODUCT = ("cosim", "models", "fmu_src")

MOST_MODULES = {"cosim": 172}
"""95 that a run took when its rooms were made; since then conversions, what isolation keeps apart, bounded files,
Python functions as components, laws of one's own, the league, what hands results on to other tools, tuning, sweeps with
their maps, rooms, processes and reports, Sobol indices, progress in notebooks, and tables that are not of numbers."""

MOST_IN_A_PACKAGE = 15

UPWARDS = ("fmu_src.page", "fmu_src.python", "fmu_src.fmus", "fmu_src.build", "fmu_src.console")
"""Packages of fmu_src by height; below them are its own modules: tables, and where things lie."""

MOST_FLOORS = 8
LONGEST = 50
QUESTIONS = {"How", "What", "When", "Where", "Whether", "Which", "Why"}
LONGEST_C = 60

EXACT = ("models.plant", "models.controllers", "models.numerics")
"""Packages whose bits the C core repeats: + - * / and square roots in a fixed order."""

SAME_EVERYWHERE = {"copysign", "inf", "isfinite", "ldexp", "nan", "sqrt"}
"""What `math` gives with the same bits on every platform."""

BLIND_TO_DRILLING = ("cosim.system", "cosim.recording", "cosim.fmi2", "cosim.master")
ABOVE_THEM = (
    "cosim.drilling", "cosim.run", "cosim.scenario", "cosim.check", "cosim.league", "cosim.report", "cosim.cli",
)  # fmt: skip


def name_of(path: Path) -> str:
    """Return the module that a file is."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


SOURCES = {name_of(path): path for top in PRODUCT for path in sorted((ROOT / top).rglob("*.py"))}
TESTS = sorted((ROOT / "tests").rglob("*.py"))


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def inside(module: str, packages: str | Iterable[str]) -> bool:
    """Return whether a module is one of some packages or lies in one."""
    packages = (packages,) if isinstance(packages, str) else packages
    return any(module == package or module.startswith(f"{package}.") for package in packages)


@cache
def imported(path: Path) -> frozenset[str]:
    """Return what a file imports, wherever in it the import stands, by full names."""
    names: set[str] = set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            package = name_of(path).split(".")
            if path.name != "__init__.py":
                package.pop()
            above = package[: len(package) - node.level + 1] if node.level else []
            base = ".".join([*above, *filter(None, [node.module])])
            for alias in node.names:
                names.add(f"{base}.{alias.name}" if f"{base}.{alias.name}" in SOURCES else base)
    return frozenset(names)


def imports_of(top: str) -> dict[str, set[str]]:
    """Return the modules below a folder that each of its modules imports."""
    modules = {name for name in SOURCES if inside(name, top)}
    return {name: (set(imported(SOURCES[name])) & modules) - {name} for name in modules}


def room_of(module: str) -> str:
    """Return the first-level package a module lies in; at the top each module is a room of its own."""
    return ".".join(module.split(".")[:2])


def rooms_of(top: str) -> dict[str, set[str]]:
    rooms: dict[str, set[str]] = {}
    for module, targets in imports_of(top).items():
        rooms.setdefault(room_of(module), set()).update(room_of(target) for target in targets)
    return {room: targets - {room} for room, targets in rooms.items()}


def floors(graph: Mapping[str, set[str]]) -> dict[str, int]:
    """Return on which floor each node stands, 1 at the bottom; AssertionError names a circle."""
    found: dict[str, int] = {}

    def visit(node: str, path: tuple[str, ...]) -> int:
        assert node not in path, f"a circle of imports: {' -> '.join([*path[path.index(node) :], node])}"
        if node not in found:
            found[node] = 1 + max((visit(target, (*path, node)) for target in graph[node]), default=0)
        return found[node]

    for node in sorted(graph):
        visit(node, ())
    return found


def offenders(importers: str | Iterable[str], forbidden: str | Iterable[str]) -> dict[str, set[str]]:
    """Return which modules of some packages import what they must not."""
    found = {
        name: {target for target in imported(path) if inside(target, forbidden)}
        for name, path in SOURCES.items()
        if inside(name, importers)
    }
    return {name: targets for name, targets in found.items() if targets}


def test_floors_rise_from_import_to_importer_and_a_circle_is_named() -> None:
    assert floors({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == {"a": 3, "b": 2, "c": 1}
    with pytest.raises(AssertionError, match="a -> b -> a"):
        floors({"a": {"b"}, "b": {"a"}})


def test_an_import_is_found_in_each_of_its_forms() -> None:
    assert "models.plant.parameters" in imported(SOURCES["models.parameters"])
    assert "models.numerics.quartic" in imported(SOURCES["models.plant.bit"])
    assert "numpy" in imported(SOURCES["models.theory.stability.spectrum"])
    assert "cosim.errors" in imported(SOURCES["cosim.drilling.mathematics"])


@pytest.mark.parametrize(
    ("part", "parts"),
    [("models", {"models"}), ("fmu_src", {"fmu_src", "models"}), ("cosim", {"cosim"}), ("build_fmu", {"fmu_src"})],
)
def test_imports_of_parts_point_one_way(part: str, parts: set[str]) -> None:
    paths = [path for name, path in SOURCES.items() if inside(name, part)] or [ROOT / "build_fmu.py"]
    ours = {*PRODUCT, "build_fmu", "tests"}
    for path in paths:
        # what bridges the master's packages and the mathematics
        bridge = {"models"} if name_of(path) == "cosim.drilling.mathematics" else set[str]()
        assert {target.split(".")[0] for target in imported(path)} & ours <= parts | bridge, path


def test_only_what_knows_drilling_asks_for_mathematics() -> None:
    askers = offenders("cosim", "cosim.drilling.mathematics")
    assert askers
    # tuning asks what the linear model allows of a law
    assert all(inside(name, ("cosim.drilling", "cosim.league.tuning")) for name in askers), askers


def test_mathematics_is_named_in_no_text_but_that_of_its_bridge() -> None:
    named = {name for name, path in SOURCES.items() if inside(name, "cosim") and "cosim.models" in path.read_text()}
    assert named == {"cosim.drilling.mathematics"}


def test_master_and_what_it_stands_on_know_nothing_of_drilling() -> None:
    assert not offenders(BLIND_TO_DRILLING, ABOVE_THEM)


def test_scenarios_know_nothing_of_runs() -> None:
    assert not offenders("cosim.scenario", ("cosim.run", "cosim.check", "cosim.cli"))


def test_nothing_imports_the_command_line_but_its_entry() -> None:
    assert set(offenders("cosim", "cosim.cli")) - {"cosim.__main__"} <= {
        name for name in SOURCES if inside(name, "cosim.cli")
    }


@pytest.mark.parametrize("top", PRODUCT)
def test_modules_form_no_circle(top: str) -> None:
    assert floors(imports_of(top))


def test_no_module_of_fmu_src_imports_from_a_package_above_it() -> None:
    loose = [name for name in SOURCES if inside(name, "fmu_src") and not inside(name, UPWARDS)]
    assert all(name.count(".") <= 1 for name in loose), "expected UPWARDS to name every package"
    assert not [name for name in loose if any(inside(target, UPWARDS) for target in imported(SOURCES[name]))]
    for height, package in enumerate(UPWARDS, 1):
        assert not offenders(package, UPWARDS[height:])


@pytest.mark.parametrize("top", PRODUCT)
def test_rooms_form_no_circle_and_few_floors(top: str) -> None:
    doorstep = {top, f"{top}.__main__"}  # exports and starts what stands inside
    assert max(floor for room, floor in floors(rooms_of(top)).items() if room not in doorstep) <= MOST_FLOORS


def test_packages_of_the_theory_form_no_circle() -> None:
    graph: dict[str, set[str]] = {}
    for module, targets in imports_of("models.theory").items():
        graph.setdefault(_package(module), set()).update(map(_package, targets))
    assert floors({package: targets - {package} for package, targets in graph.items()})


def _package(module: str) -> str:
    return module if SOURCES[module].name == "__init__.py" else module.rpartition(".")[0]


@pytest.mark.parametrize("top", PRODUCT)
def test_no_package_has_too_many_modules(top: str) -> None:
    packages = [_package(name) for name in SOURCES if inside(name, top)]
    crowded = {package: packages.count(package) for package in packages}
    assert not {package: count for package, count in crowded.items() if count > MOST_IN_A_PACKAGE}
    assert len(packages) <= MOST_MODULES.get(top, len(packages))


EXACT_SOURCES = sorted(name for name in SOURCES if inside(name, EXACT))


def inexact(node: ast.AST) -> str | None:
    """Return what makes a piece of code unfit to be repeated by C to the bit, None if nothing does."""
    match node:
        case ast.BinOp(op=ast.Pow()) | ast.AugAssign(op=ast.Pow()):
            return "**"
        case ast.Call(func=ast.Name(id="sum" | "pow" as function)):
            return function
        case ast.Import(names=names) if any(alias.name.split(".")[0] in ("math", "numpy", "scipy") for alias in names):
            return f"import {names[0].name}"
        case ast.ImportFrom(module="math", names=names) if not {alias.name for alias in names} <= SAME_EVERYWHERE:
            return f"math.{names[0].name}"
        case ast.ImportFrom(module=str(module)) if module.split(".")[0] in ("numpy", "scipy", "cmath", "statistics"):
            return module
        case _:
            return None


@pytest.mark.parametrize("module", EXACT_SOURCES)
def test_what_fmus_compute_uses_only_what_has_the_same_bits_everywhere(module: str) -> None:
    assert not [f"line {node.lineno}: {inexact(node)}" for node in _statements(module) if inexact(node)]  # pyright: ignore


def _statements(module: str) -> list[ast.stmt | ast.expr]:
    return [node for node in ast.walk(tree(SOURCES[module])) if isinstance(node, ast.stmt | ast.expr)]


@pytest.mark.parametrize(
    "text",
    ["y = x**2", "y **= 2", "y = sum(x)", "y = pow(x, 2)", "import math", "from math import exp", "import numpy as np",
     "from numpy import exp", "from scipy.optimize import brentq", "from math import sqrt, sin"],
)  # fmt: skip
def test_what_has_other_bits_elsewhere_is_seen(text: str) -> None:
    assert any(map(inexact, ast.walk(ast.parse(text))))


def length(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return the lines of a function without its parameters and docstring, which are there to be long."""
    body = function.body[1:] if ast.get_docstring(function) is not None and len(function.body) > 1 else function.body
    return (body[-1].end_lineno or 0) - body[0].lineno + 1


def test_functions_are_short() -> None:
    long = {
        f"{name}.{node.name}": length(node)
        for name, path in SOURCES.items()
        for node in ast.walk(tree(path))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and length(node) > LONGEST
    }
    assert not long


def test_functions_in_c_are_short() -> None:
    long: dict[str, int] = {}
    paths = [path for top in PRODUCT for path in (ROOT / top).rglob("*.[ch]")]
    assert paths
    for path in paths:
        begin = 0
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            if line == "{":
                begin = number
            if line == "}" and number - begin >= LONGEST_C:
                long[f"{path.name}:{begin}"] = number - begin
    assert not long


def private_names(path: Path) -> set[str]:
    """Return the private names of the product that a test imports, reads or replaces."""
    product: set[str] = set()
    found: set[str] = set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.ImportFrom) and inside(node.module or "", PRODUCT):
            found |= {f"{node.module}.{alias.name}" for alias in node.names if alias.name.startswith("_")}
            product |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, ast.Import):
            product |= {alias.asname or alias.name for alias in node.names if inside(alias.name, PRODUCT)}
    for node in ast.walk(tree(path)):
        match node:
            case ast.Attribute(value=ast.Name(id=owner), attr=name) if owner in product and _private(name):
                found.add(f"{owner}.{name}")
            case ast.Call(
                func=ast.Attribute(attr="setattr"), args=[ast.Name(id=owner), ast.Constant(value=str(name)), *_]
            ) if owner in product and _private(name):
                found.add(f"{owner}.{name}")
            case ast.Call(func=ast.Attribute(attr="setattr"), args=[ast.Constant(value=str(name)), *_]) if inside(
                name, PRODUCT
            ) and any(map(_private, name.split("."))):
                found.add(name)
            case _:
                pass
    return found


def _private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


def test_no_test_uses_a_private_name_of_the_product() -> None:
    found = {path.relative_to(ROOT).as_posix(): private_names(path) for path in TESTS}
    assert not {path: names for path, names in found.items() if names}


def test_what_runs_and_shows_knows_drilling_by_its_reporting_alone() -> None:
    # commands show maps, bands and indices, which nothing that runs knows of
    shown = {"reporting", "map_figure", "severity_map", "sensitivity", "uncertainty"}
    for part, known in (("run", {"reporting"}), ("sweeps", {"reporting"}), ("cli", shown)):
        for path in (ROOT / "cosim" / part).rglob("*.py"):
            words = re.findall(r"cosim\.drilling(?: import |\.)(\w+)", path.read_text(encoding="utf-8"))
            assert set(words) <= known, path.name


@pytest.mark.parametrize("module", sorted(SOURCES))
def test_docstrings_begin_with_no_question(module: str) -> None:
    for node in ast.walk(tree(SOURCES[module])):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            text = ast.get_docstring(node) or ""
            assert text.partition(" ")[0] not in QUESTIONS, (
                f"line {getattr(node, 'lineno', 1)}: {text.partition('.')[0]}"
            )
