"""Figures of the theory: stability charts, and the cycles between the loss of stability and their fold."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cosim.drilling.figure import blank_figure
from cosim.drilling.mathematics import Bistability, BranchPoint, StabilityChart, equilibria, input_of, peak_speed

_LABELS = {
    "Omega": ("Drive speed [rad/s]", 1.0),
    "WOB": ("Weight on bit [kN]", 1e3),
    "c_a": ("Damping of the sliding top [kN.m.s/rad]", 1e3),
    "c_b": ("Damping at the bit [N.m.s/rad]", 1.0),
    "L": ("Length of the string [km]", 1e3),
    "I_B": ("Inertia of the bottom hole assembly [kg.m2]", 1.0),
}
_ROTATION, _CYCLE = "#0b5394", "#b45309"
# Beyond this, 1/s, a rate of growth or decay is not told apart.
_FASTEST = 0.5


def draw_charts(path: Path, charts: Sequence[StabilityChart]) -> None:
    """Draw stability charts side by side into a PNG file.

    Purple is where rotation is stable and orange where it is not, the darker the faster disturbances die or grow;
    white, where there is none. The line between is where stability is lost.

    Parameters
    ----------
    path : Path
        The file.
    charts : sequence of StabilityChart
        At least two values along each axis.
    """
    figure = blank_figure(0.6 + 3.6 * len(charts), 3.5)
    panels = figure.subplots(1, len(charts), squeeze=False)[0]
    shading = None
    for number, (panel, chart) in enumerate(zip(panels, charts, strict=True)):
        (x_label, x_unit), (y_label, y_unit) = (_LABELS.get(name, (name, 1.0)) for name in (chart.x_name, chart.y_name))
        x, y = chart.x / x_unit, chart.y / y_unit
        shading = panel.pcolormesh(
            x, y, chart.abscissa, cmap="PuOr_r", vmin=-_FASTEST, vmax=_FASTEST, shading="gouraud"
        )
        if (chart.abscissa < 0.0).any() and (chart.abscissa > 0.0).any():
            panel.contour(x, y, chart.abscissa, levels=[0.0], colors="black", linewidths=1.2)
        panel.set(xlabel=x_label, ylabel=y_label)
        panel.set_title(f"{chr(ord('a') + number)})", loc="left", fontsize=10, fontweight="bold")
    figure.colorbar(shading, ax=list(panels), label="Growth of disturbances [1/s]", extend="both")
    figure.savefig(path)


def draw_bistability(path: Path, found: Bistability, stable: Sequence[BranchPoint] = ()) -> None:
    """Draw least and greatest bit speed of rotation and of cycles over the input into a PNG file.

    Parameters
    ----------
    path : Path
        The file.
    found : Bistability
        The unstable cycles, from the threshold to their fold.
    stable : sequence of BranchPoint
        Cycles beyond the fold, as :func:`models.theory.cycle.continuation.branch_from` finds them.
    """
    figure = blank_figure(7.2, 4.0)
    panel = figure.subplots()
    label, unit = _LABELS[found.free]
    ends = sorted((found.threshold / unit, found.fold / unit))
    panel.axvspan(*ends, color="#efefef", label="rotation and stick-slip both stable")
    _draw_rotation(panel, found, [point.input for point in (*found.points, *stable)], unit)
    unstable = [point for point in found.points if (point.input - found.fold) * (found.threshold - found.fold) >= 0.0]
    for points, style, name in ((unstable, "--", "unstable cycle"), (stable, "-", "stick-slip")):
        if points:
            inputs, least, peak = np.array([_extent(point, found.free) for point in points]).T
            panel.plot(inputs / unit, peak, style, color=_CYCLE, linewidth=1.4, label=name)
            panel.plot(inputs / unit, least, style, color=_CYCLE, linewidth=1.4)
    panel.set(xlabel=label, ylabel="Least and greatest bit speed [rad/s]")
    panel.grid(visible=True, color="#d9d9d9", linewidth=0.5)
    panel.spines[["top", "right"]].set_visible(False)
    panel.legend(frameon=False, fontsize=9)
    figure.savefig(path)


def _draw_rotation(panel: Any, found: Bistability, inputs: list[float], unit: float) -> None:
    """Draw the speed of rotation, dashed where it is unstable."""
    orbit, ahead = found.fold_cycle, 1.0 if found.free == "Omega" else -1.0
    reach = np.linspace(0.9 * min(*inputs, found.threshold), 1.1 * max(*inputs, found.threshold), 300)
    speeds = np.full(reach.size, np.nan)
    for i, value in enumerate(reach.tolist()):
        omega, wob = (value, orbit.wob) if found.free == "Omega" else (orbit.omega, value)
        running = [one.speed for one in equilibria(orbit.parameters, omega, wob) if not one.stuck]
        speeds[i] = running[-1] if running else np.nan
    stable = ahead * (reach - found.threshold) >= 0.0
    for part, style, name in ((stable, "-", "rotation"), (~stable, "--", "unstable rotation")):
        panel.plot(reach / unit, np.where(part, speeds, np.nan), style, color=_ROTATION, linewidth=1.4, label=name)


def _extent(point: BranchPoint, free: str) -> tuple[float, float, float]:
    """Return the input, and least and greatest bit speed of a cycle [rad/s]."""
    orbit = point.orbit
    least = 0.0 if orbit.timing.slips else float(orbit.values[orbit.mesh.columns[0, 0]])
    return input_of(orbit, free), least, peak_speed(orbit)
