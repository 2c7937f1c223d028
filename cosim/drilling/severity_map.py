"""Severity maps: a number of a sweep over two axes, with what theory says of the same plane.

Over maps of a string alone at given speed and weight, there are two lines: where steady rotation loses its stability,
from the spectrum, and up to where there are cycles, the fold, from their continuation. Between them both are stable,
and what is found depends on where a run comes from: there are cells in which branches of a sweep disagree.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cosim.drilling.severity import QUANTITIES, SWING
from cosim.errors import InputError, MissingPackageError, suggestion
from cosim.progress import Progress, shown
from cosim.system.signals import FloatArray

if TYPE_CHECKING:
    from cosim.drilling.mathematics import BoolArray, DrillstringParameters

log = logging.getLogger("cosim")

_BRANCHES = {"rest": "from rest", "up": "continued up", "down": "continued down"}
_BEGINNING = ("branch", "along", "beginning", "series")
"""What of the record of a sweep tells how runs begin, or nothing of them."""
_STRING = "DrillstringNeutral"
_GREATEST_INDEX = 3.0
_STANDS = 0.999
_SAMPLE, _PROBABILITY = "sample", "probability"
FOLDS = 5
"""At how many weights on bit the fold is looked for, unless it is said."""


@dataclass(frozen=True)
class Map:
    """A number over a plane.

    Attributes
    ----------
    title : str
        Which branch it is of.
    quantity, unit, text : str
        Name, unit and meaning of the number.
    x_name, y_name : str
        What varies along the axes.
    x, y : ndarray
        Its values, SI units.
    x_unit, y_unit : str
        Their units.
    values : ndarray, shape (y.size, x.size)
        The number; NaN where there is none, infinite where the bit stands still on the whole.
    failed : ndarray of bool, shape (y.size, x.size)
        Where the run has failed.
    unstable : ndarray of bool, shape (y.size, x.size)
        Where the bit speed swings by more than `cosim.drilling.severity.SWING`, or the bit stands still.
    string : DrillstringParameters or None
        What is turned, if it is a string alone whose speed and weight vary.
    system : str
        A text that is the same for maps that differ in how runs begin alone.
    """

    title: str
    quantity: str
    unit: str
    text: str
    x_name: str
    y_name: str
    x: FloatArray
    y: FloatArray
    x_unit: str
    y_unit: str
    values: FloatArray
    failed: BoolArray
    unstable: BoolArray
    string: DrillstringParameters | None
    system: str

    def less(self, other: Map) -> Map:
        """Return the difference from a map over the same plane.

        Raises
        ------
        InputError
            If the other one is over other values.
        """
        for name, mine, its in ((self.x_name, self.x, other.x), (self.y_name, self.y, other.y)):
            if not np.array_equal(mine, its):
                raise InputError(f"the maps are over other values of {name}; expected the same, which can be compared")
        with np.errstate(invalid="ignore"):
            values = self.values - other.values
        failed = self.failed | other.failed
        text = f"{self.text}, less {other.title}" if self.title != other.title else f"difference of {self.text}"
        return replace(self, values=values, failed=failed, text=text)


@dataclass(frozen=True)
class TheoryLine:
    """A line of theory over drive speed and weight on bit.

    Attributes
    ----------
    text : str
        What it is.
    kind : str
        ``"threshold"`` or ``"fold"``.
    speeds, weights : ndarray, shape (n,)
        Drive speeds [rad/s] over weights on bit [N]; NaN where there is none.
    """

    text: str
    kind: str
    speeds: FloatArray
    weights: FloatArray


def read_map(dataset: Any, quantity: str | None = None) -> Map:
    """Take a map from what a sweep has kept.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `cosim.sweep` or `cosim.open_sweep`, over two axes of numbers, and perhaps samples.
    quantity : str, optional
        Which number; by default the stick-slip index. Of samples it is the probability of stick-slip: the part of those
        that have not failed that are unstable.

    Raises
    ------
    InputError
        If there is no such number, or it is not over a plane.
    """
    known = [str(name) for name in dataset.data_vars if name not in ("failed", "message")]
    over = [str(name) for name in dataset["failed"].dims]
    plane = [name for name in over if name != _SAMPLE]
    wanted = quantity or (_PROBABILITY if _SAMPLE in over else "ssi")
    if len(plane) != 2 or not all(name in dataset.coords and dataset[name].dtype.kind in "fi" for name in plane):
        raise InputError(f"the sweep is over {', '.join(over)}; expected two axes of numbers for a map")
    choices = [_PROBABILITY] if _SAMPLE in over else known
    if wanted not in choices:
        raise InputError(f"the sweep has kept no '{wanted}' over {', '.join(over)}{suggestion(wanted, choices)}")
    x_name, y_name = sorted(plane, key=lambda name: not name.endswith(".Omega"))
    dataset = dataset.sortby(plane)  # a grid may be given in any order
    order = (*([_SAMPLE] if _SAMPLE in over else ()), y_name, x_name)
    kept = {name: np.asarray(dataset[name].transpose(*order).values) for name in ("failed", *known)}
    unstable, failed = unstable_points(kept), kept["failed"] == 1
    unit, text = ("", "probability of stick-slip")
    values = kept.get(wanted, np.zeros(0))
    if wanted == _PROBABILITY:
        values = _probability(unstable, kept["failed"])
        unstable, failed = values > 0.5, failed.all(axis=0)
    else:
        unit, text = (dataset[wanted].attrs.get(name, "") for name in ("units", "long_name"))
    record = json.loads(dataset.attrs["record"])
    return Map(
        title=_BRANCHES[record["branch"]],
        quantity=wanted,
        unit=unit,
        text=text or wanted,
        x_name=x_name,
        y_name=y_name,
        x=np.asarray(dataset[x_name].values, dtype=np.float64),
        y=np.asarray(dataset[y_name].values, dtype=np.float64),
        x_unit=dataset[x_name].attrs.get("units", ""),
        y_unit=dataset[y_name].attrs.get("units", ""),
        values=values,
        failed=failed,
        unstable=unstable,
        string=_string(record, x_name, y_name, _fixed(dataset)),
        system=system_of(record),
    )


def planes(dataset: Any) -> Generator[tuple[dict[str, int], Map]]:
    """Go through the planes over a string's speed and weight in a sweep over any number of axes.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `cosim.sweep` or `cosim.open_sweep`.

    Yields
    ------
    dict of str to int, Map
        The place of a plane on the other axes, and its map; nothing where no string alone is swept over both.
    """
    over = [str(name) for name in dataset["failed"].dims if name != _SAMPLE]
    plane = [name for name in over if name.endswith((".Omega", ".WOB"))]
    if len(plane) != 2:
        return
    others = [name for name in over if name not in plane]
    quantity = None if "ssi" in dataset or _SAMPLE in dataset.dims else str(next(iter(dataset.data_vars)))
    for place in np.ndindex(*(dataset.sizes[name] for name in others)):
        at = dict(zip(others, place, strict=True))
        found = read_map(dataset.isel(at), quantity)
        if found.string is not None:
            yield at, found


def instability(dataset: Any) -> FloatArray | None:
    """Return where a sweep is unstable, over the dimensions of ``failed``.

    Returns
    -------
    ndarray or None
        1 where the bit speed swings by more than `cosim.drilling.severity.SWING`, or the bit stands still; 0 where it
        does not; NaN where a run has failed or is not done. None where nothing swept has a bit.
    """
    if "bit_speed_max" not in dataset or "bit_speed_min" not in dataset:
        return None
    order = dataset["failed"].dims
    names = [name for name in ("failed", "bit_speed_max", "bit_speed_min", "stuck_fraction") if name in dataset]
    kept = {name: np.asarray(dataset[name].transpose(*order).values) for name in names}
    return np.where(kept["failed"] == 0, unstable_points(kept), np.nan)


def _fixed(dataset: Any) -> dict[str, Any]:
    """Return what a plane of a sweep over more axes is at on the others."""
    return {str(name): each.values.item() for name, each in dataset.coords.items() if each.ndim == 0}


def unstable_points(kept: Mapping[str, NDArray[Any]]) -> BoolArray:
    """Return where, by the numbers that were kept, the bit swings or stands still."""
    shape = kept["failed"].shape
    swing = kept["bit_speed_max"] - kept["bit_speed_min"] if "bit_speed_max" in kept else np.zeros(shape)
    stands = kept["stuck_fraction"] > _STANDS if "stuck_fraction" in kept else np.zeros(shape, dtype=np.bool_)
    return np.asarray((swing > SWING) | stands)


def _probability(unstable: BoolArray, failed: FloatArray) -> FloatArray:
    """Return the part of samples, along the first axis, that are unstable; NaN where none is done."""
    whole = failed == 0
    count = whole.sum(axis=0)
    return np.where(count > 0, (unstable & whole).sum(axis=0) / np.maximum(count, 1), np.nan)


def _string(
    record: Mapping[str, Any], x_name: str, y_name: str, fixed: Mapping[str, Any]
) -> DrillstringParameters | None:
    """Return the string of a sweep over its speed and weight, if theory knows it and nothing is coupled to it."""
    component, _, speed = x_name.partition(".")
    known = record["components"].get(component, {})
    alone = len(record["components"]) == 1 and known.get("model") == _STRING and component not in fixed
    if not alone or speed != "Omega" or y_name != f"{component}.WOB":
        return None
    try:
        from cosim.drilling.mathematics import DrillstringParameters

        names = {each.name for each in fields(DrillstringParameters)}
        own = {name.partition(".")[2]: v for name, v in fixed.items() if name.startswith(f"{component}.")}
        given = {**known["parameters"], **own}
        return DrillstringParameters(**{name: v for name, v in given.items() if name in names})
    except MissingPackageError as error:
        log.warning("the lines of theory are not drawn: %s", error)
    except ValueError as error:  # as the plant itself refuses them, so that there are no points either
        log.info("there are no lines of theory: %s", error)
    return None


def find_folds(
    found: Map, count: int = FOLDS, progress: Progress | bool | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return drive speeds [rad/s] up to which there are cycles, and the weights on bit [N] they belong to.

    Parameters
    ----------
    found : Map
        Of a string alone.
    count : int
        At how many weights to look; each takes seconds. There may be none at some.
    progress : callable or bool, optional
        Called at each cycle that is found; True: a bar is shown, False: none. By default there is one in notebooks.
    """
    with shown(progress, "following cycles") as told:
        return _folds(found, count, told)


