"""Write the tree of a formula as one line of plain text, which is what a reader gets who copies it."""

from __future__ import annotations

import unicodedata

from .formula import (
    INTEGRAL,
    PRIME,
    Bracketed,
    Dotted,
    Fraction,
    Function,
    Integral,
    Letter,
    Node,
    Number,
    Operator,
    Role,
    Root,
    Row,
    Scripted,
    Space,
    Words,
)


def linear(node: Node) -> str:
    """Return an element of a formula as text: (a + b)/c_1 for a fraction."""
    match node:
        case Row(parts):
            return _row(parts)
        case Scripted(base, below, above):
            scripts = "".join(_script(mark, script) for mark, script in (("_", below), ("^", above)) if script)
            return _whole(base) + scripts
        case Fraction(above, below):
            return f"{_whole(above)}/{_whole(below)}"
        case Root(content):
            return f"\N{SQUARE ROOT}{_whole(content)}"
        case Bracketed(opening, content, closing):
            return f"{opening}{linear(content)}{closing}"
        case Dotted(letter):
            return unicodedata.normalize("NFC", letter + "\N{COMBINING DOT ABOVE}")
        case Letter(text) | Function(text) | Number(text) | Words(text) | Operator(text, _):
            return text
        case Integral():
            return INTEGRAL
        case Space():
            return " "


def _row(parts: tuple[Node, ...]) -> str:
    """Return elements with blanks round what is between terms, and between what would run together."""
    text = ""
    before: Node | None = None
    for part in parts:
        text += " " if before is not None and _apart(before, part) else ""
        text += linear(part)
        before = part
    return " ".join(text.split())


def _apart(before: Node, part: Node) -> bool:
    """Return whether a blank stands between two neighbours."""
    if isinstance(before, Operator) and before.role in {Role.BINARY, Role.RELATION, Role.PUNCTUATION}:
        return True
    if isinstance(part, Operator):
        return part.role in {Role.BINARY, Role.RELATION} or (isinstance(before, Function) and part.role is Role.SIGN)
    return not isinstance(before, Operator) and (isinstance(before, Fraction) or not isinstance(part, Bracketed))


def _script(mark: str, script: Row) -> str:
    if all(isinstance(part, Letter | Number) for part in script.parts):
        return mark + "".join(map(linear, script.parts))
    text = linear(script)
    if not text.strip(PRIME):
        return text
    return f"{mark}{text}" if text.isalnum() else f"{mark}({text})"


def _whole(node: Node) -> str:
    """Return an element in parentheses, unless it holds together without."""
    match node:
        case Row((part,)):
            return _whole(part)
        case Row() | Fraction():
            return f"({linear(node)})"
        case _:
            return linear(node)
