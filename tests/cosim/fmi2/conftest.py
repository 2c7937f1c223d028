from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
import pytest

from cosim.fmi2.library import BINARY_FOLDERS
from tests.cosim.conftest import compile_shared
from tests.once import built_once

SOURCE = Path(__file__).parent / "misdeeds"


@pytest.fixture(scope="session")
def misdeeds(run_folder: Path) -> Path:
    """The FMU of misdeeds, compiled and packed once for a run of the tests."""

    def build(folder: Path) -> None:
        library = folder / f"misdeeds{fmpy.sharedLibraryExtension}"
        compile_shared(SOURCE / "misdeeds.c", library, "-w")
        with zipfile.ZipFile(folder / "misdeeds.fmu", "w") as archive:
            archive.write(SOURCE / "modelDescription.xml", "modelDescription.xml")
            archive.write(library, f"binaries/{BINARY_FOLDERS[fmpy.platform_tuple][0]}/{library.name}")

    return built_once(run_folder / "misdeeds", build) / "misdeeds.fmu"