def _folds(found: Map, count: int, told: Progress | None) -> tuple[FloatArray, FloatArray]:
    """Find the folds, and tell how far it is."""
    from cosim.drilling.mathematics import bistable_omegas

    speeds: list[float] = []
    weights: list[float] = []
    places: FloatArray = np.linspace(float(found.y[0]), float(found.y[-1]), count if found.string is not None else 0)
    for number, weight in enumerate(places.tolist()):

        def tell(done: str, part: float, number: int = number) -> None:
            if told is not None:
                told(f"weight {number + 1} of {count}" + (f", {done}" if done else ""), (number + part) / count)

        try:
            if weight > 0.0 and found.string is not None:
                speeds.append(bistable_omegas(found.string, weight, progress=tell).fold)
                weights.append(weight)
                if speeds[-1] > found.x[-1]:  # and so are those of greater weights
                    break
        except (ArithmeticError, ValueError) as error:
            log.info("no fold of the cycles at WOB = %g N: %s", weight, error)
        tell("", 1.0)
    return np.array(speeds), np.array(weights)


def theory_lines(found: Map, folds: tuple[FloatArray, FloatArray] | None = None) -> list[TheoryLine]:
    """Return where steady rotation loses its stability, and up to where there are cycles.

    Parameters
    ----------
    found : Map
        Of anything; there are lines of a string alone.
    folds : (ndarray, ndarray), optional
        From `find_folds`.
    """
    if found.string is None:
        return []
    from cosim.drilling.mathematics import stability_boundary

    weights: FloatArray = np.linspace(max(float(found.y[0]), 1.0), float(found.y[-1]), 200)
    try:
        speeds = stability_boundary(found.string, weights)
    except (ArithmeticError, ValueError) as error:
        log.info("no threshold: %s", error)
        speeds = np.full(weights.size, np.nan)
    lines = [TheoryLine("rotation loses its stability (spectrum)", "threshold", speeds, weights)]
    if folds is not None and folds[0].size:
        lines.append(TheoryLine("end of the cycles (fold)", "fold", *folds))
    return lines


