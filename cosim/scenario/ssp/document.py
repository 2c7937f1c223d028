"""Read and write the .ssp file and its XML documents: safely, checked against the schemas, in one way.

Names and media types are those of the SSP 1.0 standard, and of the annotations of this package.
"""

from __future__ import annotations

import logging
import os
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Generator
from contextlib import contextmanager
from functools import cache
from importlib import resources
from pathlib import Path, PurePosixPath
from typing import Any
from urllib.parse import unquote, urlsplit
from xml.etree.ElementTree import Element

import lxml.etree  # pyright: ignore[reportMissingTypeStubs, reportMissingModuleSource]

import cosim.fmi2.archive
from cosim.errors import SspError
from cosim.files import read_file, why
from cosim.fmi2.archive import Archive
from cosim.fmi2.xml_check import check_xml, in_utf8

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSM = "http://ssp-standard.org/SSP1/SystemStructureParameterMapping"
OWN = "urn:drillstring-cosim:ssp:1"

STRUCTURE = "SystemStructure.ssd"
RESOURCES = "resources"

FMU_TYPE = "application/x-fmu-sharedlibrary"
PARAMETER_SET_TYPE = "application/x-ssp-parameter-set"
MAPPING_TYPE = "application/x-ssp-parameter-mapping"

SCENARIO_ANNOTATION = "drillstring-cosim.scenario"
"""On the whole description: how the system is to be run."""
SIGNALS_ANNOTATION = "drillstring-cosim.signals"
"""On a component: it stands for signals that drive inputs, and nothing else."""

log = logging.getLogger("cosim")

_etree: Any = lxml.etree  # pyright: ignore[reportUnknownMemberType, reportUnknownVariableType]
_NAMESPACE = re.compile(r"\{[^}]*\}")
_SCHEMAS = {
    SSD: "SystemStructureDescription.xsd",
    SSV: "SystemStructureParameterValues.xsd",
    SSM: "SystemStructureParameterMapping.xsd",
}
_VERSION = re.compile(r"[12]\.[0-9]+(-.*)?")


def read_document(content: bytes, where: str, root: str) -> Element:
    """Read a document of SSP 1.

    Parameters
    ----------
    content : bytes
        The XML.
    where : str
        File it is from, for messages.
    root : str
        Qualified name of the element it must have at its root.

    Raises
    ------
    SspError
        If it is not XML that can safely be read, is another document or of another version, or breaks the schema.
    """
    content, flaw = in_utf8(content)
    check_xml(content, where, SspError)
    if flaw is not None:
        log.warning("%s: tolerated: %s", where, flaw)
    element = ElementTree.fromstring(content)
    if element.tag != root:
        raise SspError(f"{where}: the root element is {plain_name(element.tag)}; expected {plain_name(root)} of SSP 1")
    check_document(element, where)
    return element


def check_document(element: Element, where: str) -> None:
    """Refuse a document that is of another version or breaks the schema, naming the first element that does."""
    version = element.get("version", "")
    if not _VERSION.fullmatch(version):
        raise SspError(f"{where}: the version is '{version}'; expected 1.0 or 2.0")
    schema = _schema(element.tag.partition("}")[0].removeprefix("{"))
    try:
        document = _etree.fromstring(ElementTree.tostring(element))
    except _etree.XMLSyntaxError as error:  # of a name that expat takes and libxml2 does not
        raise SspError(f"{where} is not XML: {error}") from error
    document.set("version", "1.0")  # which is all that the schema knows
    if schema.validate(document):
        return
    what = f"{where} breaks the schema of SSP 1.0: {_NAMESPACE.sub('', schema.error_log[0].message)}"
    if not version.startswith("2."):
        raise SspError(what)
    log.warning("%s; it is of SSP %s, and what SSP 1.0 has of it is read", what, version)  # whose schema fmpy lacks


def write_document(root: Element) -> bytes:
    """Write a document, indented, in UTF-8."""
    for prefix, namespace in (("ssd", SSD), ("ssc", SSC), ("ssv", SSV), ("drillstring", OWN)):
        ElementTree.register_namespace(prefix, namespace)
    ElementTree.indent(root)
    return ElementTree.tostring(root, "utf-8", xml_declaration=True) + b"\n"


def plain_name(tag: str) -> str:
    """Return the name of an element without its namespace."""
    return _NAMESPACE.sub("", tag)


@cache
def _schema(namespace: str) -> Any:
    """Load a schema of the standard; fmpy brings them along."""
    with resources.as_file(resources.files("fmpy") / "ssp" / "schema") as folder:
        return _etree.XMLSchema(_etree.parse(str(folder / _SCHEMAS[namespace])))


