r"""Formulas of the documentation pages: a small part of LaTeX turned into MathML, which a browser draws unaided.

Known are letters, numbers and operators, ``\frac{}{}``, ``\sqrt{}``, ``\dot{}``, ``_{}`` and ``^{}``, ``\text{}``,
Greek letters and the commands of `_SYMBOLS`.
"""

from __future__ import annotations

import re
import unicodedata
from html import escape

_TOKEN = re.compile(r"\\text\{[^}]*\}|\\[A-Za-z]+|\\[,;|]|\d+(?:\.\d+)?|\S")
_GREEK = {
    "beta": "\N{GREEK SMALL LETTER BETA}",
    "gamma": "\N{GREEK SMALL LETTER GAMMA}",
    "theta": "\N{GREEK SMALL LETTER THETA}",
    "kappa": "\N{GREEK SMALL LETTER KAPPA}",
    "mu": "\N{GREEK SMALL LETTER MU}",
    "xi": "\N{GREEK SMALL LETTER XI}",
    "sigma": "\N{GREEK SMALL LETTER SIGMA}",
    "tau": "\N{GREEK SMALL LETTER TAU}",
    "omega": "\N{GREEK SMALL LETTER OMEGA}",
    "Gamma": "\N{GREEK CAPITAL LETTER GAMMA}",
    "Lambda": "\N{GREEK CAPITAL LETTER LAMDA}",
    "Upsilon": "\N{GREEK CAPITAL LETTER UPSILON}",
    "Omega": "\N{GREEK CAPITAL LETTER OMEGA}",
}
_SYMBOLS = {
    "partial": "\N{PARTIAL DIFFERENTIAL}",
    "int": "\N{INTEGRAL}",
    "le": "\N{LESS-THAN OR EQUAL TO}",
    "ge": "\N{GREATER-THAN OR EQUAL TO}",
}
_FUNCTIONS = frozenset({"sgn", "exp", "min", "max", "tan"})
MINUS = "\N{MINUS SIGN}"
_SPACES = {"\\,": "0.17em", "\\;": "0.28em", "\\quad": "1em", "\\qquad": "2em"}


def mathml(latex: str) -> str:
    """Return a formula as what stands inside a ``math`` element.

    Raises
    ------
    ValueError
        The formula is not complete, or holds a command that is not known.
    """
    tokens = _TOKEN.findall(latex)
    tokens.reverse()
    parts = _row(tokens)
    if tokens:
        raise ValueError(f"formula {latex!r}: a brace is closed that was never opened")
    return "".join(parts)


def _row(tokens: list[str]) -> list[str]:
    """Read elements up to the end or to a closing brace, which is left."""
    parts: list[str] = []
    while tokens and tokens[-1] != "}":
        parts.append(_scripted(tokens))
    return parts


def _scripted(tokens: list[str]) -> str:
    """Read one element with what hangs on it."""
    base = _element(tokens)
    scripts: dict[str, str] = {}
    while tokens and tokens[-1] in "_^":
        mark = tokens.pop()
        scripts[mark] = _element(tokens)
    if len(scripts) == 2:
        return f"<msubsup>{base}{scripts['_']}{scripts['^']}</msubsup>"
    if "_" in scripts:
        return f"<msub>{base}{scripts['_']}</msub>"
    return f"<msup>{base}{scripts['^']}</msup>" if scripts else base


def _element(tokens: list[str]) -> str:
    """Read one element: a group in braces, a command, or one letter, number or operator."""
    if not tokens or tokens[-1] == "}":
        raise ValueError("a formula ends where something is missing")
    token = tokens.pop()
    if token == "{":
        parts = _row(tokens)
        if not tokens:
            raise ValueError("a formula ends before a brace is closed")
        tokens.pop()
        return f"<mrow>{''.join(parts)}</mrow>"
    if token.startswith("\\"):
        return _command(token, tokens)
    if token[0].isdigit():
        return f"<mn>{token}</mn>"
    if token.isalpha():
        return f"<mi>{token}</mi>"
    if token == "|":
        return '<mo stretchy="false" lspace="0" rspace="0">|</mo>'
    if token in "()[]":
        return f'<mo stretchy="false">{token}</mo>'
    return f"<mo>{escape(token) if token != '-' else MINUS}</mo>"


def _command(token: str, tokens: list[str]) -> str:
    """Read the arguments of a command."""
    name = token[1:]
    if token.startswith("\\text{"):
        return f"<mtext>{escape(token[6:-1])}</mtext>"
    if token in _SPACES:
        return f'<mspace width="{_SPACES[token]}"></mspace>'
    if name == "frac":
        return f"<mfrac>{_element(tokens)}{_element(tokens)}</mfrac>"
    if name == "sqrt":
        return f"<msqrt>{_element(tokens)}</msqrt>"
    if name == "dot":
        return _dotted(tokens)
    if name in _GREEK:
        return f"<mi>{_GREEK[name]}</mi>"
    if name in _FUNCTIONS:
        return f"<mi>{name}</mi><mo>&#8289;</mo>"
    if name in _SYMBOLS:
        return f"<mo>{_SYMBOLS[name]}</mo>"
    raise ValueError(f"a formula holds {token!r}, which is not known")


def _dotted(tokens: list[str]) -> str:
    """Read a letter and put a dot on it; an accent element would lose it where there is no font for mathematics."""
    letter = "".join(tokens.pop() for _ in range(min(3, len(tokens))))
    if not re.fullmatch(r"\{[A-Za-z]\}", letter):
        raise ValueError(f"a formula holds \\dot{letter}; expected one letter in braces")
    dotted = unicodedata.normalize("NFC", letter[1] + "\N{COMBINING DOT ABOVE}")
    return f'<mi style="font-style: italic">{dotted}</mi>'
