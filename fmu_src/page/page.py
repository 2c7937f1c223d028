"""documentation/index.html of an FMU, made from its interface table."""

from __future__ import annotations

from math import isinf
from typing import cast

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from .. import project
from ..rows import UNITS
from ..schema import Causality, Model, Packaging, Variable
from .compiling import compiling
from .typesetting import formula_css

TITLES: tuple[tuple[str, Causality], ...] = (("Inputs", "input"), ("Outputs", "output"), ("Parameters", "parameter"))

CONTENTS = (
    ("use-it", "Use"),
    ("the-equations", "Equations"),
    ("the-variables", "Variables"),
    ("the-limits", "Limits of validity"),
    ("the-sources", "Sources"),
    ("the-references", "References"),
    ("the-licence", "Licence"),
)
"""Sections of the page by identifier; a hyphen keeps them apart from the variables, which are identifiers too."""

LIMITS: dict[Packaging, tuple[str, ...]] = {
    Packaging.NATIVE: (
        "A value out of its range or not finite is refused with fmi2Discard and changes nothing; so is a step that "
        "cannot be taken. An illegal call is refused with fmi2Error and changes nothing either.",
        "First derivatives of outputs by time are limits from the same side as the outputs. Where there are inputs, "
        "fmi2GetDirectionalDerivative tells how they act at once at a communication point, and in initialization mode "
        "how parameters act, too.",
        "The same inputs give the same bits on every platform, and the same as the python packaging.",
    ),
    Packaging.PYTHON: (
        "This packaging is made to be read: the sources are in resources/. To change it, edit the sources of the "
        "project and build it again, which gives the modules names of their own; FMUs in one process share modules "
        "of the same name.",
        "It needs Linux or Windows on x86-64 and an importer that runs in Python 3.11 or later, or that has loaded "
        "the library of one; no other package is needed. The importer must unpack it in a folder whose path holds "
        "nothing but ASCII letters, digits, blanks and the signs - _ . ~. Anywhere else, use the native packaging: "
        "same variables, same bits.",
        "The library of pythonfmu can refuse nothing but a step. A value out of its range or not finite, or an "
        "illegal call, is logged and changes nothing, and every step is refused with fmi2Discard until a fitting "
        "value has been set, or, after an illegal call, until a reset or a restored state. Outputs of a model that "
        "cannot be initialised are nan.",
        "Derivatives of inputs, of outputs, and of outputs by inputs are not supported.",
    ),
}


def documentation_page(model: Model, packaging: Packaging) -> bytes:
    """Return the page of a model in one packaging; it needs no other file and no network."""
    environment = Environment(
        loader=FileSystemLoader(project.SOURCES / "page"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=StrictUndefined,
    )
    groups = [(title, model.select(causality)) for title, causality in TITLES]
    native = packaging is Packaging.NATIVE
    text = environment.get_template("page.html").render(
        model=model,
        packaging=packaging.value,
        packaging_limits=LIMITS[packaging],
        contents=[entry for entry in CONTENTS if entry[0] not in _absent(model, packaging)],
        icon=project.icon(model.name).read_text(encoding="utf-8").strip(),
        compiling=compiling(model) if native else "",
        formula_css=formula_css(),
        groups=[(title, variables) for title, variables in groups if variables],
        unit=_unit,
        start=_start,
        shown=_shown,
        span=_span,
        project=project.NAME,
        version=project.version(),
        license=project.LICENSE,
    )
    return text.encode("utf-8")


def _absent(model: Model, packaging: Packaging) -> set[str]:
    """Return the sections the page of this model does not have."""
    empty = {"use-it": not model.use, "the-equations": not model.equations}
    return {name for name, absent in (empty | {"the-sources": packaging is Packaging.PYTHON}).items() if absent}


def _unit(variable: Variable) -> str:
    if variable.kind != "Real":
        return variable.kind
    return "\N{EN DASH}" if variable.unit in (None, "1") else str(variable.unit)


def _start(variable: Variable) -> str:
    match variable.kind:
        case "Enumeration":
            return variable.items[int(cast("int", variable.start)) - 1]
        case "String":
            return f'"{variable.start}"'
        case "Boolean":
            return str(variable.start).lower()
        case _:
            return _number(float(cast("float", variable.start)))


def _shown(variable: Variable) -> str:
    """Return the start value once more, in the display unit; empty if there is none."""
    for unit in UNITS:
        for display in unit.display:
            if (unit.name, display.name) == (variable.unit, variable.display) and variable.start:
                return f"{float(variable.start) * display.factor:.4g} {display.name}"
    return ""


def _span(variable: Variable) -> str:
    if variable.kind == "Enumeration":
        return " | ".join(variable.items)
    low, high = variable.bounds
    if isinf(low) and isinf(high):
        return "any"
    return f"{_number(low)} … {_number(high)}"


def _number(value: float) -> str:
    """Return the shortest text that is exactly the value, with a true minus sign."""
    if isinf(value):
        return "∞" if value > 0.0 else "\N{MINUS SIGN}∞"
    text = f"{value:g}" if float(f"{value:g}") == value else repr(value)
    return text.replace("e+0", "e").replace("e+", "e").replace("e-0", "e-").replace("-", "\N{MINUS SIGN}")
