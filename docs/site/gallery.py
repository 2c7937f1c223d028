"""The gallery: every scenario that comes with the package, run while the site is made, with its picture."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from cosim import load_scenario, scenario_names


def gallery(folder: Path) -> str:
    """Run the scenarios, leave their pictures in `gallery/` of a folder, and return the page that shows them.

    Raises
    ------
    subprocess.CalledProcessError
        A scenario does not run.
    """
    pictures = folder / "gallery"
    pictures.mkdir(parents=True)
    lines = ["# Gallery", "", "Each picture is what `cosim run NAME` draws; all were drawn when this site was made.", ""]
    for name in scenario_names():
        run = folder.parent / "runs" / name
        command = [sys.executable, "-m", "cosim", "run", name, "--output", str(run)]
        subprocess.run(command, check=True, capture_output=True, text=True)
        (run / "figure.png").replace(pictures / f"{name}.png")
        scenario = load_scenario(name)
        lines += [f"## {scenario.title}", "", f"```sh\ncosim run {name}\n```", ""]
        lines += [f"![{scenario.title}](gallery/{name}.png)", ""]
    return "\n".join(lines)
