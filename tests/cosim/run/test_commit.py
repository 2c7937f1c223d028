"""The commit in a manifest is of this project, or there is none."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from cosim.provenance import commit


def git(folder: Path, *arguments: str) -> str:
    identity = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"]
    command = ["git", "-C", str(folder), *identity, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def repository(folder: Path, project: str) -> Path:
    """Make a repository with one commit and a package folder; return that folder."""
    (folder / "cosim").mkdir(parents=True)
    (folder / "cosim" / "__init__.py").touch()
    (folder / "pyproject.toml").write_text(f'[project]\nname = "{project}"\n')
    git(folder, "init", "-q")
    git(folder, "add", ".")
    git(folder, "commit", "-q", "-m", "begin")
    git(folder, "tag", "v1")
    return folder / "cosim"


def test_a_checkout_tells_its_commit_and_whether_it_was_changed(tmp_path: Path) -> None:
    package = repository(tmp_path / "own", "drillstring-cosim")
    head = git(package, "rev-parse", "HEAD")
    assert commit(package) == head
    (package / "__init__.py").write_text("changed = True\n")
    commit.cache_clear()
    assert commit(package) == f"{head}-dirty"


def test_a_repository_of_the_environment_is_not_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = repository(tmp_path / "own", "drillstring-cosim")
    other = repository(tmp_path / "other", "else")
    git(other, "commit", "-q", "--allow-empty", "-m", "go on")
    head = git(package, "rev-parse", "HEAD")
    monkeypatch.setenv("GIT_DIR", str(other.parent / ".git"))
    assert commit(package) == head


@pytest.mark.parametrize("within", ["", ".venv/lib/site-packages"])
def test_the_commit_of_a_project_that_uses_this_one_is_not_told(within: str, tmp_path: Path) -> None:
    repository(tmp_path / "users", "users-own")
    package = tmp_path / "users" / within / "cosim"
    package.mkdir(parents=True, exist_ok=True)
    assert commit(package) is None


def test_a_wheel_tells_the_commit_it_was_built_from(tmp_path: Path) -> None:
    (tmp_path / "cosim" / "built").mkdir(parents=True)
    (tmp_path / "cosim" / "built" / "commit.txt").write_text("0123abcd\n")
    assert commit(tmp_path / "cosim") == "0123abcd"


def test_without_git_or_a_commit_there_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = repository(tmp_path / "own", "drillstring-cosim")
    git(package.parent, "update-ref", "-d", "HEAD")
    assert commit(package) is None
    commit.cache_clear()
    monkeypatch.setenv("PATH", str(tmp_path))
    assert commit(package) is None
