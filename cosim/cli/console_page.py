"""Open the driller's console, a page that runs in the browser with no server."""

from __future__ import annotations

import webbrowser
from pathlib import Path

from cosim.errors import InputError
from cosim.fmi2.locate import build_script

_BUILT = Path(__file__).parents[1] / "built" / "console.html"


def console_page() -> Path:
    """Return the file of the console: in a checkout the one that `make console` has built.

    Raises
    ------
    InputError
        If it has not been built.
    """
    script = build_script()
    page = _BUILT if script is None else script.parent / "build" / "console" / "console.html"
    if page.is_file():
        return page
    if script is None:
        raise InputError("this package was built without the console, for want of Node.js; expected a wheel with it")
    raise InputError("the console has not been built; `make console` builds it, with Node.js and npm")


def open_page(page: Path) -> None:
    """Open a page in the browser.

    Raises
    ------
    InputError
        If there is no browser to open it in.
    """
    if not webbrowser.open(page.as_uri()):
        raise InputError(f"no browser opens here; the console is the file {page}")
