"""Draw finished runs from their folders into one figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cosim.errors import InputError, OutputError
from cosim.files import why

if TYPE_CHECKING:
    from cosim.drilling.reporting import Looks
    from cosim.recording.result import Result

_USUAL = "plot"


def draw_runs(
    folders: Sequence[Path],
    signals: Sequence[str],
    variants: Sequence[str],
    looks: Looks,
    kind: str | None,
    output: Path | None,
) -> Path:
    """Draw runs into a file, and return its path.

    Parameters
    ----------
    folders : sequence of Path
        Of finished runs.
    signals, variants : sequence of str
        What to show, by default of the bit where there is one, and of which variants, by default all.
    looks : Looks
        Times, units, and whether the runs lie over each other.
    kind : str, optional
        ``"png"``, ``"svg"`` or ``"pdf"``, by default as the file's name ends.
    output : Path, optional
        The file, by default ``plot`` with that ending.

    Raises
    ------
    InputError
        If a folder holds no finished run, or no such variant or signal, or the figure cannot be written.
    """
    from cosim.drilling.reporting import view_of
    from cosim.recording.figure import draw

    target = output or Path(f"{_USUAL}.{kind or 'png'}")
    if kind is not None and target.suffix != f".{kind}":
        raise InputError(f"{target}: expected a name that ends in .{kind}, as --format says")
    results = _results(folders, variants)
    try:
        draw(target, "", results, view_of(next(iter(results.values())), signals, **looks))
    except OSError as error:
        raise OutputError(f"{target} cannot be written: {why(error)}") from error
    return target


def _results(folders: Sequence[Path], variants: Sequence[str]) -> dict[str, Result]:
    """Open runs by what tells them apart: the names of folders, where there are several, and of variants."""
    from cosim.run.opened import open_run, open_variants

    found: dict[str, Result] = {}
    for folder in folders:
        opened = {name: open_run(folder, name) for name in variants} or open_variants(folder)
        several = len(opened) > 1 or bool(variants)
        for name, result in opened.items():
            label = name if len(folders) == 1 else f"{folder}, {name}" if several else str(folder)
            found[label] = result
    return found
