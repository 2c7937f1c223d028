"""The .fmu file itself: a sound archive, the libraries, declared sources, documentation (FMI 2.0.4, section 2.3)."""

from __future__ import annotations

from pathlib import Path

import fmpy  # pyright: ignore[reportMissingTypeStubs]

from cosim.check.verdict import Outcome, failed, not_checked, noted, passed
from cosim.check.wording import counted
from cosim.errors import FmuFileError
from cosim.fmi2.archive import open_archive
from cosim.fmi2.library import find_binary
from cosim.fmi2.platforms import built_for, expected_for
from cosim.system.description import Description

_LIBRARIES = (".so", ".dll", ".dylib")


def check_archive(path: Path, folder: Path) -> Outcome:
    """Unpack an FMU, if it is an archive that every importer can unpack.

    Parameters
    ----------
    path : Path
        The .fmu file.
    folder : Path
        Existing and empty; left incomplete if the archive fails.
    """
    allowed = "sound, complete"
    try:
        with open_archive(path) as archive:
            archive.unpack(folder)
    except FmuFileError as error:
        return failed(str(error).replace(f"{path} ", "it ", 1).removeprefix(f"{path}: "), allowed)
    files = [file for file in folder.rglob("*") if file.is_file()]
    if folder / "modelDescription.xml" not in files:
        return failed("there is no modelDescription.xml at its root", allowed)
    size = sum(file.stat().st_size for file in files)
    return passed(f"{counted(len(files), 'file')}, {size / 1e6:.2f} MB unpacked", allowed)


def check_binaries(path: Path, folder: Path, description: Description) -> Outcome:
    """Check that there is a library for this machine, and that each is for the platform its folder says.

    Parameters
    ----------
    path, folder : Path
        The .fmu file, and where it is unpacked.
    description : Description
        Of the FMU.
    """
    libraries = {
        file.parent.name: file
        for file in sorted(folder.glob("binaries/*/*"))
        if file.suffix in _LIBRARIES and file.stem == description.model_identifier
    }
    built = {place: built_for(file.read_bytes()) for place, file in libraries.items()}
    listed = ", ".join(libraries) or "none"
    wrong = [
        f"{place} holds {_what(found)}"
        for place, found in built.items()
        if (expected := expected_for(place)) and not found & expected
    ]
    if wrong:
        return failed("; ".join(wrong), "what the folder says")
    try:
        find_binary(path, description.model_identifier)
    except FmuFileError:
        return failed(f"none for {fmpy.platform_tuple}; for other platforms: {listed}", "for this machine")
    return passed(listed, "for this machine")


def _what(platforms: set[str]) -> str:
    return f"a library for {', '.join(sorted(platforms))}" if platforms else "a file that is no library"


def check_sources(folder: Path, declared: tuple[str, ...]) -> Outcome:
    """Check that declared source files are there.

    Parameters
    ----------
    folder : Path
        Where the FMU is unpacked.
    declared : tuple of str
        Their names, relative to the folder sources.
    """
    if not declared:
        if (folder / "sources").is_dir():
            return noted("there is a folder sources, but no file of it is declared")
        return not_checked("the FMU declares none")
    missing = [name for name in declared if not (folder / "sources" / name).is_file()]
    if missing:
        return failed(f"{', '.join(missing)}: not in sources", "all there")
    return passed(f"{counted(len(declared), 'file')}, all there", "all there")


def check_documentation(folder: Path) -> Outcome:
    """Look for the page that FMI puts first among the documentation."""
    if (folder / "documentation" / "index.html").is_file():
        return passed("documentation/index.html")
    return noted("there is no documentation/index.html")
