from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest

from cosim.fmi2.library import BINARY_FOLDERS, UNPACKED
from tests.once import built_once

SOURCE = Path(__file__).parent / "probe"


def compile_shared(source: Path, library: Path, *flags: str) -> None:
    """Compile a shared library for this machine against the headers of FMI."""
    flags = ("-shared", "-O1", "-I", str(Path(fmpy.__file__).parent / "c-code"), *flags)
    flags += () if sys.platform == "win32" else ("-fPIC", "-lm")
    command = [sys.executable, "-m", "ziglang", "cc", *flags, "-o", str(library), str(source)]
    subprocess.run(command, check=True)


@pytest.fixture(scope="session")
def probe_library(run_folder: Path) -> Path:
    """The probe FMU's shared library, compiled for this machine."""
    name = f"probe{fmpy.sharedLibraryExtension}"
    return built_once(run_folder / "probe", lambda to: compile_shared(SOURCE / "probe.c", to / name, "-w")) / name


@pytest.fixture
def make_probe(probe_library: Path, tmp_path: Path) -> Callable[..., Path]:
    """Pack a probe FMU, with replacements in its model description."""

    def make(name: str = "probe.fmu", folder: str | None = None, replace: dict[str, str] | None = None) -> Path:
        text = (SOURCE / "modelDescription.xml").read_text()
        for old, new in (replace or {}).items():
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / name
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("modelDescription.xml", text)
            folder = folder or BINARY_FOLDERS[fmpy.platform_tuple][0]
            archive.write(probe_library, f"binaries/{folder}/{probe_library.name}")
        return path

    return make


@pytest.fixture
def probe(make_probe: Callable[..., Path]) -> Path:
    return make_probe()


@pytest.fixture(scope="session")
def suspect_libraries(run_folder: Path) -> Callable[..., Path]:
    """Compile the suspect FMU's shared library for this machine, once for each set of definitions."""
    source = Path(__file__).parent / "suspect" / "suspect.c"
    name = f"suspect{fmpy.sharedLibraryExtension}"

    def compiled(*definitions: str) -> Path:
        flags = [f"-D{definition}" for definition in definitions]
        folder = run_folder / "-".join(("suspect", *definitions))
        return built_once(folder, lambda to: compile_shared(source, to / name, *flags)) / name

    return compiled


@pytest.fixture
def make_suspect(suspect_libraries: Callable[..., Path], tmp_path: Path) -> Callable[..., Path]:
    """Pack a suspect FMU with a fault, replacements in its model description, and other files."""

    def make(
        fault: str = "",
        replace: dict[str, str] | None = None,
        files: dict[str, bytes] | None = None,
        definitions: tuple[str, ...] = (),
        folder: str | None = None,
    ) -> Path:
        text = (Path(__file__).parent / "suspect" / "modelDescription.xml").read_text()
        for old, new in (replace or {}).items():
            assert old in text
            text = text.replace(old, new)
        library = suspect_libraries(*definitions)
        content = {
            "modelDescription.xml": text.encode(),
            f"binaries/{folder or BINARY_FOLDERS[fmpy.platform_tuple][0]}/{library.name}": library.read_bytes(),
            "resources/fault.txt": fault.encode(),
            "documentation/index.html": b"<p>A suspect</p>",
        }
        path = tmp_path / "suspect.fmu"
        with zipfile.ZipFile(path, "w") as archive:
            for name, data in (content | (files or {})).items():
                archive.writestr(name, data)
        return path

    return make


@pytest.fixture
def no_leftovers(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch):
    """Unpack into a folder of its own, and fail if anything is left there but what is kept to be lent again."""
    folder = tmp_path_factory.mktemp("unpacked")
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    UNPACKED.clear()
    yield folder
    UNPACKED.clear()
    left = [path.name for path in folder.iterdir()]
    shutil.rmtree(folder)
    assert left == []
