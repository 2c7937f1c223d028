"""Formulas: what is read, what is refused, and what is written of them for the eye, the ear and the clipboard."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from fmu_src.fmus import MODELS
from fmu_src.page.formula import (
    Bracketed,
    Fraction,
    Function,
    Letter,
    Number,
    Operator,
    Role,
    Row,
    Scripted,
    is_tall,
    read_formula,
)
from fmu_src.page.linear import linear
from fmu_src.page.mathml import mathml
from fmu_src.page.typesetting import equation_html, formula_css, formula_html


def roles(latex: str) -> list[str]:
    return [part.role.value for part in read_formula(latex).parts if isinstance(part, Operator)]


def test_a_formula_is_read_into_a_tree() -> None:
    a, z = Letter("a"), Letter("Z")
    assert read_formula(r"\frac{c_a}{2 Z}") == Row(
        (Fraction(Row((Scripted(Letter("c"), Row((a,)), None),)), Row((Number("2"), z))),)
    )
    assert read_formula("x^2_b") == Row((Scripted(Letter("x"), Row((Letter("b"),)), Row((Number("2"),))),))
    assert read_formula(r"\max(a, Z)") == Row(
        (Function("max"), Bracketed("(", Row((a, Operator(",", Role.PUNCTUATION), z)), ")"))
    )


def test_a_minus_is_a_sign_where_there_is_nothing_to_subtract_from() -> None:
    assert roles("-a - b") == ["sign", "binary"]
    assert roles("a = -b + -c") == ["relation", "sign", "binary", "sign"]
    assert roles(r"a, \quad -b") == ["punctuation", "sign"]
    assert roles(r"\sgn -a / -b") == ["sign", "ordinary", "sign"]
    assert roles(r"\partial - \infty") == ["ordinary", "binary", "ordinary"]
    for latex in ("(-a)", "e^{-a}", "e^-", r"\frac{-a}{b}"):
        assert '"fx-binary"' not in formula_html(latex), latex


@pytest.mark.parametrize(
    ("latex", "sentence"),
    [
        (" ", "formula '': it is empty"),
        (r"\frac{a}", r"formula '\\frac{a}': something is missing after '\\frac'"),
        ("a}", "formula 'a}': '}' closes what was never opened"),
        ("a)", "formula 'a)': ')' closes what was never opened"),
        ("{a", "formula '{a': a brace is never closed"),
        ("{a)}", "formula '{a)}': a brace is closed by ')'"),
        ("(a", "formula '(a': a '(' is never closed"),
        ("(a}", "formula '(a}': a '(' is closed by '}'"),
        ("|a", "formula '|a': a '|' is never closed"),
        ("()", "formula '()': nothing follows '('"),
        (r"\sqrt{}", r"formula '\\sqrt{}': braces hold nothing"),
        (r"\unheard", r"formula '\\unheard': '\\unheard' is not known"),
        (r"\text", r"formula '\\text': '\\text' is not known"),
        ("a # b", "formula 'a # b': '#' is not known"),
        (r"\dot{a b}", r"formula '\\dot{a b}': \dot stands on something else than one letter"),
        (r"\dot 2", r"formula '\\dot 2': \dot stands on something else than one letter"),
        ("x_", "formula 'x_': something is missing after '_'"),
        ("x_a_b", "formula 'x_a_b': two '_' follow one element"),
        ("^2", "formula '^2': '^' follows no element"),
        ("'", '"\'": "\'" follows no element'),
    ],
)
def test_a_formula_that_is_not_understood_is_refused(latex: str, sentence: str) -> None:
    with pytest.raises(ValueError, match=re.escape(sentence)):
        read_formula(latex)


def test_greek_letters_are_known_by_their_names() -> None:
    letters = [r"\alpha", r"\beta", r"\lambda", r"\Lambda", r"\omega", r"\Omega", r"\Upsilon"]
    assert linear(read_formula(" ".join(letters))) == "α β λ Λ ω Ω Υ"


def test_brackets_know_whether_they_have_to_be_tall() -> None:
    for latex in (r"(\frac{a}{b})", r"|1 + (\frac{a}{b})^2|", r"[\sqrt{\frac{a}{b}}]", r"(\int a)"):
        assert is_tall(read_formula(latex)), latex
        assert "fx-bracketed" in formula_html(latex), latex
    for latex in ("(a / b)", r"(a^2_b)", r"|\dot{y}|", r"(\sqrt{a})"):
        assert not is_tall(read_formula(latex)), latex
        assert "fx-bracketed" not in formula_html(latex), latex


@pytest.mark.parametrize(
    ("latex", "expected"),
    [
        (r"\frac{c_a}{Z}", "<mfrac><msub><mi>c</mi><mi>a</mi></msub><mi>Z</mi></mfrac>"),
        ("x^2_b", "<msubsup><mi>x</mi><mi>b</mi><mn>2</mn></msubsup>"),
        ("e^{-t}", "<msup><mi>e</mi><mrow><mo>\N{MINUS SIGN}</mo><mi>t</mi></mrow></msup>"),
        (r"\sqrt{I G}", "<msqrt><mrow><mi>I</mi><mi>G</mi></mrow></msqrt>"),
        (r"\dot{y}", "<mover><mi>y</mi><mo>\N{DOT ABOVE}</mo></mover>"),
        ("U'", "<msup><mi>U</mi><mi>\N{PRIME}</mi></msup>"),
        (
            r"a \le 0.5 \, \text{ms}",
            "<mrow><mi>a</mi><mo>\N{LESS-THAN OR EQUAL TO}</mo><mn>0.5</mn>"
            '<mspace width="0.17em"></mspace><mtext>ms</mtext></mrow>',
        ),
        ("a < b", "<mrow><mi>a</mi><mo>&lt;</mo><mi>b</mi></mrow>"),
        (r"\exp(x)", "<mrow><mi>exp</mi><mo>&#8289;</mo><mrow><mo>(</mo><mi>x</mi><mo>)</mo></mrow></mrow>"),
        (r"\sin^2 x", "<mrow><msup><mi>sin</mi><mn>2</mn></msup><mo>&#8289;</mo><mi>x</mi></mrow>"),
    ],
)
def test_a_screen_reader_is_given_mathml(latex: str, expected: str) -> None:
    assert mathml(read_formula(latex)) == expected
    assert f"<math>{expected}</math>" in formula_html(latex)


@pytest.mark.parametrize(
    ("latex", "expected"),
    [
        (r"\mu_b(v) = \mu_{cb} + c e^{-(\gamma_b / v_f) |v|}", "μ_b(v) = μ_cb + c e^(−(γ_b/v_f)|v|)"),
        (r"U = \frac{1}{2} (y - \frac{\tau}{2 Z}),", "U = 1/2 (y − τ/(2 Z)),"),
        (r"\frac{\partial^2 \theta}{\partial t^2}", "(∂^2 θ)/(∂t^2)"),
        (r"\Gamma = L \sqrt{\frac{I}{G J}}", "Γ = L √(I/(G J))"),
        (r"\frac{\Gamma}{N} \le 0.5 \, \text{ms}", "Γ/N ≤ 0.5 ms"),
        (r"\dot{y} - U' = -T_{\text{ref}} \sgn \, v", "ẏ − U′ = −T_ref sgn v"),
    ],
)
def test_a_copied_formula_is_a_line_of_text(latex: str, expected: str) -> None:
    assert linear(read_formula(latex)) == expected
    assert f'<span class="fx-marked">{expected}</span></span></span>' in formula_html(latex)


def test_functions_keep_their_distance_from_letters_and_not_from_brackets() -> None:
    thin = '<span class="fx-thin"></span>'
    assert f"{thin}sgn{thin}" in formula_html(r"a \sgn v")
    for latex in (r"\max(a, b)", r"\sgn \quad v", r"= \exp(v)"):
        assert thin not in formula_html(latex), latex


def test_a_label_is_text_and_need_not_be() -> None:
    assert equation_html("a", "a < b").endswith('<span class="formula-label">a &lt; b</span></div>')
    assert "formula-label" not in equation_html("a", "")


def test_the_style_sheet_knows_every_class_and_no_one_elses() -> None:
    pages = [text for model in MODELS.values() for _, text in model.equations]
    more = (
        r"[\frac{a}{b}]_0 + |\frac{a}{b}|^2 + x^{\frac{a}{b}} + x_{\frac{a}{b}}",
        r"\dot{b} \; \dot{U} \quad \qquad a",
    )
    pages += [formula_html(latex) for latex in more]
    used = {
        name
        for page in pages
        for element in ElementTree.fromstring(f"<div>{page}</div>").iter()
        for name in element.get("class", "").split()
    }
    known = set(re.findall(r"\.([a-z][a-z-]*)", re.sub(r"/\*.*?\*/", "", formula_css(), flags=re.DOTALL)))
    assert used <= known
    assert [name for name in known if not name.startswith(("formula", "fx-"))] == []


def test_letters_are_those_of_any_font() -> None:
    for model in MODELS.values():
        for _, text in model.equations:
            assert max(map(ord, text)) < 0x10000, model.name
