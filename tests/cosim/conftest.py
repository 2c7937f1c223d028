from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import fmpy
import pytest

from cosim.fmu.library import _FOLDERS

SOURCE = Path(__file__).parent / "probe"


@pytest.fixture(scope="session")
def probe_library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The probe FMU's shared library, compiled for this machine."""
    library = tmp_path_factory.mktemp("probe") / f"probe{fmpy.sharedLibraryExtension}"
    headers = Path(fmpy.__file__).parent / "c-code"
    flags = ["-shared", "-O1", "-w", "-I", str(headers), "-o", str(library)]
    flags += [] if sys.platform == "win32" else ["-fPIC"]
    subprocess.run([sys.executable, "-m", "ziglang", "cc", *flags, str(SOURCE / "probe.c")], check=True)
    return library


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
            folder = folder or _FOLDERS[fmpy.platform_tuple][0]
            archive.write(probe_library, f"binaries/{folder}/{probe_library.name}")
        return path

    return make


@pytest.fixture
def probe(make_probe: Callable[..., Path]) -> Path:
    return make_probe()


@pytest.fixture(scope="session")
def suspect_libraries(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Compile the suspect FMU's shared library for this machine, once for each set of definitions."""
    folder = tmp_path_factory.mktemp("suspect")

    @cache
    def compiled(*definitions: str) -> Path:
        library = folder / "-".join(("suspect", *definitions)) / f"suspect{fmpy.sharedLibraryExtension}"
        library.parent.mkdir()
        headers = Path(fmpy.__file__).parent / "c-code"
        flags = ["-shared", "-O1", "-I", str(headers), *(f"-D{name}" for name in definitions), "-o", str(library)]
        flags += [] if sys.platform == "win32" else ["-fPIC", "-lm"]
        source = Path(__file__).parent / "suspect" / "suspect.c"
        subprocess.run([sys.executable, "-m", "ziglang", "cc", *flags, str(source)], check=True)
        return library

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
            f"binaries/{folder or _FOLDERS[fmpy.platform_tuple][0]}/{library.name}": library.read_bytes(),
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
    """Unpack into a folder of its own, and fail if anything is left there."""
    folder = tmp_path_factory.mktemp("unpacked")
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    yield folder
    left = [path.name for path in folder.iterdir()]
    shutil.rmtree(folder)
    assert left == []
