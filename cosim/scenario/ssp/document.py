"""XML documents of the standard: read safely and checked against the schemas, written in one way."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from functools import cache
from importlib import resources
from typing import Any
from xml.etree.ElementTree import Element

import lxml.etree  # pyright: ignore[reportMissingTypeStubs, reportMissingModuleSource]

from cosim.errors import SspError
from cosim.fmi2.xml_check import check_xml
from cosim.scenario.ssp.vocabulary import OWN, SSC, SSD, SSV

_etree: Any = lxml.etree  # pyright: ignore[reportUnknownMemberType, reportUnknownVariableType]
_NAMESPACE = re.compile(r"\{[^}]*\}")
_SCHEMAS = {SSD: "SystemStructureDescription.xsd", SSV: "SystemStructureParameterValues.xsd"}
_VERSION = re.compile(r"1\.[0-9]+(-.*)?")


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
    check_xml(content, where, SspError)
    element = ElementTree.fromstring(content)
    if element.tag != root:
        raise SspError(f"{where}: the root element is {plain_name(element.tag)}; expected {plain_name(root)} of SSP 1")
    check_document(element, where)
    return element


def check_document(element: Element, where: str) -> None:
    """Refuse a document that is of another version or breaks the schema, naming the first element that does."""
    version = element.get("version", "")
    if not _VERSION.fullmatch(version):
        raise SspError(f"{where}: the version is '{version}'; expected 1.0")
    schema = _schema(element.tag.partition("}")[0].removeprefix("{"))
    if not schema.validate(_etree.fromstring(ElementTree.tostring(element))):
        raise SspError(f"{where} breaks the schema of SSP 1.0: {_NAMESPACE.sub('', schema.error_log[0].message)}")


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
