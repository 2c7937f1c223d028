"""Take what draws formulas in the browser, MathJax, from the package that package-lock.json names."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from fmu_src.errors import BuildError

_HERE = Path(__file__).parent
_LOCK = _HERE / "package-lock.json"
_PACKAGES = _HERE / "node_modules"
_MADE_FROM = _PACKAGES / ".made-from.json"


def take_mathjax(folder: Path) -> None:
    """Put the script and its fonts into a folder.

    Raises
    ------
    BuildError
        npm lacks, or the package cannot be had.
    """
    if not _MADE_FROM.is_file() or _MADE_FROM.read_bytes() != _LOCK.read_bytes():
        _install()
    mathjax = _PACKAGES / "mathjax" / "es5"
    fonts = Path("output", "chtml", "fonts", "woff-v2")
    folder.mkdir(parents=True)
    shutil.copyfile(mathjax / "tex-chtml.js", folder / "tex-chtml.js")
    shutil.copytree(mathjax / fonts, folder / fonts)


def _install() -> None:
    npm = shutil.which("npm")
    if npm is None:
        raise BuildError("npm is missing, which the site takes MathJax from; install Node.js 18 or later with npm")
    command = [npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund"]
    run = subprocess.run(command, cwd=_HERE, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        raise BuildError(f"MathJax cannot be had: npm ci ended with {run.returncode}:\n{run.stderr.strip()}")
    shutil.copyfile(_LOCK, _MADE_FROM)
