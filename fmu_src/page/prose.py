r"""Text of the documentation pages: paragraphs with `names` between backticks and $formulas$ between dollar signs.

A paragraph that reads ``$$ formula $$ label`` is a displayed equation with a label such as "Eq. (3)" at its right; one
that is a name alone is a command.
"""

from __future__ import annotations

import re
from html import escape

from .typesetting import equation_html, formula_html

_DISPLAYED = re.compile(r"\$\$(.+)\$\$\s*([^$]*)", re.DOTALL)
_COMMAND = re.compile(r"`([^`]+)`")
_MARKED = re.compile(r"\$([^$]+)\$|`([^`]+)`|\*\*([^*]+)\*\*")

Sections = tuple[tuple[str, str], ...]
"""Headings and HTML text."""


def paragraphs(text: str) -> str:
    """Return paragraphs, which blank lines divide, as HTML."""
    return "\n".join(_paragraph(part) for part in re.split(r"\n\s*\n", text.strip()))


def phrase(text: str) -> str:
    """Return a text without paragraphs as HTML."""
    parts: list[str] = []
    position = 0
    for match in _MARKED.finditer(text):
        formula, name, strong = match.groups()
        parts.append(escape(text[position : match.start()], quote=False))
        if formula:
            parts.append(formula_html(formula))
        else:
            parts.append(f"<code>{escape(name)}</code>" if name else f"<strong>{escape(strong)}</strong>")
        position = match.end()
    return "".join(parts) + escape(text[position:], quote=False)


def phrases(*texts: str) -> tuple[str, ...]:
    """Return texts without paragraphs, the items of a list, as HTML."""
    return tuple(phrase(text) for text in texts)


def _paragraph(text: str) -> str:
    command = _COMMAND.fullmatch(text)
    if command is not None:
        return f"<pre><code>{escape(command[1])}</code></pre>"
    displayed = _DISPLAYED.fullmatch(text)
    if displayed is None:
        return f"<p>{phrase(text)}</p>"
    return equation_html(*displayed.groups())
