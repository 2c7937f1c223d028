"""XML from elsewhere, checked before a parser that expands entities, opens files or recurses gets to see it.

fmpy reads model descriptions by lxml, with lxml's defaults. What passes here holds nothing that those act upon. expat,
which checks, calls back where a document type declaration begins, before it reads any entity from it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NoReturn
from xml.parsers import expat

from cosim.errors import InputError

MOST_DEPTH = 100
"""Elements within each other; a model description has 5 levels and, within annotations, what tools like."""


@dataclass(frozen=True)
class Root:
    """The outermost element of a document: its name as it is written, and its attributes."""

    name: str
    attributes: Mapping[str, str] = field(default_factory=dict[str, str])


def check_xml(content: bytes, where: str, refusal: type[InputError]) -> Root:
    """Check a document that came with an FMU or a system.

    Parameters
    ----------
    content : bytes
        The document.
    where : str
        What it is, for messages.
    refusal : type of InputError
        What to raise.

    Returns
    -------
    Root
        Its outermost element.

    Raises
    ------
    InputError
        Of that type, if the content is not XML in UTF-8, which FMI 2.0, section 2.2, demands, has a document type
        declaration, or is nested deeper than `MOST_DEPTH`.
    """
    check = _Check(where, refusal)
    try:
        content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise refusal(f"{where} is not in UTF-8: byte {error.start} is 0x{content[error.start]:02x}") from None
    try:
        check.parser.Parse(content, True)
    except expat.ExpatError as error:
        raise refusal(f"{where} is not XML: {error}") from None
    return check.root


class _Check:
    """Receives what expat reports."""

    def __init__(self, where: str, refusal: type[InputError]) -> None:
        self.root = Root("")
        self.parser = expat.ParserCreate()
        self.parser.XmlDeclHandler = self._declaration
        self.parser.StartDoctypeDeclHandler = self._document_type
        self.parser.StartElementHandler = self._begin
        self.parser.EndElementHandler = self._end
        self._where = where
        self._refusal = refusal
        self._depth = 0

    def _declaration(self, version: str, encoding: str | None, standalone: int) -> None:
        del version, standalone
        if encoding is not None and encoding.lower() != "utf-8":
            self._refuse(f"is declared to be in {encoding}; expected UTF-8")

    def _document_type(self, *declared: object) -> None:
        del declared
        self._refuse("has a document type declaration; expected none")

    def _begin(self, name: str, attributes: dict[str, str]) -> None:
        if self._depth == 0:
            self.root = Root(name, attributes)
        self._depth += 1
        if self._depth > MOST_DEPTH:
            self._refuse(f"is nested more than {MOST_DEPTH} elements deep")

    def _end(self, name: str) -> None:
        del name
        self._depth -= 1

    def _refuse(self, why: str) -> NoReturn:
        raise self._refusal(f"{self._where} {why}")
