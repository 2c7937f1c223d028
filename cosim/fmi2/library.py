"""Load the shared library of an .fmu file, and bind the functions that each step calls.

The library is that of the right folder for this platform, for whose processor and system it must be by its first bytes;
it is unpacked into a folder of this process, and unloaded.
"""

from __future__ import annotations

import os
import struct
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy  # pyright: ignore[reportMissingTypeStubs]
from fmpy.fmi2 import FMU2Slave  # pyright: ignore[reportMissingTypeStubs]

from cosim.errors import FmuFileError
from cosim.fmi2.archive import Archive, open_archive
from cosim.fmi2.unpacked import UnpackedFmus
from cosim.system.description import Description

# FMI 2.0 names folders for x86 only. For Arm, tools use FMI 3.0's names, or put a universal binary in darwin64. fmpy
# 0.3.32 looks in linux64 on Arm as well, so it is told which file to load.
BINARY_FOLDERS = {
    "x86_64-linux": ("linux64", "x86_64-linux"),
    "aarch64-linux": ("aarch64-linux",),
    "x86_64-windows": ("win64", "x86_64-windows"),
    "x86-windows": ("win32", "x86-windows"),
    "x86-linux": ("linux32", "x86-linux"),
    "x86_64-darwin": ("darwin64", "x86_64-darwin"),
    "aarch64-darwin": ("aarch64-darwin", "darwin64"),
}


UNPACKED = UnpackedFmus()
"""Of this process."""


@contextmanager
def loaded_fmu(name: str, path: Path, description: Description) -> Generator[Any]:
    """Unpack an FMU into a folder, where none waits, and load its library; unload it afterwards, whatever happens.

    Parameters
    ----------
    name : str
        Name for the instance.
    path : Path
        The .fmu file.
    description : Description
        What `cosim.fmi2.model_description.read_description` read from it.

    Yields
    ------
    fmpy.fmi2.FMU2Slave
        Loaded, not instantiated.

    Raises
    ------
    FmuFileError
        If the file cannot be unpacked, there is no binary for this platform or it cannot be loaded.
    """

    def unpack(folder: Path) -> Path:
        with open_archive(path) as archive:
            binary = find_binary(archive, description.model_identifier)
            archive.unpack(folder)
        library = folder / binary
        _refuse_foreign(path, library)
        if sys.platform != "win32":
            library.chmod(0o755)
        return library

    with UNPACKED.lent(path, unpack) as (folder, library):
        fmu = _load(name, path, library, description, str(folder))
        try:
            yield fmu
        finally:
            fmu.freeLibrary()


def find_binary(archive: Archive, model_identifier: str) -> str:
    """Return the name within an open archive of the library for this platform.

    Raises
    ------
    FmuFileError
        If there is none.
    """
    names = archive.names
    file = model_identifier + fmpy.sharedLibraryExtension
    for folder in BINARY_FOLDERS.get(fmpy.platform_tuple, (fmpy.platform_tuple,)):
        if f"binaries/{folder}/{file}" in names:
            return f"binaries/{folder}/{file}"
    parts = [name.split("/") for name in names]
    platforms = sorted({part[1] for part in parts if len(part) > 2 and part[0] == "binaries" and part[-1]})
    has = ", ".join(platforms) or "none"
    raise FmuFileError(f"{archive.path}: there is no {file} for {fmpy.platform_tuple} in it; it has binaries for {has}")


def _refuse_foreign(path: Path, binary: Path) -> None:
    """Refuse what is no library, or one of another platform, which the system's loader tells less plainly."""
    try:
        content = binary.read_bytes()
    except OSError as error:
        raise FmuFileError(f"{path}: {binary.name} cannot be read: {error.strerror or error}") from error
    platforms, expected = built_for(content), expected_for(fmpy.platform_tuple)
    if expected and not platforms & expected:
        found = f"is a library for {', '.join(sorted(platforms))}" if platforms else "is no library"
        raise FmuFileError(f"{path}: {binary.name} {found}; expected one for {fmpy.platform_tuple}")
    if is_cut_off(content):
        raise FmuFileError(f"{path}: {binary.name} is cut off after {len(content)} bytes")


def _load(name: str, path: Path, binary: Path, description: Description, folder: str) -> Any:
    """Load the library; fmpy changes the working directory while it does, and leaves it so on failure."""
    before = os.getcwd()
    try:
        return FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.model_identifier,
            unzipDirectory=folder,
            instanceName=name,
            libraryPath=str(binary),
        )
    except Exception as error:  # fmpy raises bare Exception when loading fails, ctypes AttributeError for a function
        raise FmuFileError(f"{path}: {binary.name} cannot be loaded: {error}") from error
    finally:
        os.chdir(before)


_TUPLES = {
    "linux32": "x86-linux",
    "linux64": "x86_64-linux",
    "win32": "x86-windows",
    "win64": "x86_64-windows",
    "darwin64": "x86_64-darwin",
}
"""FMI 2.0's names; those of FMI 3.0, which tools use for Arm, are what they say."""

_ELF = {0x03: "x86-linux", 0x3E: "x86_64-linux", 0xB7: "aarch64-linux", 0x28: "aarch32-linux", 0xF3: "riscv64-linux"}
_PE = {0x14C: "x86-windows", 0x8664: "x86_64-windows", 0xAA64: "aarch64-windows"}
_MACH = {0x01000007: "x86_64-darwin", 0x0100000C: "aarch64-darwin", 7: "x86-darwin"}


def expected_for(folder: str) -> set[str]:
    """Return the platform that a folder below binaries stands for; empty if the name is unknown."""
    name = _TUPLES.get(folder, folder)
    return {name} if name in {*_ELF.values(), *_PE.values(), *_MACH.values()} else set()


def built_for(library: bytes) -> set[str]:
    """Return the platforms a library can be loaded on, by its header; empty if it is none that is known.

    ELF (e_machine), PE (Machine) and Mach-O (cputype), and universal Mach-O with several of them.
    """
    try:
        if library[:4] == b"\x7fELF":
            return _known(_ELF, struct.unpack_from("<H", library, 18)[0])
        if library[:2] == b"MZ":
            start = struct.unpack_from("<I", library, 60)[0]
            return _known(_PE, struct.unpack_from("<H", library, start + 4)[0])
        if library[:4] == b"\xcf\xfa\xed\xfe":
            return _known(_MACH, struct.unpack_from("<I", library, 4)[0])
        if library[:4] == b"\xca\xfe\xba\xbe":
            count = struct.unpack_from(">I", library, 4)[0]
            parts = (struct.unpack_from(">I", library, 8 + 20 * index)[0] for index in range(count))
            return set[str]().union(*(_known(_MACH, part) for part in parts))
    except struct.error:
        return set()
    return set()


def is_cut_off(library: bytes) -> bool:
    """Tell whether an ELF file ends before its segments do, which kills a process that loads it (by SIGBUS).

    Other formats are checked by the loaders of their systems. Layout by the System V ABI, chapter "Program Header".
    """
    if library[:4] != b"\x7fELF":
        return False
    header, segment = ("<32xQ14xHH", "<8xQ16xQ") if library[4:5] == b"\x02" else ("<28xI10xHH", "<4xI8xI")
    try:
        table, size, count = struct.unpack_from(header, library)
        segments = [struct.unpack_from(segment, library, table + index * size) for index in range(count)]
    except struct.error:
        return True
    return any(begin + length > len(library) for begin, length in segments)


def _known(machines: dict[int, str], number: int) -> set[str]:
    return {machines[number]} if number in machines else {f"machine 0x{number:x}"}
