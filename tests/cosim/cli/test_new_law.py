"""A new law: under 30 lines that build, check and run by the commands that are printed, and nothing else touched."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu
from typer.testing import CliRunner

from cosim.cli.app import app

ROOT = Path(__file__).parents[3]
runner = CliRunner()


def said(*arguments: str) -> str:
    """Run the command in this process, which must refuse it, and return what it says."""
    done = runner.invoke(app, ["new-law", *arguments])
    assert done.exit_code == 2, done.output
    return " ".join(done.stderr.split())


def everything(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*")}


def test_it_writes_a_law_of_under_30_lines_and_a_scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = runner.invoke(app, ["new-law", "MyLaw"])
    assert done.exit_code == 0, done.output
    assert everything(tmp_path) == {"MyLaw", "MyLaw/MyLaw.py", "MyLaw/MyLaw.toml"}
    lines = (tmp_path / "MyLaw" / "MyLaw.py").read_text(encoding="utf-8").splitlines()
    assert len(lines) < 30
    assert max(map(len, lines)) <= 120
    assert "@" not in "".join(lines)


@pytest.mark.slow
def test_the_printed_commands_build_check_and_run_it(tmp_path: Path) -> None:
    environment = os.environ | {"COLUMNS": "200", "NO_COLOR": "1"}

    def cosim(*arguments: str) -> str:
        command = [sys.executable, "-m", "cosim", *arguments]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    # a folder with a blank in its name, so that the commands have to be quoted
    printed = cosim("new-law", "MyLaw", "my laws").splitlines()
    commands = [shlex.split(line)[1:] for line in printed if line.startswith("  cosim ")]
    assert [command[0] for command in commands] == ["build", "check", "run"]
    answers = [cosim(*command) for command in commands]
    assert "PASSED" in answers[1]
    assert validate_fmu(str(tmp_path / "my laws" / "MyLaw.fmu")) == []
    assert {name.split("/")[0] for name in everything(tmp_path)} == {"my laws", "runs"}
    assert everything(tmp_path / "my laws") == {"MyLaw.fmu", "MyLaw.py", "MyLaw.toml"}
    manifest = json.loads((tmp_path / "runs" / "MyLaw" / "manifest.json").read_text(encoding="utf-8"))
    on, off = (variant["measures"] for variant in manifest["variants"])
    # in equilibrium at 10 rad/s, tests/laws/test_soft_torque.py has the bit at 6.205 rad/s
    assert on["ssi"] < 1e-3
    assert on["mean_speed"] == pytest.approx(6.2052, abs=0.005)
    assert off["ssi"] > 1.0


@pytest.mark.slow
def test_an_installed_package_builds_the_same_bytes(tmp_path: Path) -> None:
    """The packages as a wheel lays them out, without a checkout and with somebody else's `models` beside it."""
    skip = shutil.ignore_patterns("__pycache__", "built")
    site = shutil.copytree(ROOT / "cosim", tmp_path / "site" / "cosim", ignore=skip)
    for name in ("models", "fmu_src"):
        shutil.copytree(ROOT / name, site / name, ignore=skip)
    assert runner.invoke(app, ["new-law", "MyLaw", str(tmp_path / "work")]).exit_code == 0
    (tmp_path / "work" / "models.py").write_text("raise SystemExit('not ours')\n", encoding="utf-8")
    shutil.copytree(tmp_path / "work", tmp_path / "checkout")
    installed = [sys.executable, "-m", "cosim", "build"], {"PYTHONPATH": str(tmp_path / "site")}
    for folder, (command, more) in (("work", installed), ("checkout", ([sys.executable, ROOT / "build_fmu.py"], {}))):
        command, place, environment = [*command, "MyLaw.py"], tmp_path / folder, os.environ | more
        done = subprocess.run(command, cwd=place, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "work" / "MyLaw.fmu").read_bytes() == (tmp_path / "checkout" / "MyLaw.fmu").read_bytes()
    names = {variable.name for variable in fmpy.read_model_description(tmp_path / "work" / "MyLaw.fmu").modelVariables}
    assert {"top_speed", "top_torque", "speed_ref", "enabled", "Omega", "limit_active", "Z", "c_a"} <= names


@pytest.mark.parametrize("name", ["1st", "my law", "my.law", "../law", "class", "MODEL", "CON", "ω", "x" * 65, ""])
def test_a_name_that_does_not_do_is_refused(name: str, tmp_path: Path) -> None:
    assert f"'{name}' is no name for a law; expected at most 64 letters" in said(name, str(tmp_path / "law"))
    assert everything(tmp_path) == set()


def test_the_name_of_an_fmu_is_refused(tmp_path: Path) -> None:
    assert "there is an FMU softtorque already; expected another name" in said("softtorque", str(tmp_path / "law"))


def test_what_is_there_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("mine", encoding="utf-8")
    for folder in (tmp_path, tmp_path / "mine"):
        assert f"{folder} is there already; expected a folder that is new or empty" in said("MyLaw", str(folder))
    assert "cannot be written" in said("MyLaw", str(tmp_path / "mine" / "below"))
    assert everything(tmp_path) == {"mine"}
    assert (tmp_path / "mine").read_text(encoding="utf-8") == "mine"
