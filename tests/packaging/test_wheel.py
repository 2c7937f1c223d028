"""The wheel in an empty environment: any folder, no compiler, no checkout, somebody else's `models` beside it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from fmu_src.fmus import MODELS

ROOT = Path(__file__).parents[2]
LIMIT = 8e6  # bytes of the wheel
INSTALLED_LIMIT = 350e6  # bytes with all that it depends on

pytestmark = [pytest.mark.slow, pytest.mark.cross_build]


@pytest.fixture(scope="module")
def environment(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the wheel and what it depends on, by the pins; its packages cannot be written."""
    folder = tmp_path_factory.mktemp("environment")
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / "env"], check=True)
    python = executable(folder / "env", "python")
    pins = folder / "pins.txt"
    lines = (ROOT / "requirements" / "run.txt").read_text(encoding="utf-8").replace("\\\n", " ").splitlines()
    pins.write_text("\n".join(line.split(" --hash")[0] for line in lines), encoding="utf-8")
    command = [sys.executable, "-m", "uv", "pip", "install", "--quiet", "--python", python, "-c", pins, wheel]
    subprocess.run(command, check=True)
    for path in site_packages(folder / "env").rglob("*"):
        path.chmod(path.stat().st_mode & ~0o222)
    return folder / "env"


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder with a package `models` of its own."""
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "__init__.py").write_text('WHOSE = "another project\'s"\n', encoding="utf-8")
    return tmp_path


def executable(environment: Path, name: str) -> Path:
    return environment / "Scripts" / f"{name}.exe" if os.name == "nt" else environment / "bin" / name


def site_packages(environment: Path) -> Path:
    pattern = "Lib/site-packages" if os.name == "nt" else "lib/python*/site-packages"
    return next(environment.glob(pattern))


def run(environment: Path, name: str, *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run a program of the environment, with no other on the path and a home folder of its own."""
    home = cwd / "home"
    home.mkdir(exist_ok=True)
    variables = {
        key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "COSIM", "XDG", "VIRTUAL_ENV"))
    }
    variables |= {"HOME": str(home), "USERPROFILE": str(home), "PATH": str(executable(environment, name).parent)}
    return subprocess.run(
        [executable(environment, name), *arguments], cwd=cwd, env=variables, capture_output=True, text=True, check=False
    )


def test_it_is_small_and_brings_no_name_but_its_own(wheel: Path) -> None:
    assert wheel.name.endswith("-py3-none-any.whl")
    assert wheel.stat().st_size < LIMIT
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    assert {name.split("/")[0] for name in names if ".dist-info" not in name} == {"cosim"}
    built = {name for name in names if name.startswith("cosim/built/")}
    models = {path.parent.name for path in (ROOT / "fmu_src" / "fmus").glob("*/interface.py")}
    assert {Path(name).stem for name in built if name.endswith(".fmu")} == models
    assert len([name for name in built if name.endswith(".sha256")]) == 5
    assert not (ROOT / "cosim" / "built").exists(), "it stands in the checkout while a wheel is packed only"


def test_it_installs_in_little_space(environment: Path) -> None:
    files = (path for path in site_packages(environment).rglob("*") if path.is_file())
    assert sum(path.stat().st_size for path in files) < INSTALLED_LIMIT


def test_the_main_job_runs_anywhere_with_the_compiled_loop(environment: Path, project: Path) -> None:
    done = run(environment, "cosim", "run", "stick-slip", cwd=project)
    assert (done.returncode, done.stderr) == (0, "")
    for digits in ("3.2256227", "18.7605", "0.458836"):
        assert digits in done.stdout
    manifest = json.loads((project / "runs" / "stick-slip" / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["variants"][0]["step_loop"] == "compiled"


def test_a_project_with_a_package_of_that_name_keeps_it(environment: Path, project: Path) -> None:
    script = "import models, cosim.models.parameters; print(models.WHOSE)"
    done = run(environment, "python", "-c", script, cwd=project)
    assert (done.stdout, done.stderr) == ("another project's\n", "")


def test_the_fmus_are_handed_out(environment: Path, project: Path) -> None:
    done = run(environment, "cosim", "fmus", "for-my-tool", cwd=project)
    assert done.returncode == 0, done.stderr
    assert len(list((project / "for-my-tool").glob("*.fmu"))) == len(MODELS)


def test_what_is_not_there_is_one_sentence(environment: Path, project: Path) -> None:
    for arguments, sentence in (
        (("build",), 'building FMUs needs ziglang, pythonfmu; pip install "drillstring-cosim[build]" brings all of it'),
        (("run", "stick-slip", "--packaging", "python"), "`cosim build --packaging python` makes"),
    ):
        done = run(environment, "cosim", *arguments, cwd=project)
        assert done.returncode == 2
        assert sentence in " ".join(done.stderr.split())
        assert "Traceback" not in done.stderr
