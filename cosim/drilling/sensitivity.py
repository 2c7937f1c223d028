"""Estimate which of the things that are not known for certain decide whether the string sticks: Sobol indices.

The first-order index of a variable is the part of the variance of an output that goes with it alone, the total index
the part that it has to do with, alone or together with others. They are estimated by SALib from samples drawn by
Saltelli's method, and so are their confidence intervals, by drawing again from these samples.

Source: A. Saltelli, P. Annoni, I. Azzini, F. Campolongo, M. Ratto, S. Tarantola, Variance based sensitivity analysis
of model output. Design and estimator for the total sensitivity index, Computer Physics Communications 181 (2010)
259-270.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, cast

import numpy as np

from cosim.drilling.severity_map import unstable_points
from cosim.errors import InputError, require, suggestion
from cosim.progress import Progress, shown
from cosim.system.signals import FloatArray

INSTABILITY, SHARE, THRESHOLD = "instability", "share", "threshold"
RESAMPLES = 100
"""How often samples are drawn again for a confidence interval."""
VARIABLE = "variable"
_SAMPLE, _SAMPLING, _HELD = "sample", "sampling", "held"
"""Names in a store: the dimension of samples, how they were drawn, and inputs that are the same at all points."""
_STRING = "DrillstringNeutral"
_TEXTS = {
    INSTABILITY: ("", "instability of a point, 0 or 1"),
    SHARE: ("", "part of the points of the grid that are unstable"),
    THRESHOLD: ("rad/s", "drive speed at which steady rotation loses its stability"),
}
_SALTELLI = "saltelli"


class NoOutputError(InputError):
    """An output that a sweep does not tell."""


@dataclass(frozen=True)
class Indices:
    """Sobol indices of one output.

    Attributes
    ----------
    first, total : ndarray, shape (variables,)
        Indices of first order, and total ones; NaN where the output does not vary.
    first_confidence, total_confidence : ndarray, shape (variables,)
        Half of the confidence interval.
    left_out : int
        How many of the samples, each with its own, have no output and were left out.
    """

    first: FloatArray
    first_confidence: FloatArray
    total: FloatArray
    total_confidence: FloatArray
    left_out: int


def estimate(values: FloatArray, variables: int, confidence: float, resamples: int, seed: int) -> Indices:
    """Estimate the indices of an output.

    Parameters
    ----------
    values : ndarray, shape (samples,)
        The output at samples by `cosim.sweeps.design.sampled` with ``"saltelli"``, in their order; NaN where it has
        none.
    variables : int
        How many were sampled.
    confidence : float
        How likely an index is to lie in its interval, between 0 and 1.
    resamples, seed : int
        How often samples are drawn again for the interval, and what draws the same again.
    """
    salib = require("SALib.analyze.sobol", extra="sensitivity", purpose="Sobol indices")
    blocks = values.reshape(-1, variables + 2)
    whole = np.isfinite(blocks).all(axis=1)
    kept = blocks[whole].ravel()
    left_out = int((~whole).sum())
    pairs = blocks[whole][:, [0, -1]]  # the estimators divide by the variance of these
    if pairs.shape[0] < 2 or float(np.ptp(pairs)) <= 1e-12 * float(np.abs(pairs).max()):
        none = np.full(variables, math.nan)
        return Indices(none, none, none, none, left_out)
    problem = {"num_vars": variables, "names": list(map(str, range(variables))), "bounds": [[0.0, 1.0]] * variables}
    found = salib.analyze(
        problem, kept, calc_second_order=False, num_resamples=resamples, conf_level=confidence,
        seed=np.random.default_rng(seed),
    )  # fmt: skip
    first, first_confidence, total, total_confidence = (
        np.asarray(found[name], dtype=np.float64) for name in ("S1", "S1_conf", "ST", "ST_conf")
    )
    return Indices(first, first_confidence, total, total_confidence, left_out)


def sobol_indices(
    dataset: Any,
    of: str = INSTABILITY,
    *,
    confidence: float = 0.95,
    resamples: int = RESAMPLES,
    seed: int = 0,
    progress: Progress | bool | None = None,
) -> Any:
    """Estimate Sobol indices of an output of a sweep whose samples were drawn by ``sampling="saltelli"``.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `cosim.sweep` or `cosim.open_sweep`, of a sweep that is done.
    of : str
        ``"instability"``, which is 0 or 1, at each point of the grid: what decides of the probability of stick-slip.
        ``"share"``: the part of the grid's points that are unstable. ``"threshold"``: the drive speed at which steady
        rotation loses its stability, from the spectrum, without any run. Or a number that the sweep has kept.
    confidence : float
        How likely an index is to lie in its interval, between 0 and 1.
    resamples, seed : int
        How often samples are drawn again for the interval, and what draws the same again.
    progress : callable or bool, optional
        Called now and then; True: a bar is shown, False: none. By default there is one in notebooks and in IPython.

    Returns
    -------
    xarray.Dataset
        ``first`` and ``total`` over the grid, as far as the output depends on it, and over ``variable``;
        ``first_confidence`` and ``total_confidence``, half of each interval; NaN where the output does not vary.
        ``left_out`` is how many samples, each with those that differ from it in one variable, were left out, as one of
        them has no output.

    Raises
    ------
    InputError
        If the samples were drawn otherwise, the sweep is not done, or there is no such output.
    """
    if not 0.0 < confidence < 1.0:
        raise InputError(f"the confidence is {confidence:g}; expected a number between 0 and 1")
    if resamples < 2:
        raise InputError(f"the samples are to be drawn again {resamples} times; expected 2 at least")
    drawn = _drawn(dataset)
    with shown(progress, "estimating indices") as told:
        found = _indices(dataset, of, list(drawn["from"]), (confidence, resamples, seed), told)
    about = {"confidence": confidence, "seed": seed, "resamples": resamples, "samples": int(drawn["count"])}
    return found.assign_attrs(**about, sha256=str(dataset.attrs["sha256"]))


def _indices(
    dataset: Any, of: str, names: Sequence[str], how: tuple[float, int, int], progress: Progress | None
) -> Any:
    """Estimate the indices of an output at each point, with confidence, resamples and seed."""
    output = _output(dataset, of, progress)
    shape = output.shape[:-1]
    found: dict[str, FloatArray] = {
        name: np.full((*shape, len(names)), np.nan)
        for name in ("first", "first_confidence", "total", "total_confidence")
    }
    left_out = np.zeros(shape, dtype=np.int64)
    for number, place in enumerate(np.ndindex(*shape), 1):
        each = estimate(output.values[place], len(names), *how)
        for name, values in found.items():
            values[place] = getattr(each, name)
        left_out[place] = each.left_out
        if progress is not None:
            progress(f"{number} of {left_out.size} points", number / left_out.size)
    dims = [str(name) for name in output.dims[:-1]]
    return _xarray().Dataset(
        {**{name: ([*dims, VARIABLE], values) for name, values in found.items()}, "left_out": (dims, left_out)},
        {**{name: dataset[name] for name in dims if name in dataset.coords}, VARIABLE: list(names)},
        {"of": of, "long_name": output.attrs.get("long_name", of)},
    )


def indices_of_all(
    dataset: Any, confidence: float, progress: Progress | None = None
) -> tuple[dict[str, Any], list[str]]:
    """Estimate the indices of all that tells of stick-slip: by output; and say in sentences what there are none of."""
    grid = [name for name in dataset["failed"].dims if name != _SAMPLE]
    found: dict[str, Any] = {}
    left: list[str] = []
    _drawn(dataset)
    for of in (INSTABILITY, SHARE, THRESHOLD) if grid else (INSTABILITY, THRESHOLD):
        try:
            found[of] = sobol_indices(dataset, of, confidence=confidence, progress=progress)
        except NoOutputError as error:
            left.append(f"no indices of {of}: {error}")
    if not found:
        raise InputError(left[0])
    for of, each in found.items():
        most = int(each["left_out"].max())
        if most:
            left.append(f"{of}: {most} of {each.attrs['samples']} samples were left out, as they have no such output")
    return found, left


def _xarray() -> Any:
    """Return xarray, which takes a while to import."""
    return require("xarray", extra="stream", purpose="reading a sweep")


def _drawn(dataset: Any) -> dict[str, Any]:
    """Return how samples were drawn; refuse what indices cannot be estimated of."""
    if _SAMPLE not in dataset["failed"].dims:
        raise InputError(f"the sweep has no samples; expected some, and --sampling {_SALTELLI}")
    drawn = cast(dict[str, Any], json.loads(dataset.attrs.get(_SAMPLING, "{}")))
    if drawn.get("method") != _SALTELLI:
        method = drawn.get("method", "another method")
        raise InputError(f"the samples were drawn by {method}; indices are estimated of --sampling {_SALTELLI}")
    wanted, found = int(drawn["count"]) * (len(drawn["from"]) + 2), int(dataset.sizes[_SAMPLE])
    if found != wanted:
        raise InputError(f"there are {found} of {wanted} samples; expected all, in their order")
    failed = dataset["failed"].values
    done = int(np.isfinite(failed).sum())
    if done < failed.size:
        raise InputError(f"{done} of {failed.size} points are done; expected all, go on with the same command")
    return drawn


def _output(dataset: Any, of: str, progress: Progress | None) -> Any:
    """Return an output of a sweep over the grid and, last, over samples; NaN where there is none."""
    known = [str(name) for name in dataset.data_vars if name not in ("failed", "message")]
    grid = [str(name) for name in dataset["failed"].dims if name != _SAMPLE]
    if of == THRESHOLD:
        return _threshold(dataset, [name for name in grid if not name.endswith(".Omega")], progress)
    if of in (INSTABILITY, SHARE):
        if "bit_speed_max" not in known:
            raise NoOutputError(f"the sweep has not measured how a bit moves; known: {', '.join(known)}")
        order = (*grid, _SAMPLE)
        kept = {str(name): dataset[name].transpose(*order).values for name in ("failed", *known)}
        values = np.where(kept["failed"] == 0, unstable_points(kept).astype(np.float64), np.nan)
        found = _xarray().DataArray(values, dims=order)
        found = found.mean(dim=grid, skipna=False) if of == SHARE else found
    elif of in known:
        found = dataset[of].transpose(*grid, _SAMPLE)
        return found.where(np.isfinite(found))
    else:
        raise InputError(f"there are no indices of '{of}'{suggestion(of, [*_TEXTS, *known])}")
    return found.assign_attrs(long_name=_TEXTS[of][1])


def _threshold(dataset: Any, grid: Sequence[str], progress: Progress | None) -> Any:
    """Return the linear threshold [rad/s] at each sample, over what of the grid it depends on."""
    from cosim.drilling.mathematics import DrillstringParameters, stability_boundary

    component, known = _string(dataset)
    symbols = {each.name for each in fields(DrillstringParameters)}
    size = int(dataset.sizes[_SAMPLE])
    shape = tuple(int(dataset.sizes[name]) for name in grid)
    samples = {str(name): dataset[name].values for name in dataset.coords if dataset[name].dims == (_SAMPLE,)}
    values = np.full((*shape, size), np.nan)
    for number, place in enumerate(np.ndindex(*shape), 1):
        at = {name: dataset[name].values[index] for name, index in zip(grid, place, strict=True)}
        for sample in range(size):
            given = {**known, **at, **{name: each[sample] for name, each in samples.items()}}
            own = dict(_own(component, given))
            if "WOB" not in own:
                raise NoOutputError("the store does not tell the weight on bit; expected it to be varied")
            try:
                string = DrillstringParameters(**{name: float(v) for name, v in own.items() if name in symbols})
                values[(*place, sample)] = stability_boundary(string, [float(own["WOB"])])[0]
            except (ValueError, ArithmeticError):  # as the plant itself refuses them
                continue
        if progress is not None:
            progress(f"thresholds: {number} of {math.prod(shape)}", number / math.prod(shape))
    unit, text = _TEXTS[THRESHOLD]
    return _xarray().DataArray(values, dims=(*grid, _SAMPLE), attrs={"units": unit, "long_name": text})


def _string(dataset: Any) -> tuple[str, dict[str, Any]]:
    """Return the name of a string that is alone, and all that is known of it; refuse other systems."""
    record = json.loads(dataset.attrs["record"])
    parts: Mapping[str, Any] = record["components"]
    component = next(iter(parts))
    if len(parts) != 1 or parts[component]["model"] != _STRING or component in dataset.coords:
        raise NoOutputError(f"the threshold is known of {_STRING} alone; this sweep is of {', '.join(parts)}")
    held: Mapping[str, Any] = json.loads(dataset.attrs.get(_HELD, "{}"))
    parameters = {f"{component}.{name}": value for name, value in parts[component]["parameters"].items()}
    return component, {**held, **parameters}


def _own(component: str, values: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Go through what belongs to a component, by the names of its variables."""
    for name, value in values.items():
        owner, _, variable = name.partition(".")
        if owner == component:
            yield variable, value
