"""Check the .fmu file itself, without running it.

Of the archive: that it is sound, its libraries, declared sources, documentation (FMI 2.0.4, section 2.3). Of
modelDescription.xml: its encoding, its schema, the rules a schema cannot hold, start values within bounds, and units.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import fmpy  # pyright: ignore[reportMissingTypeStubs]
from fmpy.validation import validate_fmu  # pyright: ignore[reportMissingTypeStubs]

from cosim.check.verdict import Outcome, counted, failed, not_checked, noted, passed, some
from cosim.errors import FmuFileError
from cosim.fmi2.archive import open_archive
from cosim.fmi2.library import built_for, expected_for, find_binary
from cosim.fmi2.xml_check import check_xml, in_utf8
from cosim.system.description import Description, Match, Variable, compare, describe

_LIBRARIES = (".so", ".dll", ".dylib")
PLAIN_NAMES = "names that are files on every system"
"""What is allowed of an archive that could be unpacked, and fails by names of its members alone."""


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
            flaws = archive.flaws
    except FmuFileError as error:
        return failed(str(error).replace(f"{path} ", "it ", 1).removeprefix(f"{path}: "), allowed)
    files = [file for file in folder.rglob("*") if file.is_file()]
    if folder / "modelDescription.xml" not in files:
        return failed("there is no modelDescription.xml at its root", allowed)
    if flaws:
        return failed("; ".join(flaws), PLAIN_NAMES)
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
    if not has_library(path, description):
        return failed(f"none for {fmpy.platform_tuple}; for other platforms: {listed}", "for this machine")
    return passed(listed, "for this machine")


def has_library(path: Path, description: Description) -> bool:
    """Tell whether there is a file for this machine where its library belongs, whatever there is for others."""
    try:
        with open_archive(path) as archive:
            find_binary(archive, description.model_identifier)
    except FmuFileError:
        return False
    return True


def has_sound_library(path: Path, folder: Path, description: Description) -> bool:
    """Tell whether what there is for this machine, unpacked in a folder, is a library for it."""
    if not has_library(path, description):
        return False
    with open_archive(path) as archive:
        name = find_binary(archive, description.model_identifier)
    library = built_for((folder / name).read_bytes())
    expected = expected_for(fmpy.platform_tuple)
    return not expected or bool(library & expected)


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


SCHEMA = Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"
"""The schema files of FMI 2.0.5, which fmpy carries; they are under the 2-clause BSD licence."""


@dataclass(frozen=True)
class Document:
    """modelDescription.xml, as it is and read."""

    content: bytes
    root: ElementTree.Element
    flaw: str | None = None


def read_document(folder: Path) -> Document:
    """Read modelDescription.xml of an unpacked FMU; FmuFileError if it is not XML, or such as no parser should see."""
    content = (folder / "modelDescription.xml").read_bytes()
    content, flaw = in_utf8(content)
    check_xml(content, "modelDescription.xml", FmuFileError)
    return Document(content, ElementTree.fromstring(content), flaw)


def check_encoding(document: Document) -> Outcome:
    """Check that the file is in UTF-8 (FMI 2.0, section 2.2)."""
    return failed(document.flaw, "UTF-8") if document.flaw else passed("UTF-8", "UTF-8")


def check_schema(document: Document) -> Outcome:
    """Validate the file against the schema of FMI 2.0."""
    etree: Any = import_module("lxml.etree")  # which comes without types
    schema = etree.XMLSchema(file=str(SCHEMA))
    if schema.validate(etree.fromstring(document.content)):
        return passed("valid", "valid")
    return failed(some([f"line {entry.line}: {entry.message}" for entry in schema.error_log]), "valid")


def check_rules(folder: Path) -> Outcome:
    """Apply fmpy's rules to an unpacked FMU: names, causality, start values, model structure, units."""
    problems = validate_fmu(str(folder))
    return failed(some(problems), "none broken") if problems else passed("none broken", "none broken")


