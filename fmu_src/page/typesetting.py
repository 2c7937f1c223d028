"""Typeset formulas as HTML that looks the same in any browser, whatever fonts there are.

A formula is written three times: as spans for the eye, which `formula.css` arranges; as MathML for screen readers,
which the eye does not see; and as a line of text that lies over the spans unseen, so that it is what is marked and
copied. The spans come from the tree alone, without a measure of any font: what is tall stands with its middle on the
axis of the line, and brackets and roots stretch to what they hold.
"""

from __future__ import annotations

from html import escape
from itertools import pairwise

from .. import project
from .formula import (
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
    is_tall,
    read_formula,
)
from .linear import linear
from .mathml import mathml

_QUAD = 1.0
"""Width in em from which on a space of a displayed formula parts what may stand below each other."""

_INTEGRAL = "M47 9C44 2 34 1 31 15L19 105C16 119 6 118 3 111"
_SURD = "M2 60L14 52L30 98L60 0"
_SURD_STROKE = "M14 52L30 98"
_DOTLESS = {"i": "\N{LATIN SMALL LETTER DOTLESS I}", "j": "\N{LATIN SMALL LETTER DOTLESS J}"}
_TALL_BRACKETS = {"(": "round", ")": "round", "[": "square", "]": "square", "|": "bar"}


def formula_html(latex: str, *, displayed: bool = False) -> str:
    """Return a formula as HTML that `formula_css` styles: within a line, or by itself.

    Raises
    ------
    ValueError
        The formula is empty or not complete, or holds what is not known.
    """
    tree = read_formula(latex)
    kind, block = (" fx-display", ' display="block"') if displayed else ("", "")
    seen = " ".join(_span("part", _row(part)) for part in _parts(tree)) if displayed else _visible(tree)
    copied = escape(linear(tree), quote=False)
    return (
        f'<span class="formula{kind}"><span class="fx-spoken"><math{block}>{mathml(tree)}</math></span>'
        f'<span class="fx-seen" aria-hidden="true">{seen}</span>'
        f'<span class="fx-copied" aria-hidden="true">{_span("marked", copied)}</span></span>'
    )


def equation_html(latex: str, label: str) -> str:
    """Return a displayed formula with its label, a text such as "Eq. (3)", at its right; the label may be empty."""
    room = f'<div class="formula-room">{formula_html(latex, displayed=True)}</div>'
    told = f'<span class="formula-label">{escape(label, quote=False)}</span>' if label else ""
    return f'<div class="formula-equation">{room}{told}</div>'


def formula_css() -> str:
    """Return the style sheet of formulas and equations; all its classes begin with `formula` or `fx-`."""
    return (project.SOURCES / "page" / "formula.css").read_text(encoding="utf-8")


def _parts(tree: Row) -> list[tuple[Node, ...]]:
    """Return the parts of a displayed formula, between which a line may end."""
    parts: list[list[Node]] = [[]]
    for node in tree.parts:
        if isinstance(node, Space) and node.width >= _QUAD:
            parts.append([])
        else:
            parts[-1].append(node)
    return [tuple(part) for part in parts if part]


def _visible(node: Node) -> str:
    match node:
        case Row(parts):
            return _row(parts)
        case Scripted():
            return _scripted(node)
        case Fraction(above, below):
            return _span("fraction", _span("above", _visible(above)) + _span("below", _visible(below)))
        case Root(content):
            drawn = _drawn("surd", "0 0 60 100", f'<path d="{_SURD}"/><path class="fx-stroke" d="{_SURD_STROKE}"/>')
            return _span("root", drawn + _span("content", _visible(content)))
        case Bracketed():
            return _bracketed(node)
        case Dotted(letter):
            dot = _span("over", _span(f"dot fx-{_height(letter)}", ""))
            return _span("dotted", _span("i", _DOTLESS.get(letter, letter)) + dot)
        case Integral():
            return _drawn("integral", "0 0 50 120", f'<path d="{_INTEGRAL}"/>')
        case Space(width):
            return _span({0.17: "thin", 0.28: "thick", 1.0: "quad", 2.0: "qquad"}[width], "")
        case _:
            return _text(node)


def _text(node: Letter | Function | Number | Words | Operator) -> str:
    match node:
        case Letter(letter):
            return _span("i", letter)
        case Function(name):
            return name
        case Number(text) | Words(text):
            return escape(text, quote=False)
        case Operator(sign, role):
            text = escape(sign, quote=False)
            return text if role in {Role.ORDINARY, Role.SIGN} else _span(role.value, text)


def _row(parts: tuple[Node, ...]) -> str:
    """Return elements side by side, with a thin space where the name of a function would touch its neighbours."""
    text = _visible(parts[0])
    for before, part in pairwise(parts):
        text += (_span("thin", "") if _needs_space(before, part) else "") + _visible(part)
    return text


def _needs_space(before: Node, part: Node) -> bool:
    if isinstance(before, Function):
        return not isinstance(part, Bracketed | Space | Operator | Scripted)
    return isinstance(part, Function) and not isinstance(before, Space | Operator)


def _scripted(node: Scripted) -> str:
    base = _visible(node.base)
    above, below = ("" if script is None else _visible(script) for script in (node.above, node.below))
    if not below and not above.strip(PRIME):
        return base + above
    if isinstance(node.base, Integral):
        return _span("limited", base + _span("limits", _span("upper", above) + _span("lower", below)))
    if above and below:
        return base + _span("stack", _span("upper", above) + _span("lower", below))
    name, script = ("sup", above) if above else ("sub", below)
    if is_tall(node.base):
        return _span(f"tall-{name}", _span("base", base) + _span(f"far-{name}", script))
    high = any(is_tall(row) for row in (node.above, node.below) if row)
    return base + _span(f"{name} fx-high" if high else name, script)


def _bracketed(node: Bracketed) -> str:
    content = _visible(node.content)
    if not is_tall(node.content):
        return f"{node.opening}{content}{node.closing}"
    left = _span(f"{_TALL_BRACKETS[node.opening]} fx-left", "")
    right = _span(f"{_TALL_BRACKETS[node.closing]} fx-right", "")
    return _span("bracketed", left + _span("content", content) + right)


def _height(letter: str) -> str:
    """Return how high a letter is, for the dot on it."""
    if letter.isupper():
        return "capital"
    return "ascender" if letter in "bdfhkltβδζθλξ" else "small"


def _drawn(name: str, box: str, paths: str) -> str:
    return _span(name, f'<svg viewBox="{box}" preserveAspectRatio="none">{paths}</svg>')


def _span(name: str, inside: str) -> str:
    return f'<span class="fx-{name}">{inside}</span>'
