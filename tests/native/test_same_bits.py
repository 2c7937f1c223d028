"""The libraries for Windows and for Arm give the bits of the one for Linux on x86-64.

A program in C walks the same calls through each library, loaded as an importer loads it, under wine and under
qemu-user; every number that comes out is written down by its bits. The libraries for macOS cannot be run here.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from fmu_src.build.native import host_target
from fmu_src.fmus import MODELS
from tests.native.programs import PACKAGES, SEED, MissingToolError, compile_loaded, find, library, run, target_named

pytestmark = [pytest.mark.cross_build, pytest.mark.emulator]

REFERENCE = "linux64"
OTHERS = ("win64", "aarch64-linux")
CALLS = 20_000
Starter = Callable[[str], list[str]]


@pytest.fixture(scope="module")
def wine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[str]]:
    """The start of a command that runs a Windows program, without a display, with a home of its own."""
    debian = "/usr/lib/wine/wine64"  # where the package wine64 alone puts it
    program = debian if Path(debian).is_file() else find("wine64")
    home = tmp_path_factory.mktemp("wine")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("WINEPREFIX", str(home))
        patch.setenv("WINEDEBUG", "-all")
        patch.delenv("DISPLAY", raising=False)
        yield [program]
        server = shutil.which("wineserver") or str(Path(program).with_name("wineserver"))
        subprocess.run([server, "-k", "-w"], check=False)


@pytest.fixture(scope="module")
def qemu() -> list[str]:
    """The start of a command that runs a program for Arm."""
    program = find("qemu-aarch64")
    root = Path("/usr/aarch64-linux-gnu")
    if not (root / "lib" / "ld-linux-aarch64.so.1").is_file():
        raise MissingToolError(f"a C library for Arm is missing: apt-get install {PACKAGES['qemu-aarch64']}")
    return [program, "-L", str(root)]


@pytest.fixture
def starter(request: pytest.FixtureRequest) -> Starter:
    """Return how a program for a platform is started on this machine."""
    if host_target().folder != REFERENCE:
        pytest.skip("the platforms are compared on Linux on x86-64")
    emulators = {"win64": "wine", "aarch64-linux": "qemu"}

    def start(folder: str) -> list[str]:
        return [] if folder == REFERENCE else request.getfixturevalue(emulators[folder])

    return start


def drive(start: list[str], model: str, folder: str, place: Path, *mode: object) -> str:
    target = target_named(folder)
    command = [*start, compile_loaded(model, target), *mode, os.path.relpath(library(model, target), place)]
    return run(command, place)


def walks(start: list[str], model: str, folder: str, place: Path) -> list[str]:
    drive(start, model, folder, place, "walks", f"{folder}.txt")
    return (place / f"{folder}.txt").read_text().splitlines()


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("folder", OTHERS)
def test_walks_give_the_same_bits(model: str, folder: str, starter: Starter, tmp_path: Path) -> None:
    expected = walks([], model, REFERENCE, tmp_path)
    found = walks(starter(folder), model, folder, tmp_path)
    assert len(expected) > 5000
    differences = [i for i, pair in enumerate(zip(expected, found, strict=True)) if pair[0] != pair[1]]
    assert not differences, (
        f"line {differences[0] + 1} of {tmp_path}/{folder}.txt and {REFERENCE}.txt is the first to differ"
    )


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("folder", OTHERS)
def test_random_calls_give_the_same_bits(model: str, folder: str, starter: Starter, tmp_path: Path) -> None:
    expected = drive([], model, REFERENCE, tmp_path, "random", SEED, CALLS)
    assert int(re.findall(r"^(\d+) calls$", expected, re.MULTILINE)[-1]) >= CALLS
    assert drive(starter(folder), model, folder, tmp_path, "random", SEED, CALLS).splitlines() == expected.splitlines()
