"""What the site adds to Sphinx: anchors for the equations that carry a number, and docstrings with bars in them."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from docutils import nodes
from pygments.lexers import find_lexer_class_by_name
from sphinx.transforms import SphinxTransform

if TYPE_CHECKING:
    from sphinx.application import Sphinx

_TAG = re.compile(r"\\tag\{([^}]+)\}")


class NumberedEquations(SphinxTransform):
    r"""Give a displayed formula with ``\tag{5}`` the anchor ``equation-5``, so that other pages can point to it."""

    default_priority = 400

    def apply(self, **_: Any) -> None:
        """Set a target before each such formula of the page."""
        for formula in list(self.document.findall(nodes.math_block)):
            for number in _TAG.findall(formula.astext()):
                name = f"equation-{number}"
                target = nodes.target("", "", ids=[name], names=[name])
                self.document.note_explicit_target(target)
                formula.parent.insert(formula.parent.index(formula), target)


def escape_bars(text: str) -> str:
    """Return text of a docstring in which the bars of ``|x|`` are bars, and not those of a substitution."""
    return re.sub(r"(``.*?``)|\|", lambda found: found[1] or r"\|", text)


def _take_docstring(_app: Sphinx, _what: str, _name: str, _object: object, _options: object, lines: list[str]) -> None:
    lines[:] = escape_bars("\n".join(lines)).split("\n")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register this with Sphinx."""
    app.add_transform(NumberedEquations)
    app.add_lexer("csv", find_lexer_class_by_name("text"))
    app.connect("autodoc-process-docstring", _take_docstring, priority=900)  # after numpydoc
    return {"parallel_read_safe": True, "parallel_write_safe": True}
