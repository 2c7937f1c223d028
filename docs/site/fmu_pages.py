"""Pages of the reference for the FMUs: the manual that each FMU carries, as a page of the site."""

from __future__ import annotations

import re
from functools import cache
from html import unescape

from fmu_src.fmus import MODELS
from fmu_src.page.page import documentation_page
from fmu_src.schema import Model, Packaging

NONE = "\N{EN DASH}"
_NUMBERED = re.compile(r"\b(model|cures) (\d+)")
_HEADING = re.compile(r"<h([23])[^>]*>(.*?)</h[23]>")
_REFERENCE = re.compile(r'(<(td class="reference"|span class="formula-label"))>([^<]*)')
_SHOWN = re.compile(r'<span class="formula-label">cures (\d+)')


def fmu_pages() -> dict[str, str]:
    """Return the pages by their path from the root of the site's sources."""
    pages = {f"reference/fmus/{name}.md": _page(model) for name, model in MODELS.items()}
    return {"reference/fmus.md": _index(), **pages}


def _index() -> str:
    lines = [
        "# FMUs",
        "",
        "The manual of each FMU, which its file holds too, as `documentation/index.html`: equations; variables with",
        "unit, start value and range; limits of validity. Outputs fit the inputs of the same name.",
        "",
        "```{table}",
        ":class: fmus",
        "",
        "| FMU | what it is | inputs | outputs |",
        "|---|---|---|---|",
    ]
    for name, model in MODELS.items():
        inputs, outputs = (
            " ".join(f"`{variable.name}`" for variable in model.select(causality)) for causality in ("input", "output")
        )
        lines.append(f"| [`{name}`](fmus/{name}.md) | {model.description} | {inputs or NONE} | {outputs} |")
    listed = "\n".join(f"fmus/{name}" for name in MODELS)
    return "\n".join([*lines, "```", "", f"```{{toctree}}\n:hidden:\n\n{listed}\n```", ""])


def _manual(model: Model) -> str:
    return documentation_page(model, Packaging.NATIVE).decode("utf-8")


def _page(model: Model) -> str:
    """Return the manual of an FMU as Markdown: headings as headings, so that the site knows them, the rest as HTML."""
    content = _manual(model).partition("</nav>")[2].partition("</body>")[0]
    before, *sections = _HEADING.split(content)
    lines = [f"# {model.name}", "", f"{model.description}.", "", *_raw(before, model.name)]
    for level, heading, text in zip(*(iter(sections),) * 3, strict=True):
        lines += [f"{'#' * int(level)} {unescape(heading)}", "", *_raw(text, model.name)]
    return "\n".join(lines)


def _raw(content: str, name: str) -> list[str]:
    """Return HTML of a manual as Markdown, with links where it names equations."""
    if not content.strip():
        return []

    def linked(found: re.Match[str]) -> str:
        shown = re.match(r"cures (\d+)", found[3]) if found[2].startswith("span") else None
        anchor = f' id="equation-{shown[1]}"' if shown else ""  # the manuals are where these are shown
        return f"{found[1]}{anchor}>{_NUMBERED.sub(lambda number: _link(number, name), found[3])}"

    text = _REFERENCE.sub(linked, content.strip())
    text = text.replace('href="licenses/', 'data-in-fmu="licenses/')  # a file of the FMU, not of the site
    return ["```{raw} html", f'<div class="manual">{text}</div>', "```", ""]


def _link(number: re.Match[str], name: str) -> str:
    """Return a link to an equation by its number: of the model's page, or of the manual that shows it."""
    if number[1] == "model":
        return f'<a href="../../model.html#equation-{number[2]}">{number[0]}</a>'
    shown = _showing()[number[2]]
    return f'<a href="{name if name in shown else shown[0]}.html#equation-{number[2]}">{number[0]}</a>'


@cache
def _showing() -> dict[str, list[str]]:
    """Return which manuals show an equation of the cures, by its number."""
    found: dict[str, list[str]] = {}
    for name, model in MODELS.items():
        for number in _SHOWN.findall(_manual(model)):
            found.setdefault(number, []).append(name)
    return found
