r"""Formulas of the documentation pages: a small part of LaTeX, read into a tree.

Known are letters, numbers and operators, ``\frac{}{}``, ``\sqrt{}``, ``\dot{}``, ``_{}`` and ``^{}``, primes,
``\text{}``, Greek letters, ``\sgn`` and other functions, the commands of `_SYMBOLS`, and spaces. Brackets and bars
come in pairs, as they are drawn as high as what stands between them.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from enum import StrEnum

MINUS = "\N{MINUS SIGN}"
PRIME = "\N{PRIME}"
INTEGRAL = "\N{INTEGRAL}"


class Role(StrEnum):
    """Say how an operator stands between its neighbours, which decides how far away they are."""

    BINARY = "binary"
    SIGN = "sign"
    RELATION = "relation"
    PUNCTUATION = "punctuation"
    ORDINARY = "ordinary"


@dataclass(frozen=True)
class Letter:
    """A letter that stands for a quantity, in italics."""

    letter: str


@dataclass(frozen=True)
class Number:
    """A number, upright."""

    digits: str


@dataclass(frozen=True)
class Words:
    """Words or a unit, upright."""

    words: str


@dataclass(frozen=True)
class Function:
    """The name of a function, upright."""

    name: str


@dataclass(frozen=True)
class Operator:
    """An operator or another sign."""

    sign: str
    role: Role


@dataclass(frozen=True)
class Integral:
    """The sign of an integral."""


@dataclass(frozen=True)
class Space:
    """A space that was asked for, of `width` em."""

    width: float


@dataclass(frozen=True)
class Dotted:
    """A letter with a dot on it, a derivative with respect to time."""

    letter: str


@dataclass(frozen=True)
class Fraction:
    """One row over another."""

    above: Row
    below: Row


@dataclass(frozen=True)
class Root:
    """The square root of a row."""

    content: Row


@dataclass(frozen=True)
class Bracketed:
    """A row between two brackets or bars."""

    opening: str
    content: Row
    closing: str


@dataclass(frozen=True)
class Scripted:
    """An element with a subscript, a superscript or both."""

    base: Node
    below: Row | None
    above: Row | None


@dataclass(frozen=True)
class Row:
    """Elements side by side; at least one."""

    parts: tuple[Node, ...]


Node = (
    Letter
    | Number
    | Words
    | Function
    | Operator
    | Integral
    | Space
    | Dotted
    | Fraction
    | Root
    | Bracketed
    | Scripted
    | Row
)

_TOKEN = re.compile(r"\\text\{[^{}]*\}|\\[A-Za-z]+|\\[,;]|\d+(?:\.\d+)?|\S")
_SPACES = {"\\,": 0.17, "\\;": 0.28, "\\quad": 1.0, "\\qquad": 2.0}
_FUNCTIONS = frozenset({"sgn", "exp", "min", "max", "sin", "cos", "tan", "ln"})
_SIGNS = {
    "+": Role.BINARY,
    "-": Role.BINARY,
    "=": Role.RELATION,
    "<": Role.RELATION,
    ">": Role.RELATION,
    ",": Role.PUNCTUATION,
    ";": Role.PUNCTUATION,
    ":": Role.PUNCTUATION,
    ".": Role.ORDINARY,
    "/": Role.ORDINARY,
}
_SYMBOLS = {
    "partial": ("\N{PARTIAL DIFFERENTIAL}", Role.ORDINARY),
    "infty": ("\N{INFINITY}", Role.ORDINARY),
    "cdot": ("\N{DOT OPERATOR}", Role.BINARY),
    "times": ("\N{MULTIPLICATION SIGN}", Role.BINARY),
    "pm": ("\N{PLUS-MINUS SIGN}", Role.BINARY),
    "le": ("\N{LESS-THAN OR EQUAL TO}", Role.RELATION),
    "ge": ("\N{GREATER-THAN OR EQUAL TO}", Role.RELATION),
    "ne": ("\N{NOT EQUAL TO}", Role.RELATION),
    "approx": ("\N{ALMOST EQUAL TO}", Role.RELATION),
    "in": ("\N{ELEMENT OF}", Role.RELATION),
}
_CLOSING = {"(": ")]", "[": ")]", "|": "|"}


def read_formula(latex: str) -> Row:
    """Return the tree of a formula.

    Raises
    ------
    ValueError
        The formula is empty or not complete, or holds what is not known.
    """
    return _Reader(latex).whole()


def is_tall(node: Node) -> bool:
    """Return whether an element is higher than a line of text, so that brackets round it have to be as well."""
    match node:
        case Fraction() | Integral():
            return True
        case Row(parts):
            return any(map(is_tall, parts))
        case Root(content) | Bracketed(_, content, _):
            return is_tall(content)
        case Scripted(base, _, _):
            return is_tall(base)
        case _:
            return False


class _Reader:
    """Reads the tokens of a formula from the first to the last."""

    def __init__(self, latex: str) -> None:
        self._latex = latex
        self._tokens = _TOKEN.findall(latex)[::-1]

    def whole(self) -> Row:
        row = self._row("", "it is empty")
        if self._tokens:
            raise self._wrong(f"{self._tokens[-1]!r} closes what was never opened")
        return row

    def _wrong(self, what: str) -> ValueError:
        return ValueError(f"formula {self._latex.strip()!r}: {what}")

    def _row(self, stop: str, if_empty: str) -> Row:
        """Read elements up to the end or to what closes something, which is left."""
        parts: list[Node] = []
        while self._tokens and self._tokens[-1] not in {"}", ")", "]", *stop}:
            parts.append(self._scripted())
        if not parts:
            raise self._wrong(if_empty)
        return Row(_with_signs(parts))

    def _scripted(self) -> Node:
        """Read one element with what hangs on it."""
        base = self._element()
        primes = 0
        while self._tokens and self._tokens[-1] == "'":
            primes += len(self._tokens.pop())
        scripts: dict[str, Row] = {"^": Row((Operator(PRIME * primes, Role.ORDINARY),))} if primes else {}
        while self._tokens and self._tokens[-1] in {"_", "^"}:
            mark = self._tokens.pop()
            if mark in scripts:
                raise self._wrong(f"two {mark!r} follow one element")
            scripts[mark] = self._argument(mark)
        return Scripted(base, scripts.get("_"), scripts.get("^")) if scripts else base

    def _argument(self, command: str) -> Row:
        """Read what a command is about: a group in braces, or one element."""
        if not self._tokens or self._tokens[-1] in {"}", ")", "]"}:
            raise self._wrong(f"something is missing after {command!r}")
        if self._tokens[-1] != "{":
            return Row(_with_signs([self._element()]))
        return self._group()

    def _group(self) -> Row:
        self._tokens.pop()
        row = self._row("", "braces hold nothing")
        self._close("}", "a brace")
        return row

    def _close(self, expected: str, what: str) -> str:
        if not self._tokens:
            raise self._wrong(f"{what} is never closed")
        if self._tokens[-1] not in expected:
            raise self._wrong(f"{what} is closed by {self._tokens[-1]!r}")
        return self._tokens.pop()

    def _element(self) -> Node:
        """Read one element: a group, what stands in brackets, a command, or one letter, number or operator."""
        if self._tokens[-1] == "{":
            return self._group()
        token = self._tokens.pop()
        if token in _CLOSING:
            return self._bracketed(token)
        if token.startswith("\\"):
            return self._command(token)
        if token[0].isdigit():
            return Number(token)
        if token.isalpha():
            return Letter(token)
        if token in {"_", "^", "'"}:
            raise self._wrong(f"{token!r} follows no element")
        if token not in _SIGNS:
            raise self._wrong(f"{token!r} is not known")
        return Operator(MINUS if token == "-" else token, _SIGNS[token])

    def _bracketed(self, opening: str) -> Bracketed:
        closing = _CLOSING[opening]
        content = self._row(closing, f"nothing follows {opening!r}")
        return Bracketed(opening, content, self._close(closing, f"a {opening!r}"))

    def _command(self, token: str) -> Node:
        """Read the arguments of a command."""
        name = token[1:]
        if token.startswith("\\text{"):
            return Words(token[6:-1])
        if token in _SPACES:
            return Space(_SPACES[token])
        if name == "frac":
            return Fraction(self._argument(token), self._argument(token))
        if name == "sqrt":
            return Root(self._argument(token))
        if name == "dot":
            return self._dotted()
        if name == "int":
            return Integral()
        if name in _FUNCTIONS:
            return Function(name)
        if name in _SYMBOLS:
            return Operator(*_SYMBOLS[name])
        letter = _greek(name)
        if letter is None:
            raise self._wrong(f"{token!r} is not known")
        return Letter(letter)

    def _dotted(self) -> Dotted:
        inner = self._argument("\\dot").parts
        if len(inner) != 1 or not isinstance(inner[0], Letter):
            raise self._wrong("\\dot stands on something else than one letter")
        return Dotted(inner[0].letter)


def _greek(name: str) -> str | None:
    """Return a Greek letter by its name, which begins with a capital if the letter is one; None if there is none."""
    size = "CAPITAL" if name[0].isupper() else "SMALL"
    called = "LAMDA" if name.lower() == "lambda" else name.upper()
    try:
        return unicodedata.lookup(f"GREEK {size} LETTER {called}")
    except KeyError:
        return None


def _with_signs(parts: list[Node]) -> tuple[Node, ...]:
    """Tell signs from operators: where nothing stands to the left to be added to, a plus or minus is a sign."""
    told: list[Node] = []
    before: Node | None = None
    for part in parts:
        if isinstance(part, Operator) and part.role is Role.BINARY:
            operand = before is not None and not isinstance(before, Function)
            if isinstance(before, Operator):
                operand = before.role is Role.ORDINARY and before.sign != "/"
            part = part if operand else Operator(part.sign, Role.SIGN)
        told.append(part)
        before = before if isinstance(part, Space) else part
    return tuple(told)
