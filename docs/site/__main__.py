"""Make the site: python -m docs.site [FOLDER] [CONSOLE], by default in build/site, with the console as it is built.

What is to be published is in html/ of the folder.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util.docutils import docutils_namespace

from fmu_src.console.page import BUILT, PAGE, build_page, is_built
from fmu_src.errors import BuildError
from fmu_src.page.typesetting import formula_css

from .commands import commands_page
from .fmu_pages import fmu_pages
from .gallery import gallery
from .kernel import FOLDER, steady_kernel
from .python_pages import python_pages
from .scripts import take_mathjax
from .staging import DOCS, ROOT, stage

_PARTS = ("source", "static", "extra", "html", "doctrees", FOLDER)
_OF_NOTEBOOKS = {"jupyter_execute", ".jupyter_cache"}
"""What MyST-NB writes beside html/ at times."""


def make(folder: Path, console: Path | None = None) -> Path:
    """Make the site anew in a folder, and return the folder that is to be published.

    Parameters
    ----------
    folder : Path
        A new one, or one of a site, which is removed.
    console : Path, optional
        The page of the console, if it has been built elsewhere.

    Raises
    ------
    BuildError
        The folder holds something else, Node or npm lacks, a package cannot be had, or Sphinx has complained.
    """
    others = {each.name for each in folder.iterdir()} - {*_PARTS, *_OF_NOTEBOOKS} if folder.is_dir() else set[str]()
    if others:
        raise BuildError(f"{folder} holds {min(others)}, which is no part of a site; expected a folder of its own")
    shutil.rmtree(folder, ignore_errors=True)
    sources, static, extra, pages, doctrees, ipython = (folder / part for part in _PARTS)
    stage(sources)
    for place, text in {
        **fmu_pages(),
        **python_pages(),
        "reference/commands.md": commands_page(),
        "gallery.md": gallery(sources),
    }.items():
        path = sources / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    take_mathjax(static / "mathjax")
    shutil.copyfile(DOCS / "site" / "site.css", static / "site.css")
    (static / "formula.css").write_text(formula_css(), encoding="utf-8")
    (extra / "console").mkdir(parents=True)
    shutil.copyfile(console or _console(), extra / "console" / "index.html")
    with steady_kernel(ipython):
        _run_sphinx(sources, pages, doctrees, {"html_static_path": [str(static)], "html_extra_path": [str(extra)]})
    return pages


def _console() -> Path:
    """Return the page of the console, built anew if it is not there or older than its sources."""
    return BUILT / PAGE if is_built() else build_page()


def _run_sphinx(sources: Path, pages: Path, doctrees: Path, settings: dict[str, object]) -> None:
    with docutils_namespace():
        app = Sphinx(sources, DOCS, pages, doctrees, "html", settings, freshenv=True, warningiserror=True)
        app.build()
    if app.statuscode:
        raise BuildError("the site is not made: see what Sphinx complains of above")
    (pages / ".buildinfo").unlink(missing_ok=True)


if __name__ == "__main__":
    given = [Path(each).resolve() for each in sys.argv[1:]]
    try:
        made = make(*(given or [ROOT / "build" / "site"]))
    except BuildError as error:
        sys.exit(f"error: {error}")
    print(f"wrote {made}/index.html")