def system_of(record: Mapping[str, Any]) -> str:
    """Return a text that is the same for sweeps that differ in how runs begin alone, if in anything.

    Where the ends of their runs differ, they depend on the beginning.
    """
    return json.dumps({name: each for name, each in record.items() if name not in _BEGINNING}, sort_keys=True)


def bistable(maps: Sequence[Map]) -> BoolArray | None:
    """Return where branches disagree: the bit swings in one and turns steadily in another.

    None of maps of different systems, whose differences have other reasons.
    """
    if len({each.system for each in maps}) > 1:
        return None
    unstable = np.stack([each.unstable for each in maps])
    whole = ~np.stack([each.failed for each in maps]).any(axis=0)
    return np.asarray(unstable.any(axis=0) & ~unstable.all(axis=0) & whole)


def limits(values: Sequence[FloatArray], quantity: str, difference: bool) -> tuple[float, float]:
    """Return the ends of the colours; of an index that knows no bounds, they are those that matter."""
    finite = np.concatenate([each[np.isfinite(each)] for each in values])
    if not finite.size:
        return 0.0, 1.0
    if difference:
        greatest = min(float(np.abs(finite).max()), _GREATEST_INDEX if quantity == "ssi" else np.inf) or 1.0
        return -greatest, greatest
    if quantity == "ssi":
        return 0.0, min(_GREATEST_INDEX, max(1.0, float(finite.max())))
    if quantity in ("stuck_fraction", _PROBABILITY):
        return 0.0, 1.0
    return min(0.0, float(finite.min())), float(finite.max()) or 1.0


def quantity_names() -> tuple[str, ...]:
    """Return the names of the numbers that a severity map can show."""
    return tuple(each.name for each in QUANTITIES)
