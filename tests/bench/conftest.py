"""Below pytest-benchmark's tables, the ratios that matter, each from the fastest rounds of this run."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

from tests.bench.coupled import LOOPS, STEPS
from tests.bench.page import write_page
from tests.bench.peers import RECORDED


def pytest_addoption(parser: Any) -> None:
    parser.addoption("--page", default="", help="Write the page of benchmarks to this file.")


def pytest_terminal_summary(terminalreporter: Any, config: Any) -> None:
    session = getattr(config, "_benchmarksession", None)
    least = {bench.name: bench.stats.min for bench in session.benchmarks} if session else {}
    if not least:
        return
    write = terminalreporter.write_line
    write("")
    costs = {bench.name: bench.extra_info for bench in session.benchmarks if "cpu" in bench.extra_info}
    ratios = _ratios(least) | _sweeps(costs)
    for name, text in ratios.items():
        write(f"{name:<72}{text}")
    recorded = [f"recorded once: {run.peer}, period error {run.error:g} s: {run.seconds:g} s" for run in RECORDED]
    for line in recorded:
        write(line)
    if page := config.getoption("--page"):
        write_page(Path(page), ratios, recorded, session.benchmarks)


def _sweeps(costs: dict[str, dict[str, float]]) -> dict[str, str]:
    """Return what sweeps cost beside a plain loop in this run, and what one more point costs of few and of many."""
    lines: dict[str, str] = {}
    if alone := costs.get("bench_map[plain loop]"):
        for form in ("sweep", "joblib"):
            if found := costs.get(f"bench_map[{form}]"):
                ratios = (
                    f"{found['cpu'] / alone['cpu']:.2f} times the CPU, {found['wall'] / alone['wall']:.2f} the time"
                )
                lines[f"map of 65 x 65 points, {form} against a plain loop"] = ratios
    short = sorted((each for each in costs.values() if "points" in each), key=lambda each: each["points"])
    for few, many in pairwise(short):
        each = (many["cpu"] - few["cpu"]) / (many["points"] - few["points"])
        lines[f"a point of a sweep, from {few['points']:.0f} to {many['points']:.0f} points"] = (
            f"{each * 1e3:.3f} ms of CPU, {many['memory']:.0f} MB at {many['points']:.0f}"
        )
    return lines


def _ratios(least: dict[str, float]) -> dict[str, str]:
    """Return each comparison with its figure, as far as both sides have been timed."""
    lines: dict[str, str] = {}
    if fmu := least.get("bench_native_plant[FMU]"):
        lines["Fig. 2, 100 s in steps of 0.01 s, native FMU"] = f"{fmu * 1e3:.2f} ms"
    if fmu := least.get("bench_short_step[fmi2DoStep]"):
        lines["fmi2DoStep of 1 ms, held inputs"] = f"{fmu / 20e3 * 1e6:.2f} us"
    for form in ("cells 320", "default cells"):
        if time := least.get(f"bench_pointwise[{form}]"):
            lines[f"Fig. 2, 100 s in one step, right to 1e-6 rad/s, {form}"] = f"{time * 1e3:.2f} ms"
    held, jumping = (least.get(f"bench_jumping_input[{omega}]") for omega in ("constant", "jumping"))
    if held and jumping:
        lines["Omega jumps every 1 ms against constant Omega"] = f"{jumping / held:.2f} times the cost"
    loops = {form: least.get(f"bench_coupled_steps[{form}]") for form in LOOPS}
    if alone := loops["FMUs alone"]:
        for form, time in loops.items():
            if time and form != "FMUs alone":
                over = (time - alone) / STEPS * 1e6
                lines[f"coupled step of plant and two laws, {form}"] = f"{over:.2f} us beyond the FMUs' own time"
    for error in ("0.0001", "1e-06"):
        own = least.get(f"bench_product[{error}]")
        for name, time in least.items():
            if own and name.startswith("bench_peer[") and name.endswith(f", {error}]"):
                peer = name[len("bench_peer[") : -len(f", {error}]")]
                lines[f"{peer} against the product, period error {error} s"] = f"{time / own:.1f} times the time"
    return lines
