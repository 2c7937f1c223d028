"""Holds a trajectory of the plant against the oracle: where the two can be compared, and how far apart they are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tests.oracle import OracleParameters, OracleSolution, Program, solve
from tests.plant.drive import Trajectory, follow

BARS = {
    "bit_speed": 1e-6, "top_speed": 1e-6,  # rad/s
    "bit_torque": 1e-3, "top_torque": 1e-3,  # N m
    "bit_angle": 1e-6, "top_angle": 1e-6,  # rad
}  # fmt: skip
RELATIVE_BARS = {"energy": 1e-8, "work_in": 1e-8, "bit_loss": 1e-8, "drive_work": 1e-8, "top_loss": 1e-8}
"""Relative to the energy that has passed through the string so far, 1 J at least."""
NEAR = 1e-9
"""Nearer than this to a jump of an output there is nothing to compare [s]."""
EVENT_BAR = 1e-7
"""Error of a stop or a release: what an error of 1e-6 rad/s makes of it at an acceleration of 10 rad/s^2 [s]."""


def away_from(times: np.ndarray, marks: Sequence[float] | np.ndarray, distance: float) -> np.ndarray:
    """Return for each time whether it is further than this from all marks [s]."""
    marks = np.sort(np.concatenate([[-np.inf], marks, [np.inf]]))
    place = np.searchsorted(marks, times)
    return np.minimum(times - marks[place - 1], marks[place] - times) > distance


def jumps(parameters: OracleParameters, omega: Program, wob: Program, solution: OracleSolution) -> np.ndarray:
    """Return the times at which an output may jump [s].

    A jump of Omega is back at one end or the other after every travel time, so are a jump of the waves at the start
    and one of the top itself; the torque on bit jumps with WOB and when the bit comes to rest.
    """
    echoes = np.arange(solution.end_time // parameters.travel_time + 2) * parameters.travel_time
    return np.concatenate([*(time + echoes for time in omega.times), wob.times, solution.stops, solution.crossings])


class Judgement:
    """A run of the native plant beside the oracle's solution.

    Attributes
    ----------
    run : Trajectory
        What the FMU put out.
    solution : OracleSolution
        The oracle.
    errors : dict of str to float
        Greatest error of each quantity that has a bar, in its bar's terms.
    """

    def __init__(
        self, parameters: OracleParameters, omega: Program, wob: Program, solution: OracleSolution, run: Trajectory
    ) -> None:
        self.run, self.solution = run, solution
        self.reference = solution(run.times)
        self.clear = away_from(run.times, jumps(parameters, omega, wob, solution), NEAR)
        self.errors = {name: self._distance(name).max() for name in BARS}
        passed = self.reference["energy"] + self.reference["bit_loss"]
        for name in RELATIVE_BARS:
            self.errors[name] = (self._distance(name) / np.maximum(1.0, passed[self.clear])).max()

    def _distance(self, name: str) -> np.ndarray:
        return np.abs(self.run[name] - self.reference[name])[self.clear]

    def excess(self) -> dict[str, float]:
        """Return the errors that are above their bars."""
        bars = BARS | RELATIVE_BARS
        return {name: error for name, error in self.errors.items() if not error <= bars[name]}

    def assert_same_events(self) -> None:
        """Compare stops, releases, and what is counted and summed over them."""
        run, solution = self.run, self.solution
        events = np.concatenate([solution.stops, solution.releases, solution.crossings])
        clear = away_from(run.times, events, EVENT_BAR)
        assert (run["bit_stuck"] == self.reference["bit_stuck"])[clear].all()
        assert (run["slip_count"] == self.reference["slip_count"])[clear].all()
        allowed = EVENT_BAR * (len(events) + 1)
        assert np.abs(run["stuck_time"] - self.reference["stuck_time"]).max() <= allowed
        for name, times in (("last_stop_time", solution.stops), ("last_release_time", solution.releases)):
            last = np.concatenate([[0.0], times])[np.searchsorted(times, run.times)]
            assert np.abs(run[name] - last)[clear].max() <= EVENT_BAR


def judge(
    parameters: OracleParameters,
    omega: Program,
    wob: Program,
    grid: np.ndarray,
    solution: OracleSolution | None = None,
    cells: int = 0,
) -> Judgement:
    """Run the native plant to the end of a grid of communication points and hold it against the oracle."""
    solution = solution or solve(parameters, omega, wob, float(grid[-1]) + 0.01)
    return Judgement(parameters, omega, wob, solution, follow(parameters, omega, wob, grid, cells=cells))
