"""Requirements are complete: what a pinned distribution asks for is pinned, with the extras it is asked for with.

pip before 24 takes an extra that is not pinned as a requirement of its own, finds a newer version and no hash for it.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = {
    "run": ("build",),
    "test": ("build", "theory", "stream", "dask", "sensitivity", "container", "test"),
    "bench": ("bench",),
    "docs": ("docs", "theory"),
}


def pins(text: str) -> dict[str, Requirement]:
    """Return what a requirements file pins for this machine, by name."""
    lines = (line.removesuffix("\\").strip() for line in text.splitlines())
    found = [Requirement(line) for line in lines if line and not line.startswith(("#", "--hash"))]
    return {canonicalize_name(pin.name): pin for pin in found if pin.marker is None or pin.marker.evaluate()}


def asked(requirements: list[str], extras: set[str]) -> Iterator[Requirement]:
    """Yield the requirements that hold on this machine for a set of extras."""
    for requirement in map(Requirement, requirements):
        marker = requirement.marker
        if marker is None or any(marker.evaluate({"extra": extra}) for extra in extras | {""}):
            yield requirement


def lacking(pinned: dict[str, Requirement], requirements: list[str], extras: set[str]) -> list[str]:
    """Return those of the requirements that the pins do not fulfil."""
    return [
        str(requirement)
        for requirement in asked(requirements, extras)
        if (pin := pinned.get(canonicalize_name(requirement.name))) is None
        or not requirement.extras <= pin.extras
        or not requirement.specifier.contains(next(iter(pin.specifier)).version)
    ]


def gaps(pinned: dict[str, Requirement]) -> dict[str, list[str]]:
    """Return what is not pinned of what pinned and installed distributions ask for."""
    installed = {canonicalize_name(each.name): each for each in metadata.distributions()}
    found = {
        name: lacking(pinned, installed[name].requires or [], set(pin.extras))
        for name, pin in pinned.items()
        if name in installed
    }
    return {name: missing for name, missing in found.items() if missing}


@pytest.mark.parametrize("name", EXTRAS)
def test_all_that_the_project_asks_for_is_pinned(name: str) -> None:
    pinned = pins((ROOT / "requirements" / f"{name}.txt").read_text(encoding="utf-8"))
    wanted = [
        *PROJECT["dependencies"],
        *(line for extra in EXTRAS[name] for line in PROJECT["optional-dependencies"][extra]),
    ]
    assert lacking(pinned, wanted, set()) == []


@pytest.mark.parametrize("name", EXTRAS)
def test_all_that_pinned_distributions_ask_for_is_pinned(name: str) -> None:
    pinned = pins((ROOT / "requirements" / f"{name}.txt").read_text(encoding="utf-8"))
    assert gaps(pinned) == {}


@pytest.mark.parametrize("name", ["run", "test"])
def test_what_is_pinned_is_installed_here(name: str) -> None:
    pinned = pins((ROOT / "requirements" / f"{name}.txt").read_text(encoding="utf-8"))
    versions = {canonicalize_name(each.name): each.version for each in metadata.distributions()}
    assert {key: versions.get(key) for key in pinned} == {
        key: next(iter(pin.specifier)).version for key, pin in pinned.items()
    }


def test_an_extra_that_is_not_pinned_is_found() -> None:
    text = (ROOT / "requirements" / "test.txt").read_text(encoding="utf-8")
    assert "\ncoverage[toml]==" in text
    assert gaps(pins(text.replace("\ncoverage[toml]==", "\ncoverage=="))).keys() == {"pytest-cov"}


@pytest.mark.parametrize("name", ["test", "bench", "docs"])
def test_files_pin_the_same_versions(name: str) -> None:
    run, other = (pins((ROOT / "requirements" / f"{each}.txt").read_text(encoding="utf-8")) for each in ("run", name))
    assert {key: str(other[key].specifier) for key in run.keys() & other.keys()} == {
        key: str(run[key].specifier) for key in run.keys() & other.keys()
    }


@pytest.mark.parametrize("name", EXTRAS)
def test_every_pin_has_hashes_and_names_no_index(name: str) -> None:
    text = (ROOT / "requirements" / f"{name}.txt").read_text(encoding="utf-8")
    assert "://" not in text
    entries = text.replace("\\\n", " ").splitlines()
    assert all("--hash=sha256:" in entry for entry in entries if "==" in entry)
