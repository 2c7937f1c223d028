"""A severity map of 65 x 65 points of 100 s beside a plain loop of bare FMU steps, and what a point costs of many."""

from __future__ import annotations

import pytest

from tests.bench.sweeps import WORKERS, cost

COUNT = 65


@pytest.mark.parametrize("form", ["plain loop", "joblib", "sweep"])
def bench_map(benchmark, form: str) -> None:
    benchmark.group = f"map of {COUNT} x {COUNT} points of 100 s, {WORKERS} workers"
    found = benchmark.pedantic(lambda: cost(form, COUNT), rounds=1)
    benchmark.extra_info.update(found)


@pytest.mark.parametrize("count", [10, 100, 316])
def bench_short_points(benchmark, count: int) -> None:
    benchmark.group = f"sweeps of points of 0.4 s, {WORKERS} workers"
    found = benchmark.pedantic(lambda: cost("short", count), rounds=1)
    benchmark.extra_info.update(found, points=count**2)
