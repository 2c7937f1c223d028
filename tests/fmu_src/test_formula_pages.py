"""Formulas in a browser, by the places of their boxes and the ink of their glyphs, whatever the font."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from fmu_src.fmus import MODELS
from fmu_src.page.page import documentation_page
from fmu_src.page.typesetting import equation_html, formula_css, formula_html
from fmu_src.schema import Packaging

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

EXAMINE = Path(__file__).with_name("formula_geometry.js").read_text(encoding="utf-8")
HARD = (
    r"x_{\frac{a}{b}}^{\frac{c}{d}} + e^{-\frac{t}{\tau}}",
    r"\frac{\frac{a_b^2}{c}}{1 + \frac{1}{x}}",
    r"\sqrt{x_f} \sqrt{1 + \sqrt{\frac{a}{b}}}",
    r"(\frac{a}{b})_0 + [\frac{a}{b}]^{2 n}",
    r"\frac{\dot{U}_b^2}{\dot{\theta}} \dot{f} \dot{J} \dot{i} \dot{\Omega}",
    r"\exp(-\frac{x}{2}) \ln x - \sin x",
    r"|\frac{(\frac{a}{b} + 1)^2}{c}|",
    r"\int_0^{\infty} f(x) \, dx + f(f) + T(T) U^U V_V W^W_W f_b^2",
)
"""Formulas harder than those of the FMUs."""

pytestmark = pytest.mark.slow


@pytest.fixture
def page(browser: Browser) -> Generator[Page]:
    """A page with every formula of every FMU and the hard ones, displayed and within a line."""
    parts = [text for model in MODELS.values() for text in (model.verdict, *model.use, *model.limits)]
    parts += [text for model in MODELS.values() for _, section in model.equations for text in section.split("\n")]
    parts += [equation_html(latex, "Eq. (1)") for latex in HARD]
    parts += [f"<p>So much for {formula_html(latex)}, and on.</p>" for latex in HARD]
    style = f"body {{ font: 16px/1.6 sans-serif; }} {formula_css()} .formula.formula {{ font-family: var(--tried); }}"
    context = browser.new_context(viewport={"width": 900, "height": 900}, device_scale_factor=3)
    opened = context.new_page()
    opened.set_content(f"<!DOCTYPE html><style>{style}</style>{''.join(dict.fromkeys(parts))}")
    yield opened
    context.close()


@pytest.mark.parametrize("font", ["Liberation Serif", "DejaVu Serif", "DejaVu Sans"])
def test_a_formula_is_set_right_in_any_font(page: Page, font: str) -> None:
    page.evaluate("font => document.body.style.setProperty('--tried', `'${font}'`)", font)
    found = page.evaluate(EXAMINE)
    assert found.pop("wrong") == []
    assert min(found.values()) > 10, found


@pytest.mark.parametrize("medium", ["screen", "print"])
def test_a_page_shows_its_formulas_once_and_keeps_them_in_their_columns(browser: Browser, medium: str) -> None:
    context = browser.new_context(viewport={"width": 390, "height": 800}, device_scale_factor=3, color_scheme="dark")
    page = context.new_page()
    page.emulate_media(media="print" if medium == "print" else "screen")
    for name in ("DissipativeLaw", "DrillstringNeutral", "SpeedPid"):
        page.set_content(documentation_page(MODELS[name], Packaging.NATIVE).decode())
        assert page.evaluate(EXAMINE)["wrong"] == []
        scrolled = "[...document.querySelectorAll('.formula-room')].filter(room => room.scrollWidth > room.clientWidth)"
        assert page.evaluate(f"{scrolled}.length") == (1 if name == "DissipativeLaw" else 0)
        if medium == "screen":
            assert page.evaluate("document.documentElement.scrollWidth") == 390
            assert page.evaluate(f"{scrolled}.every(room => getComputedStyle(room).overflowX === 'auto')")
    context.close()


def test_a_formula_does_not_push_lines_apart(browser: Browser) -> None:
    page = browser.new_page(viewport={"width": 200, "height": 800})
    text = " ".join(
        f"and so {formula_html(latex)}" for latex in (r"c_a", r"v^2", r"\dot{y}", r"x_b^2", r"e^{-\tau_0 / T}")
    )
    page.set_content(f"<style>{formula_css()}</style><p style='font: 16px/1.5 serif'>{text * 3}</p>")
    height = page.evaluate("document.querySelector('p').getBoundingClientRect().height")
    assert height >= 5 * 24
    assert height % 24 == 0
    page.close()


def test_what_is_copied_is_the_text_and_each_formula_once(browser: Browser) -> None:
    page = browser.new_page()
    inside = f"<p>With {formula_html(r'c_a')} (<code>c_a</code>),</p>"
    inside += equation_html(r"\frac{\partial \theta}{\partial t} = -\frac{T}{c_a}", "Eq. (2)")
    page.set_content(f"<style>{formula_css()}</style>{inside}")
    copied = page.evaluate("getSelection().selectAllChildren(document.body), getSelection().toString()")
    assert copied.split("\n") == ["With c_a (c_a),", "", "(∂θ)/(∂t) = −T/c_a", "Eq. (2)"]
    page.close()
