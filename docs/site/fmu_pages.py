"""Pages of the reference for the FMUs: the manual that each FMU carries, as a page of the site."""

from __future__ import annotations

import re

from lxml import html

from fmu_src.fmus import MODELS
from fmu_src.page.page import documentation_page
from fmu_src.schema import Model, Packaging

_NUMBERED = re.compile(r"\b(model|cures) (\d+)")
_REFERENCE = re.compile(r'(<(?:td|span) class="reference">)([^<]*)')


def fmu_pages() -> dict[str, str]:
    """Return the pages by their path from the root of the site's sources."""
    pages = {f"reference/fmus/{name}.md": _page(model) for name, model in MODELS.items()}
    return {"reference/fmus.md": _index(), **pages}


def manual_style() -> str:
    """Return the style of the manuals' formulas and tables, as it stands in them."""
    document = html.document_fromstring(documentation_page(next(iter(MODELS.values())), Packaging.NATIVE))
    return "\n".join(str(style.text) for style in document.iter("style"))


def _index() -> str:
    lines = [
        "# FMUs",
        "",
        "Each FMU carries this manual, as `documentation/index.html`. All is made from its interface table.",
        "",
        "| FMU | what it is | inputs | outputs |",
        "|---|---|---|---|",
    ]
    for name, model in MODELS.items():
        inputs, outputs = (
            " ".join(f"`{variable.name}`" for variable in model.select(causality)) for causality in ("input", "output")
        )
        lines.append(f"| [`{name}`](fmus/{name}.md) | {model.description} | {inputs or '–'} | {outputs} |")
    listed = "\n".join(f"fmus/{name}" for name in MODELS)
    return "\n".join([*lines, "", f"```{{toctree}}\n:hidden:\n\n{listed}\n```", ""])


def _page(model: Model) -> str:
    """Return the manual of an FMU as Markdown: headings as headings, so that the site knows them, the rest as HTML."""
    body = html.document_fromstring(documentation_page(model, Packaging.NATIVE)).body
    lines = [f"# {model.name}", "", f"{model.description}.", ""]
    written: list[str] = []
    for element in body.iterchildren():
        if element.tag in ("header", "nav"):
            continue
        if element.tag in ("h2", "h3"):
            lines += [*_raw(written), f"{'#' * int(element.tag[1])} {element.text_content()}", ""]
            written = []
        else:
            written.append(html.tostring(element, encoding="unicode", with_tail=False))
    return "\n".join([*lines, *_raw(written)])


def _raw(parts: list[str]) -> list[str]:
    if not parts:
        return []
    text = _REFERENCE.sub(lambda found: found[1] + _NUMBERED.sub(_linked, found[2]), "\n".join(parts))
    text = text.replace('href="licenses/', 'data-in-fmu="licenses/')  # a file of the FMU, not of the site
    return ["```{raw} html", f'<div class="manual">{text}</div>', "```", ""]


def _linked(found: re.Match[str]) -> str:
    return f'<a href="../../{found[1]}.html#equation-{found[2]}">{found[0]}</a>'
