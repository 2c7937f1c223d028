"""build_fmu.py through the front door, and the FMUs it makes."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Collection
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu

from fmu_src import project
from fmu_src.fmus import MODELS
from tests.once import built_once

PACKAGINGS = ("native", "python")


DIST = project.ROOT / "dist"
FEW = ("DrillstringDistributed", "SoftTorque", "WeightOnBitLaw")
"""A plant of several files, a law that remembers, and one that does not."""


def run(
    root: Path, *arguments: object, environment: dict[str, str] | None = None, umask: int = -1
) -> subprocess.CompletedProcess[str]:
    """Run build_fmu.py of a folder with the compiler's cache of this one."""
    cache = project.ROOT / "build" / "zig"
    ours = {"ZIG_GLOBAL_CACHE_DIR": str(cache / "global"), "NO_COLOR": "1", "COLUMNS": "200"}
    command = [sys.executable, str(root / "build_fmu.py"), *map(str, arguments)]
    return subprocess.run(
        command, cwd=root, env=os.environ | ours | (environment or {}), umask=umask, capture_output=True, text=True,
        check=False,
    )  # fmt: skip


def copy_sources(to: Path) -> Path:
    """Copy what the FMUs are made from to another place."""
    to.mkdir(parents=True)
    skip = shutil.ignore_patterns("__pycache__")
    for folder in ("fmu_src", "models"):
        shutil.copytree(project.ROOT / folder, to / folder, ignore=skip)
    for name in ("build_fmu.py", "pyproject.toml", "LICENSE", "README.md"):
        shutil.copy(project.ROOT / name, to)
    return to


@pytest.fixture(scope="session")
def built(run_folder: Path) -> Path:
    """All FMUs in both packagings, for this platform alone."""

    def build(output: Path) -> None:
        done = run(project.ROOT, "--output", output)
        assert done.returncode == 0, done.stderr

    return built_once(run_folder / "built", build)


@pytest.mark.parametrize("package", ["typer", "jinja2"])
def test_a_package_that_is_not_there_is_told_in_one_sentence(package: str, tmp_path: Path) -> None:
    (tmp_path / f"{package}.py").write_text(f"raise ModuleNotFoundError(name='{package}')", encoding="utf-8")
    done = run(project.ROOT, environment={"PYTHONPATH": str(tmp_path)})
    how = 'pip install -e ".[build]" brings all it needs'
    assert (done.returncode, done.stderr) == (1, f"error: building FMUs needs the package {package}; {how}\n")


@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("name", MODELS)
def test_every_fmu_keeps_to_the_standard(packaging: str, name: str) -> None:
    assert validate_fmu(str(DIST / packaging / f"{name}.fmu")) == []


@pytest.mark.cross_build
@pytest.mark.parametrize("packaging", PACKAGINGS)
@pytest.mark.parametrize("name", MODELS)
def test_every_fmu_carries_its_page_and_all_licences(packaging: str, name: str) -> None:
    expected = {"native": {"fmi-headers.txt", "zig.txt", "mingw-w64.txt"}, "python": {"pythonfmu.txt"}}
    with zipfile.ZipFile(DIST / packaging / f"{name}.fmu") as archive:
        names = archive.namelist()
        assert name in archive.read("documentation/index.html").decode()
        entry = archive.read("documentation/licenses/license.txt").decode()
    texts = {name.removeprefix("documentation/licenses/") for name in names if "/licenses/" in name} - {"license.txt"}
    assert entry.startswith("MIT License")
    assert texts == expected[packaging]
    assert {text for text in texts if f"\n  {text}: " in entry} == texts
    assert not [name for name in names if name.startswith("/") or ".." in name or "__pycache__" in name]


@pytest.mark.parametrize("name", MODELS)
def test_both_packagings_have_the_same_variables(name: str) -> None:
    tables = [
        [(v.name, v.valueReference, v.type, v.causality, v.variability, v.unit, v.start, v.min, v.max) for v in found]
        for found in (
            fmpy.read_model_description(str(DIST / packaging / f"{name}.fmu")).modelVariables
            for packaging in PACKAGINGS
        )
    ]
    assert tables[0] == tables[1]


@pytest.mark.parametrize("name", MODELS)
def test_a_python_fmu_needs_nothing_but_the_standard_library(name: str) -> None:
    imported: set[str] = set()
    with zipfile.ZipFile(DIST / "python" / f"{name}.fmu") as archive:
        for path in archive.namelist():
            if path.endswith(".py"):
                for node in ast.walk(ast.parse(archive.read(path))):
                    if isinstance(node, ast.Import):
                        imported |= {alias.name.split(".")[0] for alias in node.names}
                    elif isinstance(node, ast.ImportFrom) and not node.level:
                        imported.add(str(node.module).split(".")[0])
    assert {name for name in imported - sys.stdlib_module_names if not name.startswith("drillstring_")} == set()


def assert_same_files(folder: Path, other: Path, names: Collection[str] = MODELS) -> None:
    paths = sorted(path.relative_to(folder) for path in folder.rglob("*.fmu") if path.stem in names)
    assert len(paths) == len(PACKAGINGS) * len(names)
    for path in paths:
        assert (other / path).read_bytes() == (folder / path).read_bytes(), path


