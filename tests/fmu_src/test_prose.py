"""The documentation pages: formulas become MathML, and a formula that cannot is refused."""

from __future__ import annotations

from xml.etree import ElementTree

import pytest

from fmu_src.fmus import MODELS
from fmu_src.page.compiling import compiling
from fmu_src.page.mathml import mathml
from fmu_src.page.prose import paragraphs, phrase


def test_a_formula_becomes_mathml() -> None:
    assert (
        mathml(r"\frac{c_a}{Z}")
        == "<mfrac><mrow><msub><mi>c</mi><mi>a</mi></msub></mrow><mrow><mi>Z</mi></mrow></mfrac>"
    )
    assert mathml("x^2_b") == "<msubsup><mi>x</mi><mi>b</mi><mn>2</mn></msubsup>"
    assert mathml(r"a \le 0.5 \, \text{ms}").startswith("<mi>a</mi><mo>\N{LESS-THAN OR EQUAL TO}</mo><mn>0.5</mn>")


@pytest.mark.parametrize("formula", [r"\frac{a}", "a}", "{a", r"\unheard", r"\dot y", "x_"])
def test_a_formula_that_is_not_understood_is_refused(formula: str) -> None:
    with pytest.raises(ValueError, match="formula"):
        mathml(formula)


def test_names_formulas_and_signs_survive_in_text() -> None:
    assert phrase("`WOB` < $v$ & **so**") == "<code>WOB</code> &lt; <math><mi>v</mi></math> &amp; <strong>so</strong>"


def test_blank_lines_divide_paragraphs() -> None:
    text = paragraphs("One.\n\n$$ a = b $$ Eq. (1)\n\nTwo.")
    assert text.startswith("<p>One.</p>\n<div")
    assert "Eq. (1)" in text
    assert text.endswith("\n<p>Two.</p>")


def test_a_name_alone_is_a_command() -> None:
    assert paragraphs("Run\n\n`cc -o a a.c`") == "<p>Run</p>\n<pre><code>cc -o a a.c</code></pre>"


@pytest.mark.parametrize("name", MODELS)
def test_every_fmu_states_use_equations_and_limits_in_well_formed_html(name: str) -> None:
    model = MODELS[name]
    assert model.use
    assert model.equations
    assert model.limits
    for text in (model.verdict, *model.use, *(text for _, text in model.equations), *model.limits, compiling(model)):
        ElementTree.fromstring(f"<div>{text.replace('&#8289;', '')}</div>")
