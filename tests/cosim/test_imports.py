"""What is imported when: nothing heavy before it is needed, and what is absent is told in one sentence."""

from __future__ import annotations

import ast
import importlib
import inspect
import json
import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from typer.testing import CliRunner

import cosim
from cosim import open_trajectory
from cosim.cli.app import app
from cosim.errors import MissingPackageError, require

HEAVY = ("fmu_manipulation_toolbox", "matplotlib", "pandas", "pydantic", "scipy", "xarray", "zarr")


def loaded_by(program: str) -> set[str]:
    """Return the packages that a program has loaded in a fresh Python when it ends."""
    ending = "import json, sys; print(json.dumps(sorted({name.partition('.')[0] for name in sys.modules})))"
    command = [sys.executable, "-c", f"{program}\n{ending}"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


@pytest.mark.parametrize(
    "program", ["import cosim", "from cosim import *", "import cosim.cli.app", "import cosim.run.stream"]
)
def test_no_heavy_package_is_imported_before_it_is_needed(program: str) -> None:
    assert loaded_by(program).isdisjoint(HEAVY)


@pytest.mark.parametrize("program", ["import cosim", "import cosim.cli.app"])
def test_neither_the_package_nor_its_help_loads_numpy_or_fmpy(program: str) -> None:
    assert loaded_by(program).isdisjoint({"fmpy", "lxml", "numpy"})


def test_what_the_package_exports_loads_neither_fmpy_nor_an_algorithm() -> None:
    program = "from cosim import *; import sys; assert 'cosim.master.fixed_step' not in sys.modules"
    assert loaded_by(program).isdisjoint({"fmpy", "lxml", "platformdirs"})


def test_what_is_exported_lazily_is_what_type_checkers_see() -> None:
    tree = ast.parse(Path(cosim.__file__).read_text(encoding="utf-8"))
    (guarded,) = (node for node in tree.body if isinstance(node, ast.If))
    seen = {
        alias.name: node.module
        for node in guarded.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }  # fmt: skip
    assert set(seen) == set(cosim.__all__)
    for name, home in seen.items():
        assert getattr(cosim, name) is getattr(importlib.import_module(str(home)), name)
    assert set(cosim.__all__) <= set(dir(cosim))


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'cosim' has no attribute 'simulat'"):
        _ = cosim.simulat  # pyright: ignore[reportAttributeAccessIssue]


def test_the_version_is_the_installed_one() -> None:
    shown = CliRunner().invoke(app, ["--version"])
    assert (shown.exit_code, shown.stdout) == (0, f"cosim {cosim.__version__}\n")
    assert cosim.__version__ == metadata.version("drillstring-cosim")


def hide(monkeypatch: pytest.MonkeyPatch, package: str) -> None:
    """Make imports of a package fail as if it were not installed."""
    for name in [name for name in sys.modules if name.partition(".")[0] == package]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)


@pytest.mark.parametrize("package", ["numcodecs"])
def test_streaming_without_codecs_is_refused_before_anything_is_written(
    package: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    hide(monkeypatch, package)
    told = CliRunner().invoke(app, ["run", "stick-slip", "--stream", "--output", str(tmp_path / "run")])
    assert told.exit_code == 2
    how = 'pip install "drillstring-cosim[stream]" brings it'
    assert told.stderr == f"error: writing Zarr needs the package {package}; {how}\n"
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("package", ["xarray", "numcodecs"])
def test_reading_a_trajectory_says_what_it_needs(package: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    hide(monkeypatch, package)
    (tmp_path / "trajectory.zarr").mkdir()
    with pytest.raises(
        MissingPackageError, match=rf"^reading Zarr needs the package {package}; pip install .*\[stream"
    ):
        open_trajectory(tmp_path)


def test_a_container_says_what_it_needs(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    hide(monkeypatch, "fmu_manipulation_toolbox")
    told = CliRunner().invoke(app, ["export", "stick-slip", "--container", str(tmp_path / "all.fmu")])
    assert told.exit_code == 2
    how = 'pip install "drillstring-cosim[container]" brings it'
    assert told.stderr == f"error: writing an FMU of FMUs needs the package fmu-manipulation-toolbox; {how}\n"
    assert list(tmp_path.iterdir()) == []


def test_what_is_there_is_returned() -> None:
    assert require("json", extra="stream", purpose="this") is json


@pytest.mark.parametrize("name", sorted(cosim.__all__))
def test_what_is_exported_says_what_it_takes_gives_and_raises(name: str) -> None:
    exported = getattr(cosim, name)
    text = inspect.getdoc(exported) or ""
    if isinstance(exported, type) and (issubclass(exported, Exception) or name == "Signal"):
        assert text  # raised by the package, or derived from
        return
    signature = inspect.signature(exported)
    takes = {each for each in signature.parameters if not each.startswith("_")} - {"keywords", "self"}
    section = text.partition("Parameters\n")[2] or text.partition("Attributes\n")[2]
    named = {
        word for line in section.splitlines() if " : " in line for word in re.split(r"[,\s]+", line.partition(" : ")[0])
    }
    assert takes <= named, f"{name} says nothing of {sorted(takes - named)}"
    if not isinstance(exported, type) and signature.return_annotation not in (None, "None"):
        assert "Returns\n" in text or "Yields\n" in text
