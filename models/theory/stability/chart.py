"""Stability charts: the running equilibrium over two quantities, and the line on which it loses its stability."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import nan

import numpy as np
from numpy.typing import ArrayLike

from ...plant.parameters import DrillstringParameters
from ..numerics.arrays import FloatArray, IntArray
from ..numerics.progress import Progress, silent
from .equilibrium import equilibria
from .spectrum import critical_slope, spectral_abscissa, unstable_count
from .torque_curve import TorqueCurve

INPUTS = ("Omega", "WOB")
NO_EQUILIBRIUM = -1


@dataclass(frozen=True)
class StabilityChart:
    """The running equilibrium over a grid of two quantities.

    Attributes
    ----------
    x_name, y_name : str
        What varies along the columns and along the rows.
    x, y : ndarray
        Its values, SI units.
    speed : ndarray, shape (y.size, x.size)
        Bit speed of the running equilibrium, of two the faster [rad/s]; NaN where there is none.
    abscissa : ndarray, shape (y.size, x.size)
        Rate at which disturbances grow in the end [1/s], negative where it is stable; NaN where there is none.
    unstable : ndarray of int, shape (y.size, x.size)
        Roots with a positive real part, counted by the argument principle; -1 where there is no equilibrium.
    """

    x_name: str
    y_name: str
    x: FloatArray
    y: FloatArray
    speed: FloatArray
    abscissa: FloatArray
    unstable: IntArray


def stability_chart(
    parameters: DrillstringParameters,
    omega: float,
    wob: float,
    x: tuple[str, ArrayLike],
    y: tuple[str, ArrayLike],
    progress: Progress = silent,
) -> StabilityChart:
    """Return the stability of the running equilibrium over two quantities.

    Parameters
    ----------
    parameters : DrillstringParameters
        The string, where it does not vary.
    omega, wob : float
        Drive speed [rad/s] and weight on bit [N], where they do not vary.
    x, y : tuple of str and array_like
        Name and values of a quantity: Omega, WOB, or a parameter, such as ("c_b", [0.03, 50, 100]).
    progress : callable, optional
        Called after each row.

    Raises
    ------
    ValueError
        A name is unknown, the two are one, or a value is refused as by
        :func:`models.theory.stability.equilibrium.equilibria` and
        :class:`models.plant.parameters.DrillstringParameters`.
    """
    known = (*INPUTS, *(field.name for field in fields(DrillstringParameters)))
    for name in (x[0], y[0]):
        if name not in known:
            raise ValueError(f"a chart over {name!r} was asked for; expected one of {', '.join(known)}")
    if x[0] == y[0]:
        raise ValueError(f"both axes of the chart are {x[0]}; expected two quantities")
    columns, rows = (np.atleast_1d(np.asarray(axis[1], dtype=np.float64)) for axis in (x, y))
    shape = rows.size, columns.size
    speed, abscissa = np.full(shape, np.nan), np.full(shape, np.nan)
    unstable = np.full(shape, NO_EQUILIBRIUM, dtype=np.intp)
    for i, row in enumerate(rows.tolist()):
        for j, column in enumerate(columns.tolist()):
            values = {"Omega": omega, "WOB": wob, x[0]: column, y[0]: row}
            string = replace(parameters, **{name: values[name] for name in values if name not in INPUTS})
            found = equilibria(string, values["Omega"], values["WOB"])
            if found and not found[-1].stuck:
                speed[i, j] = found[-1].speed
                abscissa[i, j] = spectral_abscissa(string, found[-1])
                unstable[i, j] = unstable_count(string, found[-1])
        progress(f"{i + 1} of {rows.size} rows", (i + 1) / rows.size)
    return StabilityChart(x[0], y[0], columns, rows, speed, abscissa, unstable)


def stability_boundary(parameters: DrillstringParameters, wobs: ArrayLike) -> FloatArray:
    """Return the critical drive speed [rad/s] over weights on bit [N]; NaN where no equilibrium that turns is unstable.

    See :func:`models.theory.stability.spectrum.critical_point`.
    """
    _, slope = critical_slope(parameters)
    line: list[float] = []
    for wob in np.atleast_1d(np.asarray(wobs, dtype=np.float64)).tolist():
        curve = TorqueCurve.of(parameters, wob)
        speed = curve.speed_of_slope(slope)
        line.append(nan if speed is None else speed + float(curve.torque(speed)) / parameters.c_a)
    return np.array(line)