@pytest.mark.slow
@pytest.mark.cross_build
def test_a_build_elsewhere_from_nothing_gives_the_bytes_of_dist(tmp_path: Path) -> None:
    elsewhere = copy_sources(tmp_path / "some where" / "else")
    environment = {
        "ZIG_GLOBAL_CACHE_DIR": str(tmp_path / "zig"), "ZIG_LOCAL_CACHE_DIR": str(tmp_path / "zig"),
        "HOME": str(tmp_path), "TMPDIR": str(tmp_path), "PYTHONHASHSEED": "271828", "LC_ALL": "C", "TZ": "Pacific/Apia",
        "SOURCE_DATE_EPOCH": "1234567890",
    }  # fmt: skip
    output = tmp_path / "output"
    done = run(elsewhere, "--platform", "all", "--output", output, *FEW, environment=environment, umask=0o077)
    assert done.returncode == 0, done.stderr
    assert_same_files(DIST, output, FEW)


@pytest.mark.slow
@pytest.mark.cross_build
def test_the_installed_package_builds_the_same_bytes(built: Path, wheel: Path, tmp_path: Path) -> None:
    place = tmp_path / "installed"
    zipfile.ZipFile(wheel).extractall(place)
    ours = {"ZIG_GLOBAL_CACHE_DIR": str(project.ROOT / "build" / "zig" / "global"), "PYTHONPATH": str(place)}
    command = [sys.executable, "-m", "cosim.fmu_src.build", "--output", str(tmp_path / "output")]
    done = subprocess.run(
        command, cwd=tmp_path, env=os.environ | ours, capture_output=True, text=True, check=False
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert_same_files(built, tmp_path / "output")


@pytest.mark.cross_build
@pytest.mark.parametrize("name", MODELS)
def test_a_library_is_the_same_whatever_others_are_beside_it(built: Path, name: str) -> None:
    alone, among = (zipfile.ZipFile(folder / "native" / f"{name}.fmu") for folder in (built, DIST))
    with alone, among:
        (library,) = (member for member in alone.namelist() if member.startswith("binaries/"))
        assert len([member for member in among.namelist() if member.startswith("binaries/")]) == 5
        for member in (library, "modelDescription.xml"):
            assert alone.read(member) == among.read(member)


def test_an_edit_changes_the_identity(tmp_path: Path) -> None:
    elsewhere = copy_sources(tmp_path / "edited")
    for source in ("fmu_src/fmus/WeightOnBitLaw/model.c", "fmu_src/fmus/WeightOnBitLaw/slave.py"):
        path = elsewhere / source
        path.write_text(path.read_text() + "\n")
    done = run(elsewhere, "--output", tmp_path / "output", "WeightOnBitLaw")
    assert done.returncode == 0, done.stderr
    for packaging in PACKAGINGS:
        paths = [folder / packaging / "WeightOnBitLaw.fmu" for folder in (DIST, tmp_path / "output")]
        guids = [fmpy.read_model_description(str(path)).guid for path in paths]
        assert guids[0] != guids[1]


def test_a_build_that_fails_leaves_what_was_there(tmp_path: Path) -> None:
    elsewhere = copy_sources(tmp_path / "broken")
    with (elsewhere / "fmu_src" / "native" / "fmi2.c").open("a") as file:
        file.write("int broken(void) { return }\n")
    place = tmp_path / "output" / "native"
    place.mkdir(parents=True)
    (place / "WeightOnBitLaw.fmu").write_text("old")
    done = run(elsewhere, "--output", tmp_path / "output", "--packaging", "native", "WeightOnBitLaw")
    assert done.returncode == 1
    assert "WeightOnBitLaw: the C code does not compile" in done.stderr
    assert "fmi2.c:" in done.stderr
    assert [path.read_text() for path in place.iterdir()] == ["old"]


def test_an_unknown_model_is_refused_with_the_list(tmp_path: Path) -> None:
    done = run(project.ROOT, "--output", tmp_path / "output", "WeightOnBitLaw", "Drillstring")
    assert done.returncode == 2
    assert f"Drillstring: no such model; expected any of {', '.join(MODELS)}" in done.stderr
    assert not (tmp_path / "output").exists()


def test_a_folder_without_an_interface_table_of_its_name_is_refused(tmp_path: Path) -> None:
    elsewhere = copy_sources(tmp_path / "renamed")
    fmus = elsewhere / "fmu_src" / "fmus"
    (fmus / "WeightOnBitLaw").rename(fmus / "WeightLaw")
    done = run(elsewhere, "--output", tmp_path / "output")
    path = fmus / "WeightLaw" / "interface.py"
    sentence = f"error: {path} defines no MODEL with the name of its folder, WeightLaw\n"
    assert (done.returncode, done.stderr) == (1, sentence)


def test_an_output_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    done = run(project.ROOT, "--output", tmp_path / "file", "--packaging", "python", "WeightOnBitLaw")
    assert done.returncode == 1
    assert "choose another folder with --output" in done.stderr
