"""What the product costs, beside what its users would do otherwise; run by `make bench`, which prints the ratios."""

from __future__ import annotations

from contextlib import ExitStack
from functools import partial

import numpy as np
import pytest

from tests.bench.coupled import LOOPS, STEPS
from tests.bench.native import run_do_step, run_kernel, run_plant
from tests.bench.peers import PEERS, Case, Slips, period_error
from tests.oracle import OracleParameters, Program, solve
from tests.plant.drive import Drive
from tests.plant.judge import judge

END = 100.0
COARSEST = 4
"""Cells from which on the period of Fig. 2 is right to 1e-6 s."""

POINTWISE = {"cells 320": 320, "default cells": 0}
"""Cells with which the bit speed of Fig. 2 is right to 1e-6 rad/s at every instant of 100 s."""


def slips(cells: int) -> Slips:
    """Return the slips of Fig. 2 as the plant FMU reports them in steps of 0.1 s, shorter than any but the echo's."""
    found: dict[float, float] = {}
    with Drive("DrillstringNeutral", {"cells": cells}) as plant:
        for k in range(1, int(END / 0.1) + 1):
            plant.go(0.1 * k)
            now = plant.named()
            if now["last_stop_time"] > now["last_release_time"]:
                found[now["last_stop_time"]] = now["last_release_time"]
    return Slips(np.array(list(found.values())), np.array(list(found)))


@pytest.mark.parametrize("form", ["bare kernel", "FMU"])
def bench_native_plant(benchmark, form: str) -> None:
    benchmark.group = "Fig. 2, 100 s in steps of 0.01 s"
    benchmark(partial(run_kernel if form == "bare kernel" else run_plant, 0.01, END))


@pytest.mark.parametrize("form", ["bare kernel", "fmi2DoStep"])
def bench_short_step(benchmark, form: str) -> None:
    benchmark.group = "Fig. 2, 20 s in steps of 1 ms, held inputs"
    benchmark(partial(run_kernel if form == "bare kernel" else run_do_step, 0.001, 20.0))


@pytest.fixture(scope="session")
def solution():
    """Return the independent solution of Fig. 2 over 100 s."""
    return solve(OracleParameters(), Program.constant(10.0), Program.constant(97347.0), END + 0.1)


@pytest.mark.parametrize("form", list(POINTWISE))
def bench_pointwise(benchmark, solution, form: str) -> None:
    benchmark.group = "Fig. 2, 100 s in one step, right to 1e-6 rad/s at every instant"
    cells, times = POINTWISE[form], np.arange(1, round(END / 0.01) + 1) * 0.01
    inputs = Program.constant(10.0), Program.constant(97347.0)
    error = judge(OracleParameters(), *inputs, times, solution, cells).errors["bit_speed"]
    benchmark.extra_info["error of bit_speed"] = error
    assert error <= 1e-6
    benchmark(partial(run_plant, END, END, cells=cells))


@pytest.mark.parametrize("omega", ["constant", "jumping"])
def bench_jumping_input(benchmark, omega: str) -> None:
    benchmark.group = "plant FMU, 20 s in steps of 1 ms"
    benchmark(partial(run_plant, 0.001, 20.0, jump=omega == "jumping"))


@pytest.mark.parametrize("form", list(LOOPS))
def bench_coupled_steps(benchmark, form: str) -> None:
    benchmark.group = f"plant and two laws coupled, {STEPS} steps"
    with ExitStack() as stack:

        def begin() -> tuple[tuple[object, ...], dict[str, object]]:
            stack.close()
            return (stack.enter_context(LOOPS[form]()),), {}

        benchmark.pedantic(lambda loop: loop.run(), setup=begin, rounds=10)


@pytest.mark.parametrize("error", [1e-4, 1e-6])
def bench_product(benchmark, error: float) -> None:
    benchmark.group = f"Fig. 2, 100 s at a period error of {error:g} s"
    benchmark.extra_info["period error"] = period_error(slips(COARSEST))
    assert benchmark.extra_info["period error"] <= error
    benchmark(partial(run_plant, 1.0, END, cells=COARSEST))


@pytest.mark.parametrize("case", [pytest.param(case, id=f"{case.peer}, {case.error:g}") for case in PEERS])
def bench_peer(benchmark, case: Case) -> None:
    benchmark.group = f"Fig. 2, 100 s at a period error of {case.error:g} s"
    case.prepare()
    found = benchmark.pedantic(case.run, rounds=case.rounds)
    benchmark.extra_info["period error"] = period_error(found)
    assert period_error(found) <= case.error
