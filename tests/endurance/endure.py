"""Let a law drill for hours, look at every row as it comes, and judge it in the end."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from cosim import Scenario
from cosim.recording.result import Rows
from cosim.run.assembly import Assembly, assembled
from cosim.run.options import RunOptions
from cosim.system.method import Method
from tests.endurance.rigs import EVERY, Rig

STEP = 0.01
END = 60.0
"""Seconds at the end over which it is told whether something is wound up."""

Progress = Callable[[float], None]


@dataclass
class Watch:
    """What is seen of a run.

    Attributes
    ----------
    least, greatest : dict of str to float
        Of each output that has bounds.
    limited, rows : int
        Communication points at which a limit was active, and all.
    strange : str
        The first output that was no finite number, and when.
    end : list of ndarray
        What was told over the last seconds.
    sizes : dict of str to set of int
        Of the components' saved states [bytes].
    """

    least: dict[str, float] = field(default_factory=dict[str, float])
    greatest: dict[str, float] = field(default_factory=dict[str, float])
    limited: int = 0
    rows: int = 0
    strange: str = ""
    end: list[np.ndarray] = field(default_factory=list[np.ndarray])
    sizes: dict[str, set[int]] = field(default_factory=dict[str, set[int]])

    def take(self, rig: Rig, rows: Rows, until: float) -> None:
        """Look at some rows."""
        self.rows += rows.times.size
        limited = np.zeros(rows.times.size, dtype=bool)
        for name in rig.limits:
            limited |= rows.columns[name]
        self.limited += int(limited.sum())
        for name in rig.bounds:
            self.least[name] = min(self.least.get(name, np.inf), float(rows.columns[name].min()))
            self.greatest[name] = max(self.greatest.get(name, -np.inf), float(rows.columns[name].max()))
        for name, values in rows.columns.items():
            if not self.strange and values.dtype == np.float64 and not np.isfinite(values).all():
                self.strange = f"{name} at t = {rows.times[~np.isfinite(values)][0]:.2f} s"
        self.end.append(rows.columns[rig.told][rows.times > until - END])

    def weigh(self, assembly: Assembly) -> None:
        """Note how large the saved states are."""
        for name, slave in assembly.slaves.items():
            self.sizes.setdefault(name, set()).add(len(slave.serialise()))


@dataclass(frozen=True)
class Outcome:
    """How a law bore it.

    Attributes
    ----------
    hours : float
        How long it drilled under what was drawn.
    rate : float
        Times real time.
    least_speed, greatest_speed : float
        Of the drive [rad/s].
    limited, stuck : float
        Parts of the time at which a limit was active, and the bit was stuck.
    faults : tuple of str
        What it did wrong.
    """

    hours: float
    rate: float
    least_speed: float
    greatest_speed: float
    limited: float
    stuck: float
    faults: tuple[str, ...]


def endure(rig: Rig, hours: float, seed: int = 1, progress: Progress | None = None) -> Outcome:
    """Let a law drill, and judge it.

    Every output is to be finite, what has limits is to keep them, the state of every FMU is to stay as large as it was,
    and after some time at nominal weight and formation the string is to turn as if nothing had been.
    """
    draws = max(1, round(hours * 3600.0 / EVERY))
    began = time.perf_counter()
    watch, stuck = drill(rig, draws, seed, progress)
    took = time.perf_counter() - began
    seconds = draws * EVERY + rig.afterwards
    return Outcome(
        hours=draws * EVERY / 3600.0,
        rate=seconds / took,
        least_speed=watch.least["drive.Omega"],
        greatest_speed=watch.greatest["drive.Omega"],
        limited=watch.limited / watch.rows,
        stuck=stuck / seconds,
        faults=(*_beyond(rig, watch), *_wound_up(rig, np.concatenate(watch.end))),
    )


def drill(rig: Rig, draws: int, seed: int, progress: Progress | None = None) -> tuple[Watch, float]:
    """Run a rig; return what was seen, and how long the bit was stuck [s]."""
    until = draws * EVERY + rig.afterwards
    method = Method(algorithm="gauss-seidel")
    scenario = Scenario("endurance", rig.system(draws, seed), stop_time=until, step_size=STEP, method=method)
    watch, stuck = Watch(), 0.0
    with assembled(scenario, RunOptions()) as assembly:
        master = assembly.master
        master.begin()
        for rows in master.rows(progress):
            watch.take(rig, rows, until)
            watch.weigh(assembly)
            stuck = float(rows.columns["plant.stuck_time"][-1])
        master.end()
    return watch, stuck


def _beyond(rig: Rig, watch: Watch) -> list[str]:
    """Say what was not finite, beyond a limit, or grew."""
    faults = [f"{watch.strange} is no finite number"] if watch.strange else []
    for name, (low, high) in rig.bounds.items():
        if not low <= watch.least[name] <= watch.greatest[name] <= high:
            faults.append(
                f"{name} went from {watch.least[name]:g} to {watch.greatest[name]:g}; its limits are {low:g}, {high:g}"
            )
    faults += [
        f"the state of {name} grew to {max(sizes)} bytes" for name, sizes in watch.sizes.items() if len(sizes) > 1
    ]
    return faults


def _wound_up(rig: Rig, end: np.ndarray) -> list[str]:
    """Compare the end with that of a law before which next to nothing was drawn.

    Sensors are noisy, so that no two ends are the same: deviations of a minute were seen to differ by a fifth.
    """
    fresh = np.concatenate(drill(rig, 1, 0)[0].end)
    apart, swing = abs(float(end.mean() - fresh.mean())), float(end.std())
    if apart <= rig.near and swing <= 1.5 * float(fresh.std()) + 1e-3:
        return []
    return [
        f"{rig.told} is {end.mean():.4f} with a deviation of {swing:.4f} in the end; without what was before it is "
        f"{fresh.mean():.4f} with {fresh.std():.4f}"
    ]
