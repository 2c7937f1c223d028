"""Write docs/benchmarks.md: the ratios of one run of the benchmarks, and the machine it ran on."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from cosim.run.report import commit

HEAD = """# Benchmarks

What the product costs, and what its users would pay for something else. All figures are of one run of `make bench` on
the machine below, each from the fastest of several rounds, so that ratios can be compared, and times only within this
page. `make bench` shows them on yours; `make bench ARGUMENTS=--page=docs/benchmarks.md` writes this page.
"""
AFTER = """
The peers solve the same plant for 100 s of Fig. 2: a careful script in numba on a ring buffer, with and without located
stops and releases; JiTCDDE, a compiled solver of delay equations; the method of lines in SciPy. Each is at the coarsest
resolution at which the period of the cycle is right to the error that is named, and every finer one that was tried is
right too. What took too long to be repeated was run once, on another day.
"""


def write_page(path: Path, ratios: Mapping[str, str], recorded: Iterable[str], benchmarks: Iterable[Any]) -> None:
    """Write the page."""
    lines = [HEAD, "## Ratios", "", "| what | figure |", "|---|---|"]
    lines += [f"| {name} | {text} |" for name, text in ratios.items()]
    lines += [f"| {each.partition(': ')[2]} (run once, in another run) | |" for each in recorded]
    lines += [AFTER, "## Times", "", "| benchmark | least [ms] | median [ms] | rounds |", "|---|---|---|---|"]
    lines += [
        f"| {each.name.removeprefix('bench_').replace('_', ' ')} | {each.stats.min * 1e3:.4g} | "
        f"{each.stats.median * 1e3:.4g} | {each.stats.rounds} |"
        for each in benchmarks
    ]
    lines += [
        "",
        "## Machine",
        "",
        "| | |",
        "|---|---|",
        *(f"| {name} | {text} |" for name, text in _machine().items()),
        "",
    ]
    path.write_text("\n".join(lines), encoding="utf-8")


def _machine() -> dict[str, str]:
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "fmpy", "numba", "jitcdde", "joblib"))
    return {
        "processor": f"{_processor()}, {os.cpu_count()} of its cores",
        "system": f"{platform.system()} {platform.machine()}",
        "Python": f"{platform.python_implementation()} {platform.python_version()}",
        "packages": packages,
        "this product": f"{version('drillstring-cosim')}, commit {commit() or 'unknown'}",
        "when": datetime.now(UTC).date().isoformat(),
    }


def _processor() -> str:
    """Return the name of the processor, as far as the system tells it."""
    listed = Path("/proc/cpuinfo")
    if listed.is_file():
        for line in listed.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
