"""Write the tree of a formula as MathML, which screen readers speak."""

from __future__ import annotations

from html import escape

from .formula import (
    INTEGRAL,
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

_APPLICATION = "<mo>&#8289;</mo>"
"""The invisible operator between a function and what it is of."""


def mathml(node: Node) -> str:
    """Return an element of a formula as what stands inside a ``math`` element."""
    match node:
        case Row(parts):
            inside = "".join(map(mathml, parts))
            return inside if len(parts) == 1 else f"<mrow>{inside}</mrow>"
        case Scripted():
            return _scripted(node)
        case Fraction(above, below):
            return f"<mfrac>{mathml(above)}{mathml(below)}</mfrac>"
        case Root(content):
            return f"<msqrt>{mathml(content)}</msqrt>"
        case Bracketed(opening, content, closing):
            return f"<mrow>{_operator(opening)}{mathml(content)}{_operator(closing)}</mrow>"
        case Dotted(letter):
            return f"<mover><mi>{letter}</mi><mo>\N{DOT ABOVE}</mo></mover>"
        case Letter(letter):
            return f"<mi>{letter}</mi>"
        case Function(name):
            return f"<mi>{name}</mi>{_APPLICATION}"
        case Number(digits):
            return f"<mn>{digits}</mn>"
        case Words(words):
            return f"<mtext>{escape(words)}</mtext>"
        case Operator(sign, role):
            return f"<mi>{sign}</mi>" if role is Role.ORDINARY and not sign.isascii() else _operator(sign)
        case Integral():
            return _operator(INTEGRAL)
        case Space(width):
            return f'<mspace width="{width:g}em"></mspace>'


def _operator(sign: str) -> str:
    return f"<mo>{escape(sign)}</mo>"


def _scripted(node: Scripted) -> str:
    if isinstance(node.base, Function):  # what it is of follows its scripts
        return _with_scripts(f"<mi>{node.base.name}</mi>", node) + _APPLICATION
    return _with_scripts(mathml(node.base), node)


def _with_scripts(base: str, node: Scripted) -> str:
    if node.above is None:
        return f"<msub>{base}{'' if node.below is None else mathml(node.below)}</msub>"
    if node.below is None:
        return f"<msup>{base}{mathml(node.above)}</msup>"
    return f"<msubsup>{base}{mathml(node.below)}{mathml(node.above)}</msubsup>"
