"""The gallery: every scenario that comes with the package, run while the site is made, with its picture."""

from __future__ import annotations

import logging
from pathlib import Path

from cosim import load_scenario, scenario_names, simulate
from cosim.drilling.reporting import draw
from cosim.scenario.scenario import Scenario


def gallery(folder: Path) -> str:
    """Draw the scenarios, as `cosim run` does, into `gallery/` of a folder, and return the page that shows them."""
    logging.getLogger("cosim").setLevel(logging.ERROR)  # what a run says beside its results is not for this page
    (folder / "gallery").mkdir(parents=True)
    lines = [
        "# Gallery",
        "",
        "The scenarios that come with `cosim`, those after the paper's figures first. Each picture is what the command",
        "above it draws, and was drawn when this site was made. [The scenarios](scenarios.md) has the numbers.",
        "",
    ]
    scenarios = {name: load_scenario(name) for name in scenario_names()}
    for name, scenario in sorted(scenarios.items(), key=_figure):
        _draw(scenario, folder / "gallery" / f"{name}.png")
        lines += [f"## {scenario.title}", "", scenario.description.strip(), "", f"```sh\ncosim run {name}\n```", ""]
        lines += [f"![{scenario.title}](gallery/{name}.png)", ""]
    return "\n".join(lines)


def _figure(named: tuple[str, Scenario]) -> str:
    """Return what sorts scenarios by the figure of the paper in their title, those without one last."""
    return named[1].title.partition("(Fig. ")[2] or "none"


def _draw(scenario: Scenario, path: Path) -> None:
    """Run all variants of a scenario, and draw them."""
    variants = [each.name for each in scenario.variants] or [None]
    results = {each or scenario.name: simulate(scenario, variant=each) for each in variants}
    draw(path, scenario.title, results, scenario.signals)
