"""The text of the documentation pages: paragraphs, names, formulas and commands."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from fmu_src.fmus import MODELS
from fmu_src.page.compiling import compiling
from fmu_src.page.prose import paragraphs, phrase
from fmu_src.page.typesetting import equation_html, formula_html


def test_names_formulas_and_signs_survive_in_text() -> None:
    expected = f"<code>WOB</code> &lt; {formula_html('v')} &amp; <strong>so</strong>"
    assert phrase("`WOB` < $v$ & **so**") == expected


def test_blank_lines_divide_paragraphs() -> None:
    text = paragraphs("One.\n\n$$ a = b $$ Eq. (1)\n\nTwo.")
    assert text == f"<p>One.</p>\n{equation_html('a = b', 'Eq. (1)')}\n<p>Two.</p>"


def test_a_formula_in_text_that_is_not_understood_is_refused() -> None:
    with pytest.raises(ValueError, match="formula"):
        phrase(r"with $\frac{a}$")


def test_a_name_alone_is_a_command() -> None:
    assert paragraphs("Run\n\n`cc -o a a.c`") == "<p>Run</p>\n<pre><code>cc -o a a.c</code></pre>"


@pytest.mark.parametrize("name", MODELS)
def test_every_fmu_states_use_equations_and_limits_in_well_formed_html(name: str) -> None:
    model = MODELS[name]
    assert model.use
    assert model.equations
    assert model.limits
    for text in (model.verdict, *model.use, *(text for _, text in model.equations), *model.limits, compiling(model)):
        ElementTree.fromstring(f"<div>{text}</div>")
