"""Take what draws formulas in the browser, MathJax, from the package that package-lock.json names."""

from __future__ import annotations

import shutil
from pathlib import Path

from fmu_src.node import install_packages


def take_mathjax(folder: Path) -> None:
    """Put the script and its fonts into a folder.

    Raises
    ------
    BuildError
        npm lacks, or the package cannot be had.
    """
    mathjax = install_packages(Path(__file__).parent, "the site") / "mathjax" / "es5"
    fonts = Path("output", "chtml", "fonts", "woff-v2")
    folder.mkdir(parents=True)
    shutil.copyfile(mathjax / "tex-chtml.js", folder / "tex-chtml.js")
    shutil.copytree(mathjax / fonts, folder / fonts)
