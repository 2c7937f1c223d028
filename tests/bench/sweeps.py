"""The same severity map in three ways, each in a process of its own, which prints what it has cost.

A plain loop of bare FMU steps does what is least: one instance, reset for each point, a step of 80 s and one of 20 s.
So do the workers of joblib, which is what users have at hand. The product keeps a store as well, and can be killed.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]
WORKERS = 2
SETTLED, END = 80.0, 100.0


def points(count: int) -> list[tuple[float, float]]:
    """Return drive speeds [rad/s] and weights on bit [N]."""
    return [(omega, wob) for omega in np.linspace(2.0, 20.0, count) for wob in np.linspace(5e3, 150e3, count)]


def run_all(given: list[tuple[float, float]]) -> list[list[float]]:
    """Run points one after the other in one instance."""
    from tests.plant.drive import Drive

    found: list[list[float]] = []
    with Drive("DrillstringNeutral", {}) as plant:
        for omega, wob in given:
            plant.call("Reset")
            plant.set(Omega=omega, WOB=wob)
            plant.initialize()
            plant.step(0.0, SETTLED)
            plant.step(SETTLED, END - SETTLED)
            found.append(plant.outputs())
    return found


def plain(count: int) -> None:
    """Run a plain loop."""
    run_all(points(count))


def joblib(count: int) -> None:
    """Run the points as joblib hands them out, in as many parts as suit it."""
    from joblib import Parallel, delayed
    from joblib.externals.loky import get_reusable_executor

    given = points(count)
    size = max(1, len(given) // 100)
    parts = [given[first : first + size] for first in range(0, len(given), size)]
    Parallel(n_jobs=WORKERS)(delayed(run_all)(part) for part in parts)
    get_reusable_executor().shutdown(wait=True)


def sweep(count: int) -> None:
    """Run a sweep."""
    from cosim import sweep as run_sweep

    grid = {"plant.Omega": f"2:20:{count}", "plant.WOB": f"5e3:150e3:{count}"}
    with tempfile.TemporaryDirectory() as folder:
        run_sweep("stick-slip", Path(folder, "map.zarr"), grid=grid, workers=WORKERS)


def short(count: int) -> None:
    """Run a sweep over points of 0.4 s, so that it shows what each costs beside the plant's own time."""
    from cosim import sweep as run_sweep
    from tests.cosim.sweeps.measuring import Last

    grid = {"plant.Omega": f"2:20:{count}", "plant.WOB": f"5e3:150e3:{count}"}
    with tempfile.TemporaryDirectory() as folder:
        measures = Last(window=0.2, sampling=0.2)
        run_sweep("stick-slip", Path(folder, "m.zarr"), grid=grid, workers=WORKERS, stop_time=0.4, measures=measures)


FORMS: dict[str, Callable[[int], None]] = {"plain loop": plain, "joblib": joblib, "sweep": sweep, "short": short}


def most_memory() -> float:
    """Return the greatest memory [MB] of this process; what the kernel counts of a child begins with its parent's."""
    status = Path("/proc/self/status")
    if not status.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    return float(dict(line.split(":") for line in status.read_text().splitlines())["VmHWM"].split()[0]) / 1e3


def cost(form: str, count: int) -> dict[str, float]:
    """Return CPU and wall time [s] of a form in a process of its own, and its greatest memory [MB]."""
    command = [sys.executable, "-m", "tests.bench.sweeps", form, str(count)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
    return json.loads(done.stdout.splitlines()[-1])


if __name__ == "__main__":
    began = time.perf_counter()
    FORMS[sys.argv[1]](int(sys.argv[2]))
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    cpu = sum(each.ru_utime + each.ru_stime for each in used)
    print(json.dumps({"cpu": cpu, "wall": time.perf_counter() - began, "memory": most_memory()}))
