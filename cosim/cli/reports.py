"""Write a report of whatever some folders hold."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from cosim.errors import InputError
from cosim.league import table, told
from cosim.report import maps, runs
from cosim.report.page import write_page
from cosim.run.report import MANIFEST
from cosim.sweeps import told as sweep_pages
from cosim.sweeps.reading import MARK
from cosim.system.field_units import shown_in


def _sweeps(folders: Sequence[Path], units: str) -> dict[str, Any]:
    """Return what the page of some sweeps shows."""
    content = sweep_pages.gather(folders, units)
    return {**content, "drawn": maps.drawn(content["maps"])}


_KINDS: dict[str, tuple[str, str, Callable[[Sequence[Path], str], dict[str, Any]]]] = {
    "run": (MANIFEST, "run.html", runs.gather),
    "sweep": (MARK, "sweep.html", _sweeps),
    "league": (table.ABOUT, "league.html", told.gather),
}
"""By kind of folder: the file that makes it one, the template of its page, and what gathers what that shows."""


def write_report(folders: Sequence[str | Path], output: str | Path, *, units: str = "si", title: str = "") -> Path:
    """Write a report of what some folders hold, which replaces a file that is there when it is complete.

    Parameters
    ----------
    folders : sequence of str or Path
        Of finished runs, as `cosim run` writes them, of leagues, or stores of sweeps.
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
    shown_in("", units)
    places = [Path(folder) for folder in folders]
    _, template, gather = _KINDS[_kind(places)]
    path = Path(output)
    write_page(path, template, gather(places, units), title)
    return path


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
    raise InputError(f"{folder} holds no finished run, league or sweep; expected a folder that one was written to")
