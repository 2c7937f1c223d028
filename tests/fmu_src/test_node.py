"""What Node.js is asked for, and what is said where it lacks or fails."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from fmu_src.errors import BuildError
from fmu_src.node import install_packages, run_node

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the program that stands for npm is a script")


@pytest.fixture
def npm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A program in the place of npm, which notes what it is told; it fails where there is no lock."""
    program = tmp_path / "bin" / "npm"
    program.parent.mkdir()
    program.write_text(
        "#!/bin/sh\n"
        'if [ ! -e package-lock.json ]; then echo "no lock" >&2; echo "and so on"; exit 3; fi\n'
        'mkdir -p node_modules; echo "$@" >> told\n'
    )
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}:/usr/bin:/bin")
    return tmp_path


def test_packages_are_installed_when_the_lock_has_changed(npm: Path) -> None:
    (npm / "package-lock.json").write_text("{}")
    for _ in range(2):
        assert install_packages(npm, "the site") == npm / "node_modules"
    assert (npm / "told").read_text() == "ci --ignore-scripts --no-audit --no-fund\n"
    (npm / "package-lock.json").write_text("{ }")
    install_packages(npm, "the site")
    assert (npm / "told").read_text().count("ci ") == 2


def test_what_fails_is_told_with_what_it_has_said(npm: Path) -> None:
    with pytest.raises(BuildError) as failed:
        install_packages(npm, "the site")
    assert str(failed.value) == "the site cannot be built: npm ci ended with 3:\nno lock\nand so on"
    assert not (npm / "node_modules").exists()


def test_what_lacks_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(BuildError) as missing:
        run_node("node", "build.mjs", folder=tmp_path, needed_by="the console")
    assert str(missing.value) == ("the console needs node, which is missing; install Node.js 18 or later with npm")
