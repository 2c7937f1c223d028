"""XML from elsewhere, in UTF-8 and checked before a parser that expands entities, opens files or recurses sees it.

fmpy reads model descriptions by lxml, with lxml's defaults. What passes here holds nothing that those act upon. expat,
which checks, calls back where a document type declaration begins, before it reads any entity from it.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NoReturn
from xml.parsers import expat

from cosim.errors import InputError

MOST_DEPTH = 100
"""Elements within each other; a model description has 5 levels and, within annotations, what tools like."""


MOST_TEXT = 2**20
"""Characters in an attribute, a text or a comment; what reads it next gives up at ten times as many."""
MOST_NAME = 1000
"""Characters in the name of an element or attribute, with that of its namespace."""


@dataclass(frozen=True)
class Root:
    """The outermost element of a document: its name as it is written, and its attributes."""

    name: str
    attributes: Mapping[str, str] = field(default_factory=dict[str, str])


_DECLARED = re.compile(rb"""(\A<\?xml[^>]*?\sencoding\s*=\s*)(["'])([A-Za-z0-9._-]+)\2""")
_TOLERATED = ("us-ascii", "ascii", "iso-8859-1", "latin-1", "windows-1252", "cp1252")


def in_utf8(content: bytes) -> tuple[bytes, str | None]:
    """Turn a document in one of the encodings that old exporters write into UTF-8.

    Returns
    -------
    bytes
        The document, its declaration changed with it; as it was, if it is in no such encoding.
    str or None
        What had to be tolerated, for a message: FMI 2.0, section 2.2, demands UTF-8.
    """
    declared = _DECLARED.match(content)
    encoding = declared[3].decode("ascii") if declared else ""
    if declared is None or encoding.lower() not in _TOLERATED:
        return content, None
    try:
        text = content[declared.end() :].decode(encoding)
    except UnicodeDecodeError:
        return content, None
    head = declared[1] + declared[2] + b"UTF-8" + declared[2]
    return head + text.encode("utf-8"), f"it is in {encoding} instead of UTF-8"


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
        declaration, is nested deeper than `MOST_DEPTH`, or has a text longer than `MOST_TEXT`.
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
        self.parser = expat.ParserCreate(namespace_separator=" ")  # which finds a prefix that nothing declares
        self.parser.XmlDeclHandler = self._declaration
        self.parser.StartDoctypeDeclHandler = self._document_type
        self.parser.StartElementHandler = self._begin
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._take_text
        self.parser.CommentHandler = self._take_comment
        self.parser.ProcessingInstructionHandler = self._take_instruction
        self._where = where
        self._refusal = refusal
        self._depth = self._text = 0

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
        self._text = 0
        for each in (name, *attributes):
            if len(each) > MOST_NAME:
                self._refuse(f"has a name of {len(each)} characters; expected at most {MOST_NAME}")
        for text in attributes.values():
            self._refuse_long("attribute", text)
        if self._depth > MOST_DEPTH:
            self._refuse(f"is nested more than {MOST_DEPTH} elements deep")

    def _end(self, name: str) -> None:
        del name
        self._depth -= 1

    def _take_text(self, text: str) -> None:
        self._text += len(text)
        if self._text > MOST_TEXT:
            self._refuse(f"has a text of more than {MOST_TEXT} characters")

    def _take_comment(self, text: str) -> None:
        self._refuse_long("comment", text)

    def _take_instruction(self, target: str, text: str) -> None:
        self._refuse_long("processing instruction", target + text)

    def _refuse_long(self, what: str, text: str) -> None:
        if len(text) > MOST_TEXT:
            self._refuse(f"has a {what} of {len(text)} characters; expected at most {MOST_TEXT}")

    def _refuse(self, why: str) -> NoReturn:
        raise self._refusal(f"{self._where} {why}")