def check_bounds(description: Description) -> Outcome:
    """Check that every start value is one its variable can have, and every minimum at most the maximum."""
    problems = [problem for variable in description.variables if (problem := _out_of_bounds(variable))]
    if problems:
        return failed(some(problems), "min to max")
    given = sum(variable.start is not None for variable in description.variables)
    return passed(counted(given, "start value"), "min to max")


def _out_of_bounds(variable: Variable) -> str | None:
    low, high = variable.minimum, variable.maximum
    if low is not None and high is not None and low > high:
        return f"{variable.name}: min {low:g} is above max {high:g}"
    if variable.start is None or variable.type in ("String", "Boolean"):
        return None
    start = float(variable.start)
    if variable.type == "Enumeration" and variable.items and int(start) not in variable.items.values():
        return f"{variable.name}: start {start:g} is none of its items"
    if (low is not None and start < low) or (high is not None and start > high):
        return f"{variable.name}: start {start:g} is out of its bounds"
    return None


def check_aliases(description: Description) -> Outcome:
    """Check that variables with one value reference have one unit and one start value (FMI 2.0, section 2.2.7)."""
    sets: dict[tuple[str, int], list[Variable]] = {}
    for variable in description.variables:
        kind = "Integer" if variable.type == "Enumeration" else variable.type  # fmi2GetInteger gets both
        sets.setdefault((kind, variable.reference), []).append(variable)
    aliases = {key: variables for key, variables in sets.items() if len(variables) > 1}
    allowed = "same units, same start values"
    problems = [
        problem for first, *others in aliases.values() for other in others if (problem := _contradiction(first, other))
    ]
    if problems:
        return failed(some(problems), allowed)
    return passed(counted(sum(map(len, aliases.values())), "alias variable") if aliases else "none", allowed)


def _contradiction(first: Variable, other: Variable) -> str | None:
    """Say in what two variables with one value contradict each other."""
    names = f"{first.name} and {other.name}"
    if compare(first.measured_in, other.measured_in) not in (Match.SAME, Match.ASSUMED):
        return f"{names} are in {describe(first.measured_in)} and {describe(other.measured_in)}"
    starts = [variable.start_value for variable in (first, other) if variable.start is not None]
    if len(set(starts)) > 1:
        return f"{names} start at {first.start} and {other.start}"
    return None


def check_units(description: Description) -> Outcome:
    """Look whether inputs and outputs say in what unit they are, and whether the unit is defined by base units."""
    signals = [v for v in description.variables if v.type == "Real" and v.causality in ("input", "output")]
    if not signals:
        return passed("no Real inputs or outputs")
    bare = [variable.name for variable in signals if variable.unit is None]
    vague = sorted({v.unit.name for v in signals if v.unit is not None and v.unit.powers is None})
    remarks = [f"{len(bare)} of {len(signals)} have none: {some(bare)}"] if bare else []
    remarks += [f"not in base units: {', '.join(vague)}"] if vague else []
    if remarks:
        return noted("; ".join(remarks), "in base units")
    units = sorted({v.unit.name for v in signals if v.unit is not None})
    return passed(f"{len(signals)} in {', '.join(units)}", "in base units")


def check_kind(document: Document) -> Outcome:
    """Check that the FMU is for co-simulation by FMI 2.0, which is all that can be checked here."""
    root = document.root
    version = root.get("fmiVersion") or "not given"
    if version != "2.0":
        return failed(f"FMI version is {version}; such an FMU cannot be checked here", "co-simulation")
    kinds = [name for name in ("CoSimulation", "ModelExchange") if root.find(name) is not None]
    if "CoSimulation" not in kinds:
        what = "for model exchange only" if kinds else "neither for co-simulation nor for model exchange"
        return failed(f"it is {what}; such an FMU cannot be checked here", "co-simulation")
    also = ", and for model exchange, which is not checked" if len(kinds) > 1 else ""
    return passed(f"FMI 2.0 for co-simulation{also}", "co-simulation")


def declared_sources(document: Document) -> tuple[str, ...]:
    """Return the source files declared for co-simulation."""
    return tuple(file.get("name", "") for file in document.root.findall("CoSimulation/SourceFiles/File"))
