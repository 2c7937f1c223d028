"""The native plant against an oracle that shares no code with it, at every communication point away from jumps."""

from __future__ import annotations

import numpy as np
import pytest

from tests.oracle import Program
from tests.plant.drive import follow
from tests.plant.judge import Judgement, away_from, judge
from tests.plant.programs import CASES, PAPER, RAMPS, SPEED, WEIGHT, solved

pytestmark = pytest.mark.slow

FIGURE_2 = "stick-slip of figure 2"
OTHERS = [name for name in CASES if name != FIGURE_2]
STEPS = (0.0137, 0.1, 5.0, "random")


def communication_points(step: float | str, end: float) -> np.ndarray:
    """Return communication points from one step on to an end that all kinds of steps share."""
    if step == "random":
        drawn = np.cumsum(np.random.default_rng(3).exponential(0.05, int(end / 0.04)))
        return np.append(drawn[drawn < end - 1e-3], end)
    return np.arange(1, int(end / step + 1e-9) + 1) * step


def judged(name: str, step: float | str) -> Judgement:
    case = (CASES | RAMPS)[name]
    return judge(case.parameters, case.omega, case.wob, communication_points(step, case.end), solved(name))


@pytest.mark.parametrize("step", [pytest.param(0.001, marks=pytest.mark.slow), *STEPS])
def test_figure_2_over_100_s_is_the_oracles(step):
    judgement = judged(FIGURE_2, step)
    assert judgement.excess() == {}
    judgement.assert_same_events()


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("name", OTHERS)
def test_other_strings_and_jumping_inputs_are_the_oracles(name, step):
    judgement = judged(name, step)
    assert judgement.excess() == {}
    judgement.assert_same_events()


@pytest.mark.parametrize("step", [0.0137, 0.1, "random"])
@pytest.mark.parametrize("name", RAMPS)
def test_ramps_given_by_derivatives_are_the_oracles(name, step):
    judgement = judged(name, step)
    assert judgement.excess() == {}
    judgement.assert_same_events()


@pytest.mark.parametrize("parts", [1, 6, 48])
@pytest.mark.parametrize("changes", ["drive", "weight"])
def test_an_input_that_changes_at_ends_of_cells_is_the_oracles(changes, parts):
    # a travel time is a whole number of cells, and so are these parts of it
    times = np.arange(int(10.0 / PAPER.travel_time) * parts) * PAPER.travel_time / parts
    drawn = np.random.default_rng(parts).uniform(0.9, 1.1, len(times))
    omega = Program.held(times, 10.0 * drawn) if changes == "drive" else SPEED
    wob = Program.held(times, 97347.0 * drawn) if changes == "weight" else WEIGHT
    assert judge(PAPER, omega, wob, communication_points("random", 10.0)).excess() == {}


@pytest.mark.parametrize("name", [*CASES, *RAMPS])
def test_cases_hold_the_stops_and_turns_they_are_there_for(name):
    case, solution = (CASES | RAMPS)[name], solved(name)
    assert len(solution.stops) >= case.stops
    lowest, highest = solution.bit_speed_extremes(0.0, case.end)
    assert highest > 1.0
    assert lowest <= case.lowest


def test_first_events_of_figure_2_are_at_the_known_times():
    # from a solver of another kind, good to 1e-9 s
    run = follow(PAPER, SPEED, WEIGHT, [2.7, 4.3, 5.59, 5.7])
    assert run["last_release_time"] == pytest.approx([2.603019251, 2.603019251, 5.577898395, 5.577898395], abs=2e-9)
    assert run["last_stop_time"] == pytest.approx([0.0, 4.226441632, 4.226441632, 5.607609331], abs=2e-9)


@pytest.mark.parametrize("name", [FIGURE_2, "inputs that jump on no grid"])
def test_range_of_bit_speed_between_communication_points_is_the_oracles(name):
    case, solution = CASES[name], solved(name)
    grid = np.cumsum(np.random.default_rng(4).exponential(0.4, int(2 * case.end)))
    run = follow(case.parameters, case.omega, case.wob, grid[grid < case.end])
    begins = np.concatenate([[0.0], run.times[:-1]])
    ranges = np.array([solution.bit_speed_extremes(*span) for span in zip(begins, run.times, strict=True)])
    assert len(ranges) > 50
    assert np.abs(run["bit_speed_min"] - ranges[:, 0]).max() <= 1e-6
    assert np.abs(run["bit_speed_max"] - ranges[:, 1]).max() <= 1e-6


def test_output_at_a_jump_is_the_left_limit_of_what_the_oracle_has_there():
    case, solution = CASES["drive reversed"], solved("drive reversed")
    jump = case.omega.times[1]
    run = follow(case.parameters, case.omega, case.wob, [jump - 1e-3, jump, jump + 1e-3])
    assert run["top_speed"] == pytest.approx(solution(run.times)["top_speed"], abs=1e-6)
    assert abs(run["top_speed"][2] - run["top_speed"][1]) > 10.0


def test_almost_all_points_are_compared():
    case = CASES["inputs that jump on no grid"]
    judgement = judged("inputs that jump on no grid", 0.0137)
    assert judgement.clear.sum() >= len(judgement.run.times) - len(case.omega.times) - len(case.wob.times)
    assert away_from(np.array([1.0, 2.0]), [2.0 + 5e-10], 1e-9).tolist() == [True, False]
