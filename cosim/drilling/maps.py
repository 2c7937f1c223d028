"""Draw the theory: stability charts, cycles between the loss of stability and their fold, and Proposition 1.

Of the proposition, two figures: where the loop of law (9) as printed has a solution, and what made the energy grow.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cosim.drilling.energy_growth import CAUSES, EnergyGrowth, incident_wave
from cosim.drilling.mathematics import (
    Bistability,
    BranchPoint,
    PrintedLoop,
    StabilityChart,
    equilibria,
    input_of,
    peak_speed,
)
from cosim.recording.figure import blank_figure
from cosim.recording.result import Result
from cosim.system.signals import FloatArray

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


_SOLUTION, _GAP, _VISITED = "#0b5394", "#fbe3cf", "#6b6b6b"
_CAUSE_COLOURS = ("#0b5394", "#2f6f4f", "#7a3b69", "#8a8a8a", "#b45309", "#5c2a00", "#e3a35f")
_POINTS = 2000


def draw_loop_set(
    path: Path,
    loop: PrintedLoop,
    bit_speeds: tuple[float, float],
    omega_max: float,
    result: Result | None = None,
    *,
    reach: float = 45.0,
) -> None:
    """Draw into a PNG file which top speeds and incident waves solve the loop of law (9) as printed.

    a) The plane of both: the solutions for all bit speeds of a range, blue, the waves for which there is none at any of
    them, orange, and between the dotted lines what the limited drive can do. b) The gap over the bit speed, with the
    places a run has been to, grey.

    Parameters
    ----------
    path : Path
        The file.
    loop : PrintedLoop
        The loop.
    bit_speeds : (float, float)
        Least and greatest bit speed [rad/s].
    omega_max : float
        Limit of the drive in both directions [rad/s].
    result : Result, optional
        A run whose plant is called ``plant``.
    reach : float
        Greatest top speed shown [rad/s].
    """
    figure = blank_figure(9.6, 4.0)
    plane, gap = figure.subplots(1, 2, sharey=True)
    low, high = loop.gap(np.array(bit_speeds))
    _draw_solutions(plane, loop, bit_speeds, reach)
    tops = np.array([-reach, reach])
    for sign in (-1.0, 1.0):
        waves = (tops - sign * loop.transmission * omega_max) / loop.wave_gain
        plane.plot(tops, waves, ":", color="black", linewidth=1.0)
    plane.axhspan(low.max(), high.min(), color=_GAP, linewidth=0.0)
    plane.set(xlabel="Top speed [rad/s]", ylabel="Wave that arrives at the top [rad/s]", xlim=(-reach, reach))
    span = high.max() - low.min()
    plane.set_ylim(low.min() - 0.4 * span, high.max() + 0.4 * span)
    speeds = np.linspace(*bit_speeds, 200)
    gap.fill_between(speeds, *loop.gap(speeds), color=_GAP, linewidth=0.0)
    for edge in loop.gap(speeds):
        gap.plot(speeds, edge, color=_SOLUTION, linewidth=1.2)
    gap.set(xlabel="Bit speed [rad/s]", xlim=bit_speeds)
    if result is not None:
        gap.plot(result["plant.bit_speed"], incident_wave(result), ",", color=_VISITED, alpha=0.5)
    _finish(figure, (plane, gap), path)


def _draw_solutions(panel: Any, loop: PrintedLoop, bit_speeds: tuple[float, float], reach: float) -> None:
    """Draw both branches of the solutions, from the least to the greatest bit speed."""
    for sign in (-1.0, 1.0):
        tops: FloatArray = sign * np.linspace(0.005 * reach, reach, _POINTS)
        edges = (loop.wave(tops, bit) for bit in bit_speeds)
        panel.fill_between(tops, *edges, color=_SOLUTION, linewidth=1.6)


def draw_growth(path: Path, growths: Mapping[str, EnergyGrowth]) -> None:
    """Draw how much energy each cause has made by each time into a PNG file, runs side by side.

    Parameters
    ----------
    path : Path
        The file.
    growths : mapping of str to EnergyGrowth
        Audited runs, with the names to be written above them.
    """
    figure = blank_figure(max(7.2, 3.2 * len(growths)), 3.6)
    panels = figure.subplots(1, len(growths), sharey=True, squeeze=False)[0]
    present = [number for number in range(len(CAUSES)) if any((one.cause == number).any() for one in growths.values())]
    for panel, (name, growth) in zip(panels, growths.items(), strict=True):
        kept = np.unique(np.linspace(0, growth.time.size - 1, _POINTS).astype(np.intp))
        made = [np.cumsum(np.where(growth.cause == number, growth.change, 0.0))[kept] / 1e3 for number in present]
        colours = [_CAUSE_COLOURS[number] for number in present]
        panel.stackplot(growth.time[kept], *made, colors=colours, labels=[CAUSES[number] for number in present])
        panel.set(xlabel="Time [s]", xlim=(growth.time[0], growth.time[-1]))
        panel.set_title(name, fontsize=10)
    panels[0].set_ylabel("Growth of the energy so far [kJ]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles[::-1], labels[::-1], loc="outside right center", frameon=False, fontsize=9)
    _finish(figure, panels, path)


def _finish(figure: Any, panels: Any, path: Path) -> None:
    """Give all panels the same looks, and write the file."""
    for number, panel in enumerate(panels):
        panel.text(0.0, 1.02, f"{chr(ord('a') + number)})", transform=panel.transAxes, fontsize=10, fontweight="bold")
        panel.grid(visible=True, color="#d9d9d9", linewidth=0.5)
        panel.set_axisbelow(True)
        panel.spines[["top", "right"]].set_visible(False)
    figure.savefig(path)
