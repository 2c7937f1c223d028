"""Write the report of finished runs or leagues: one HTML file that needs nothing beside it.

Nothing in it acts upon a browser but two scripts, Bokeh's and the page's own, named by their hashes in the page's
content security policy, which allows no request. Every text is escaped, and what would lead a reader astray written
out.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from cosim.errors import InputError, OutputError, printable, require
from cosim.files import replace_file, why
from cosim.league.table import ABOUT
from cosim.report import leagues, runs
from cosim.report.diagram import shortened
from cosim.report.plots import COLOURS, DARK_COLOURS, Plots, dash_of, script
from cosim.run.report import MANIFEST
from cosim.system.field_units import shown_in

_PAGE = Path(__file__).parent / "page"

_KINDS: dict[str, tuple[str, str, Callable[[Sequence[Path], str], dict[str, Any]]]] = {
    "run": (MANIFEST, "run.html", runs.gather),
    "league": (ABOUT, "league.html", leagues.gather),
}
"""By kind of folder: the file that makes it one, its template, and what gathers the page."""


def write_report(folders: Sequence[str | Path], output: str | Path, *, units: str = "si", title: str = "") -> Path:
    """Write a report of what some folders hold, which replaces a file that is there when it is complete.

    Parameters
    ----------
    folders : sequence of str or Path
        Of finished runs, as `cosim run` writes them, or of leagues.
    output : str or Path
        The .html file.
    units : str
        ``"si"`` or ``"field"``: see `cosim.system.field_units.shown_in`.
    title : str, optional
        By default that of what is reported.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If a folder holds no such thing, folders are of several kinds, or a package is missing.
    OutputError
        If the file cannot be written.
    """
    path = Path(output)
    if path.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"{path}: expected a name that ends in .html")
    text = report([Path(folder) for folder in folders], units, title)
    try:
        replace_file(path, text.encode("utf-8"))
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {why(error)}") from error
    return path


def report(folders: Sequence[Path], units: str = "si", title: str = "") -> str:
    """Return the report of what some folders hold; the same text each time.

    Raises
    ------
    InputError
        As `write_report` does.
    """
    shown_in("", units)
    jinja2 = require("jinja2", extra="report", purpose="a report")
    _, template, gather = _KINDS[_kind(folders)]
    content = gather(folders, units)
    plots: Plots | None = content["plots"]
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_PAGE), autoescape=True, trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True, undefined=jinja2.StrictUndefined, finalize=_harmless,
    )  # fmt: skip
    markup = require("markupsafe", extra="report", purpose="a report").Markup
    scripts = [] if plots is None else [script(), _own("page.js")]
    data = None if plots is None else markup(_in_script(plots.to_json()))
    return environment.get_template(template).render(
        {**content, "title": title or content["title"]},
        style=markup(_own("page.css")),
        scripts=[markup(each) for each in scripts],
        hashes=[_hash(each) for each in scripts],
        data=data,
        shortened=shortened,
        strokes=[] if plots is None else _strokes(len(plots.runs)),
    )


def _kind(folders: Sequence[Path]) -> str:
    """Return what the folders hold, all of them the same."""
    if not folders:
        raise InputError("there is nothing to report; expected a folder at least")
    found = {folder: _kind_of(folder) for folder in folders}
    first = found[folders[0]]
    for folder, kind in found.items():
        if kind != first:
            raise InputError(f"{folders[0]} holds a {first} and {folder} a {kind}; expected folders of one kind")
    return first


def _kind_of(folder: Path) -> str:
    """Return what a folder holds."""
    for kind, (mark, _, _) in _KINDS.items():
        if (folder / mark).is_file():
            return kind
    raise InputError(f"{folder} holds no finished run and no league; expected a folder that one was written to")


def _harmless(value: Any) -> Any:
    """Write out what would lead a reader astray, in a text that is no markup of ours."""
    return printable(value) if type(value) is str else value  # Markup is a str too


def _own(name: str) -> str:
    """Return a file of the page."""
    return (_PAGE / name).read_text(encoding="utf-8")


def _in_script(content: Any) -> str:
    """Write JSON so that nothing in it ends the script that it stands in."""
    text = json.dumps(content, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _hash(text: str) -> str:
    """Return the name of a script in a content security policy."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode('utf-8')).digest()).decode()}"


def _strokes(count: int) -> list[tuple[str, str, str]]:
    """Return the colours in light and dark, and the dashes, of each run's lines."""
    return [
        (COLOURS[run % len(COLOURS)], DARK_COLOURS[run % len(COLOURS)], " ".join(map(str, dash_of(run))))
        for run in range(count)
    ]
