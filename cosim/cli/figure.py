"""Draw finished runs from their folders, or what sweeps have kept over time, into one figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cosim.errors import InputError, OutputError
from cosim.files import why
from cosim.sweeps.reading import MARK
from cosim.system.field_units import in_unit

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
    places: tuple[Sequence[str], Sequence[float]] = ((), ()),
) -> Path:
    """Draw runs, or sweeps, into a file, and return its path.

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
    places : (sequence of str, sequence of float)
        Of sweeps: the point of the grid, ``name=value`` each, and which quantiles of samples, in per cent.

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
    stores = [folder for folder in folders if (folder / MARK).is_file()]
    if stores:
        return _draw_sweeps(stores, folders, signals, variants, looks, target, places)
    if places != ((), ()):
        raise InputError("--at and --quantile are for sweeps; expected stores of such")
    results = _results(folders, variants)
    try:
        draw(target, "", results, view_of(next(iter(results.values())), signals, **looks))
    except OSError as error:
        raise OutputError(f"{target} cannot be written: {why(error)}") from error
    return target


def _draw_sweeps(
    stores: Sequence[Path],
    folders: Sequence[Path],
    signals: Sequence[str],
    variants: Sequence[str],
    looks: Looks,
    target: Path,
    places: tuple[Sequence[str], Sequence[float]],
) -> Path:
    """Draw what sweeps have kept over time: bands of quantiles where they have samples, else lines."""
    from cosim.drilling.uncertainty import draw_bands
    from cosim.sweeps.reading import QUANTILES, SAMPLE, open_series, quantile_bands

    if len(stores) < len(folders):
        other = next(folder for folder in folders if folder not in stores)
        raise InputError(f"{other} is no store of a sweep, as {stores[0]} is; expected one kind of folders")
    if variants:
        raise InputError("--variant is for runs; a sweep is of one variant")
    for each in places[1]:
        if not 0.0 <= each <= 100.0:
            raise InputError(f"--quantile {each:g}: expected per cent, from 0 to 100")
    parts = [each / 100.0 for each in places[1]]
    found: dict[str, Any] = {}
    for store in stores:
        series = open_series(store)
        at: dict[str, Any] = {}
        for text in places[0]:
            name, value = _place(text, series)
            if name in at:
                raise InputError(f"--at {text}: {name} is given twice; expected each name once")
            at[name] = value
        sampled = SAMPLE in series.dims and SAMPLE not in at
        if parts and not sampled:
            raise InputError(
                f"{store} has no samples to take quantiles of; expected a sweep with --sample or --uncertain"
            )
        try:
            found[str(store)] = (
                quantile_bands(store, parts or QUANTILES, at) if sampled else open_series(store, at).load()
            )
        except (OSError, ValueError, RuntimeError) as error:  # the last of what unpacks numbers
            raise InputError(f"{store} cannot be read: {why(error)}") from error
    try:
        draw_bands(target, found, signals, **looks)
    except OSError as error:
        raise OutputError(f"{target} cannot be written: {why(error)}") from error
    return target


def _place(text: str, series: Any) -> tuple[str, Any]:
    """Read ``name=value``, a number with or without unit where the dimension has numbers."""
    name, equals, said = (part.strip() for part in text.partition("="))
    if not equals or not name or not said:
        raise InputError(f"--at {text}: expected the form component.variable=value")
    if name not in series.coords:
        return name, int(said) if said.isdecimal() else said
    if series[name].dtype.kind == "b":
        return name, {"true": True, "false": False}.get(said.lower(), said)
    if series[name].dtype.kind not in "fiu":
        return name, said
    return name, in_unit(said, str(series[name].attrs.get("units", "")), name)


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
