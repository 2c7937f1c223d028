"""Figures on Proposition 1: where the loop of law (9) as printed has a solution, and what made the energy grow."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from cosim.drilling.energy_growth import CAUSES, EnergyGrowth, arriving_wave
from cosim.drilling.figure import blank_figure
from cosim.drilling.mathematics import PrintedLoop
from cosim.recording.result import Result
from cosim.system.signals import FloatArray

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
    """Draw into a PNG file which top speeds and arriving waves solve the loop of law (9) as printed.

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
        waves = (tops - sign * loop.transmission * omega_max) / loop.arrival
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
        gap.plot(result["plant.bit_speed"], arriving_wave(result), ",", color=_VISITED, alpha=0.5)
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
