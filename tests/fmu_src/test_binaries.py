"""The libraries for five platforms in every native FMU of dist/, read without being run."""

from __future__ import annotations

import hashlib
import re
import struct
import zipfile
from itertools import product
from pathlib import Path

import lief
import pytest

from fmu_src.build.native import FMI_HEADERS
from fmu_src.fmus import MODELS

pytestmark = pytest.mark.cross_build

NATIVE = Path(__file__).parents[2] / "dist" / "native"
ELF = {"linux64": lief.ELF.ARCH.X86_64, "aarch64-linux": lief.ELF.ARCH.AARCH64}
X86_64, ARM64 = lief.MachO.Header.CPU_TYPE.X86_64, lief.MachO.Header.CPU_TYPE.ARM64
MACH_O = {"darwin64": [X86_64, ARM64], "aarch64-darwin": [ARM64]}
EXTENSIONS = dict.fromkeys(ELF, "so") | {"win64": "dll"} | dict.fromkeys(MACH_O, "dylib")

# FMI 2.0.4, section 2.3: a co-simulation FMU has all functions of its kind, even those it has no use for.
_COMMON, _, _CO_SIMULATION = re.split(
    r"Functions for FMI2 for (?:Model Exchange|Co-Simulation)",
    (FMI_HEADERS / "fmi2Functions.h").read_text().split("/* Version number */")[1],
)
FUNCTIONS = sorted(re.findall(r"FMI2_Export\s+\w+\s+(\w+);", _COMMON + _CO_SIMULATION))


def read(model: str, folder: str) -> bytes:
    with zipfile.ZipFile(NATIVE / f"{model}.fmu") as archive:
        name = f"binaries/{folder}/{model}.{EXTENSIONS[folder]}"
        assert name in archive.namelist(), "dist/ holds FMUs for this platform only; build with --platform all"
        return archive.read(name)


def test_there_are_thirty_four_functions_to_export() -> None:
    assert len(FUNCTIONS) == 34


@pytest.mark.parametrize("name", MODELS)
def test_every_platform_has_its_library_and_nothing_else(name: str) -> None:
    with zipfile.ZipFile(NATIVE / f"{name}.fmu") as archive:
        found = [member for member in archive.namelist() if member.startswith("binaries/")]
    assert sorted(found) == sorted(f"binaries/{folder}/{name}.{extension}" for folder, extension in EXTENSIONS.items())


@pytest.mark.parametrize(("name", "folder"), list(product(MODELS, ELF)))
def test_linux_libraries_need_nothing_newer_than_glibc_2_17(name: str, folder: str) -> None:
    library = lief.ELF.parse(list(read(name, folder)))
    assert library is not None
    assert (library.header.machine_type, library.header.file_type) == (ELF[folder], lief.ELF.Header.FILE_TYPE.DYN)
    assert sorted(str(symbol.name) for symbol in library.exported_functions) == FUNCTIONS
    assert set(library.libraries) <= {"libc.so.6", "libm.so.6"}
    needed = {str(a.name) for r in library.symbols_version_requirement for a in r.get_auxiliary_symbols()}
    assert needed
    assert all(tuple(map(int, version.removeprefix("GLIBC_").split("."))) <= (2, 17) for version in needed)


@pytest.mark.parametrize("name", MODELS)
def test_the_windows_library_needs_only_what_is_part_of_windows(name: str) -> None:
    library = lief.PE.parse(list(read(name, "win64")))
    assert library is not None
    assert library.header.machine == lief.PE.Header.MACHINE_TYPES.AMD64
    assert library.header.has_characteristic(lief.PE.Header.CHARACTERISTICS.DLL)
    exports = library.get_export()
    assert exports is not None
    assert sorted(str(entry.name) for entry in exports.entries) == FUNCTIONS
    needed = {str(entry.name).lower() for entry in library.imports}
    # the universal C runtime has been part of Windows since Windows 10
    assert {dll for dll in needed if not dll.startswith("api-ms-win-crt-")} == {"kernel32.dll"}


@pytest.mark.parametrize(("name", "folder"), list(product(MODELS, MACH_O)))
def test_macos_libraries_run_on_big_sur_and_need_only_the_system(name: str, folder: str) -> None:
    content = read(name, folder)
    libraries = lief.MachO.parse(list(content))
    assert libraries is not None
    slices = [libraries.at(i) for i in range(libraries.size)]
    assert [part.header.cpu_type for part in slices] == MACH_O[folder]
    for part in slices:
        assert part.header.file_type == lief.MachO.Header.FILE_TYPE.DYLIB
        assert list(part.build_version.minos) == [11, 0, 0]
        assert [str(library.name) for library in part.libraries] == [
            f"@rpath/{name}.dylib",
            "/usr/lib/libSystem.B.dylib",
        ]
        own = {"__mh_dylib_header", "___dso_handle"}  # the linker's
        assert sorted(str(s.name)[1:] for s in part.exported_symbols if s.name not in own) == FUNCTIONS
        if part.header.cpu_type == ARM64:
            assert_signed(part, content[part.fat_offset :])


def assert_signed(library: lief.MachO.Binary, content: bytes) -> None:
    """Check the hashes of the ad-hoc signature, without which Apple silicon does not load a library.

    The code directory is that of Apple's xnu, osfmk/kern/cs_blobs.h: big-endian, the hashes of pages last.
    """
    signature = content[library.code_signature.data_offset :]
    magic, _, _, _, start = struct.unpack_from(">IIIII", signature)
    directory = signature[start:]
    (hashes,) = struct.unpack_from(">I", directory, 16)
    pages, end = struct.unpack_from(">II", directory, 28)
    size, _, _, shift = struct.unpack_from("BBBB", directory, 36)
    assert (magic, end, size) == (0xFADE0CC0, library.code_signature.data_offset, 32)
    assert pages == -(-end // (1 << shift))
    for page in range(pages):
        part = content[page << shift : min((page + 1) << shift, end)]
        kept = directory[hashes + page * size : hashes + (page + 1) * size]
        assert hashlib.sha256(part).digest() == kept, f"page {page} has changed since it was signed"
