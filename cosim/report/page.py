"""Write a report: one HTML file that needs nothing beside it.

Nothing in it acts upon a browser but two scripts, Bokeh's and the page's own, named by their hashes in the page's
content security policy, which allows no request. Every text is escaped, and what would lead a reader astray written
out.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cosim.errors import InputError, OutputError, printable, require
from cosim.files import replace_file, why
from cosim.report.diagram import shortened
from cosim.report.plots import script

_PAGE = Path(__file__).parent / "page"


def write_page(path: Path, template: str, content: Mapping[str, Any], title: str = "") -> None:
    """Write a page, which replaces a file that is there when it is complete.

    Parameters
    ----------
    path : Path
        The .html file.
    template : str
        Name of a template beside `page.html`.
    content : mapping
        What it takes; `title`, and `drawn`, what the script of the same name reads, None without one.
    title : str, optional
        By default that of the content.

    Raises
    ------
    InputError
        If the name does not end in .html, or a package is missing.
    OutputError
        If the file cannot be written.
    """
    if path.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"{path}: expected a name that ends in .html")
    text = page(template, content, title)
    try:
        replace_file(path, text.encode("utf-8"))
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {why(error)}") from error


def page(template: str, content: Mapping[str, Any], title: str = "") -> str:
    """Return a page; the same text each time."""
    jinja2 = require("jinja2", extra="report", purpose="a report")
    drawn: Mapping[str, Any] | None = content["drawn"]
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_PAGE),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
        finalize=_harmless,
    )
    markup = require("markupsafe", extra="report", purpose="a report").Markup
    own = (_own("page.js"), _own(Path(template).with_suffix(".js").name)) if drawn is not None else ()
    scripts = [] if drawn is None else [script(), "".join(own)]
    return environment.get_template(template).render(
        {**content, "title": title or content["title"]},
        style=markup(_own("page.css")),
        scripts=[markup(each) for each in scripts],
        hashes=[_hash(each) for each in scripts],
        data=None if drawn is None else markup(_in_script(drawn)),
        shortened=shortened,
    )


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
