"""Pages of the reference for Python: one for each public module, with all that it is for others to use."""

from __future__ import annotations

import inspect
from importlib import import_module
from types import ModuleType

from .extension import escape_bars

PUBLIC: dict[str, tuple[str, ...]] = {
    "Running": ("cosim", "cosim.check"),
    "Drilling": (
        "cosim.drilling.oscillation",
        "cosim.drilling.energy",
        "cosim.drilling.energy_growth",
        "cosim.drilling.severity",
        "cosim.drilling.severity_map",
        "cosim.drilling.map_figure",
        "cosim.drilling.maps",
        "cosim.league.entries",
        "cosim.league.playing",
        "cosim.sweeps.distributions",
    ),
    "Theory": (
        "models.theory",
        "models.theory.stability.equilibrium",
        "models.theory.stability.torque_curve",
        "models.theory.stability.spectrum",
        "models.theory.stability.chart",
        "models.theory.stability.driven_top",
        "models.theory.stability.characteristic",
        "models.theory.stability.difference",
        "models.theory.stability.linear_neutral",
        "models.theory.stability.neutral_form",
        "models.theory.stability.normalised_form",
        "models.theory.cycle.cycle",
        "models.theory.cycle.continuation",
        "models.theory.cycle.bistability",
        "models.theory.cycle.floquet",
        "models.theory.loop_set",
        "models.theory.lawful_energy",
    ),
    "Models": (
        "models.plant.parameters",
        "models.plant.neutral",
        "models.plant.distributed",
        "models.plant.friction",
        "models.controllers.laws",
        "models.controllers.virtual_drive",
        "models.controllers.delay",
        "models.controllers.speed_pid",
        "models.controllers.top_drive",
        "models.controllers.observer",
        "models.controllers.supervisor",
        "models.controllers.telemetry",
        "models.controllers.autodriller",
        "models.controllers.program",
    ),
}
"""Modules that users import from, by what they are for; in an installed package, `models` is `cosim.models`."""


def python_pages() -> dict[str, str]:
    """Return the pages by their path from the root of the site's sources."""
    pages = {f"reference/python/{name}.md": _page(import_module(name)) for group in PUBLIC.values() for name in group}
    return {"reference/python.md": _index(), **pages}


def public_names(module: ModuleType) -> list[str]:
    """Return what a module is for others to use: what it exports, else the functions and classes written in it."""
    exported: list[str] | None = getattr(module, "__all__", None)
    if exported is not None:
        return [
            name for name in exported if inspect.isroutine(found := getattr(module, name)) or inspect.isclass(found)
        ]
    return [
        name
        for name, found in vars(module).items()
        if not name.startswith("_")
        and getattr(found, "__module__", None) == module.__name__
        and (inspect.isroutine(found) or inspect.isclass(found))
    ]


def _index() -> str:
    lines = [
        "# Python",
        "",
        "What there is to import, by module. In an installed package `models` is `cosim.models`; all else is the same.",
        "",
    ]
    for title, names in PUBLIC.items():
        lines += [f"## {title}", "", "| module | what it is for |", "|---|---|"]
        for name in names:
            about = inspect.cleandoc(import_module(name).__doc__ or "").partition("\n\n")[0].replace("\n", " ")
            lines.append(f"| [`{name}`](python/{name}.md) | {about} |")
        listed = "\n".join(f"python/{name}" for name in names)
        lines += ["", f"```{{toctree}}\n:hidden:\n:caption: {title}\n\n{listed}\n```", ""]
    return "\n".join(lines)


def _page(module: ModuleType) -> str:
    names = public_names(module)
    about = escape_bars(inspect.cleandoc(module.__doc__ or ""))
    listed = "\n".join(f"    {name}" for name in names)
    described = "\n".join(
        f".. auto{'class' if inspect.isclass(getattr(module, name)) else 'function'}:: {name}\n"
        + ("    :members:\n" if inspect.isclass(getattr(module, name)) else "")
        for name in names
    )
    return "\n".join(
        [
            f"# {module.__name__}",
            "",
            "```{eval-rst}",
            about,
            "",
            f".. currentmodule:: {module.__name__}",
            "",
            ".. autosummary::",
            "    :nosignatures:",
            "",
            listed,
            "",
            described,
            "```",
            "",
        ]
    )