class SspArchive:
    """An open .ssp file, of which members are read one by one, never unpacked by their own names."""

    structure = STRUCTURE

    def __init__(self, archive: Archive) -> None:
        self.path = archive.path
        self._archive = archive
        self._names = archive.names

    def read(self, name: str) -> bytes:
        """Return the content of a member; SspError if there is none of that name or it is damaged."""
        return self._archive.read(name)

    def copy(self, name: str, target: Path) -> None:
        """Write the content of a member to a file; SspError as by `read`, or if it cannot be written."""
        self._archive.copy(name, target)

    def number(self, name: str) -> int:
        """Return the place of a member in the archive; -1 if it is not there."""
        return self._names.index(name) if name in self._names else -1

    def member(self, source: str, what: str) -> str:
        """Return the name of the member that a URI of the description means; SspError if it leads out."""
        return _member(self.path, source, what)


class SspFolder:
    """A system that lies unpacked: the .ssd file, and beside it what it names."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.structure = path.name
        self._numbers: dict[str, int] = {}

    def read(self, name: str) -> bytes:
        """Return the content of a file; SspError if there is none of that name or it cannot be read."""
        try:
            return read_file(self._file(name), cosim.fmi2.archive.MOST_BYTES)
        except OSError as error:
            raise SspError(f"{self.path.parent / name} cannot be read: {why(error)}") from error

    def copy(self, name: str, target: Path) -> None:
        """Copy a file; SspError as by `read`."""
        target.write_bytes(self.read(name))

    def number(self, name: str) -> int:
        """Return a number for a file, the same each time."""
        return self._numbers.setdefault(name, len(self._numbers))

    def member(self, source: str, what: str) -> str:
        """Return the name of the file that a URI of the description means, which may lie above its folder."""
        return _member(self.path, source, what, above=True)

    def _file(self, name: str) -> Path:
        """Return the file of a name; it may lead up by itself, as what repositories share does, but by no link."""
        parts = os.path.normpath(name).split(os.sep)
        top = self.path.parent.resolve().joinpath(*(part for part in parts if part == "..")).resolve()
        file = (self.path.parent.resolve() / name).resolve()
        if not file.is_relative_to(top):
            raise SspError(f"{self.path}: {name} leads out of the folder of the description")
        return file


SspSource = SspArchive | SspFolder
"""The source of a description and of what it names."""


_PROXY = re.compile(r"proxy-?fmu://localhost\?file=(?P<file>[^&]+)")


def without_proxy(source: str) -> tuple[str, bool]:
    """Return the source of a component, and whether it is to be run in a process of its own.

    The latter is what the proxy of the Open Simulation Platform does on this machine: ``proxyfmu://localhost?file=...``.
    """
    match = _PROXY.fullmatch(source)
    return (match["file"], True) if match else (source, False)


def _member(path: Path, source: str, what: str, *, above: bool = False) -> str:
    """Return the name that a URI of a description means within its archive, or from its folder on."""
    parts = urlsplit(source)
    name = PurePosixPath(unquote(parts.path))
    outside = name.is_absolute() or "\\" in str(name) or (".." in name.parts and not above)
    if parts.scheme or parts.netloc or parts.query or parts.fragment or outside or not name.parts:
        expected = "a path from the folder of the description on" if above else "a path within the archive"
        raise SspError(f"{path}: the source of {what} is '{source}'; expected {expected}")
    return str(name)


@contextmanager
def open_source(path: Path) -> Generator[SspSource]:
    """Open an .ssp file for reading, or an .ssd file that lies unpacked beside what it names.

    Raises
    ------
    SspError
        If it is missing, is not a zip archive that can safely be opened, or holds no SystemStructure.ssd.
    """
    if path.suffix == ".ssd":
        yield SspFolder(path)
        return
    with cosim.fmi2.archive.open_archive(path, "an SSP file", SspError) as archive:
        if STRUCTURE not in archive.names:
            raise SspError(f"{path} is not an SSP file: there is no {STRUCTURE} in it")
        others = [name for name in archive.names if name.endswith(".ssd") and "/" not in name and name != STRUCTURE]
        if others:
            log.warning("%s: %s is read; the variants %s are not", path.name, STRUCTURE, ", ".join(others))
        yield SspArchive(archive)


def ssd(name: str) -> str:
    """Return the qualified name of an element of a system structure description."""
    return f"{{{SSD}}}{name}"


def ssc(name: str) -> str:
    """Return the qualified name of an element that all formats of the standard share."""
    return f"{{{SSC}}}{name}"


def ssv(name: str) -> str:
    """Return the qualified name of an element of a parameter set."""
    return f"{{{SSV}}}{name}"


def ssm(name: str) -> str:
    """Return the qualified name of an element of a parameter mapping."""
    return f"{{{SSM}}}{name}"


def own(name: str) -> str:
    """Return the qualified name of an element of this package's annotations."""
    return f"{{{OWN}}}{name}"
