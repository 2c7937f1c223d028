"""Order of convergence with the number of cells, across stops, releases and jumps at times on no grid."""

from __future__ import annotations

import numpy as np
import pytest

from tests.oracle import solve
from tests.plant.judge import judge
from tests.plant.programs import CASES

CELLS = np.array([96, 192, 384, 768])
"""Finer grids reach what the independent solution is accurate to; on coarser ones pieces are halved, not cells."""


def order(cells: np.ndarray, errors: np.ndarray) -> float:
    """Return the order that fits errors best."""
    return -float(np.polyfit(np.log(cells), np.log(errors), 1)[0])


NAMES = ["stick-slip of figure 2", "inputs that jump on no grid", "drive reversed", "weight lifted off while wound up"]


@pytest.mark.parametrize("output", ["bit_speed", "top_speed"])
@pytest.mark.parametrize("name", NAMES)
def test_order_of_convergence_across_events_is_four_at_least(name, output, errors_by_cells):
    errors = errors_by_cells(name)
    assert order(CELLS, np.array([errors[int(cells)][output] for cells in CELLS])) >= 4.0


@pytest.fixture(scope="module")
def errors_by_cells():
    """Return the errors of a case for each number of cells, worked out once."""
    known: dict[str, dict[int, dict[str, float]]] = {}

    def errors(name: str) -> dict[int, dict[str, float]]:
        if name not in known:
            case = CASES[name]
            parameters = case.parameters
            solution = solve(parameters, case.omega, case.wob, 20.1)
            assert len(solution.stops) >= 3
            grid = np.arange(1, int(20.0 / 0.0137)) * 0.0137
            known[name] = {
                int(cells): judge(parameters, case.omega, case.wob, grid, solution, int(cells)).errors
                for cells in CELLS
            }
        return known[name]

    return errors


def test_order_is_told_from_a_lower_one():
    assert order(CELLS, 10.0 / CELLS**3.0) == pytest.approx(3.0)
