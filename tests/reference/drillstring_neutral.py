"""Reference experiments of the plant, answered by the oracle."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np

from tests.oracle import OracleParameters, OracleSolution, Program, solve
from tests.plant.judge import jumps
from tests.reference.experiment import Answers, Experiment, Points, Tolerance, held

DEFAULTS: Mapping[str, Points] = {"Omega": held((0.0, 10.0)), "WOB": held((0.0, 97347.0))}

DIGITS = 12
"""Of the references: the oracle is good to ten."""

_SPEED = "the accuracy promised for a run of 100 s; the reference is good to 1e-10 of its greatest value"
_TURNED = "1e-6 rad/s kept up for the 30 s of the longest experiment"
_STORED = "1e-6 rad/s at 30 rad/s in string and bit of 300 kg m2"
_PASSED = "speeds off by 1e-6 rad/s and torques by 2e-3 N m make a power off by at most 3e-7 of itself"
_SLID = "torques off by 2e-3 N m make their squares off by at most 6e-7 of themselves"
_EVENTS = "the same stops and releases; the reference leaves out times within 1e-4 s of any"
_INSTANT = "1e-6 rad/s at an acceleration of 10 rad/s2"

TOLERANCES = {
    "bit_speed": Tolerance(_SPEED, 1e-6),
    "top_speed": Tolerance(_SPEED, 1e-6),
    "bit_torque": Tolerance("1e-6 rad/s where the friction falls most steeply, by 4.6e3 N m s/rad", 5e-3),
    "top_torque": Tolerance("1e-6 rad/s at c_a, 2000 N m s/rad at most", 2e-3),
    "bit_angle": Tolerance(_TURNED, 3e-5),
    "top_angle": Tolerance(_TURNED, 3e-5),
    "bit_stuck": Tolerance(_EVENTS),
    "energy": Tolerance(_STORED, 1e-2),
    "bit_speed_min": Tolerance("as bit_speed", 1e-6),
    "bit_speed_max": Tolerance("as bit_speed", 1e-6),
    "stuck_time": Tolerance("1e-7 s for each of at most twenty stops and releases", 2e-6),
    "slip_count": Tolerance(_EVENTS),
    "last_stop_time": Tolerance(_INSTANT, 1e-7),
    "last_release_time": Tolerance(_INSTANT, 1e-7),
    "work_in": Tolerance(_PASSED, 1e-2, 3e-7),
    "bit_loss": Tolerance(_PASSED, 1e-2, 3e-7),
    "drive_work": Tolerance(_PASSED, 1e-2, 3e-7),
    "top_loss": Tolerance(_SLID, 1e-2, 6e-7),
}


class Plant:
    """The oracle's solution of one experiment.

    Parameters
    ----------
    stop_time : float
        End of the run [s].
    parameters, inputs : mapping
        Other than the start values of the FMU.
    """

    def __init__(self, stop_time: float, parameters: Mapping[str, float], inputs: Mapping[str, Points]) -> None:
        self._end = stop_time
        self._parameters = OracleParameters(**parameters)
        programs = {name: _program(points) for name, points in (DEFAULTS | inputs).items()}
        self._omega, self._wob = programs["Omega"], programs["WOB"]

    @cache  # noqa: B019 (a handful of these live as long as the process)
    def solution(self) -> OracleSolution:
        """Solve once."""
        return solve(self._parameters, self._omega, self._wob, self._end + 0.01)

    def jumps(self) -> np.ndarray:
        """Return when an output may jump, the start apart [s]."""
        times = [jumps(self._parameters, self._omega, self._wob, self.solution()), self.solution().releases]
        return (every := np.concatenate(times))[every > 0.0]

    def answer(self, times: np.ndarray, step_size: float) -> Answers:
        """Return every output of the FMU that does not tell of its own method."""
        solution = self.solution()
        found = solution(times)
        spans = [solution.bit_speed_extremes(max(time - step_size, 0.0), time) for time in times]
        events = {"last_stop_time": solution.stops, "last_release_time": solution.releases}
        last = {
            name: np.concatenate([[0.0], instants])[np.searchsorted(instants, times)]
            for name, instants in events.items()
        }
        least, greatest = np.array(spans).T
        answers = {**found, **last, "bit_speed_min": least, "bit_speed_max": greatest}
        return {name: answers[name] for name in TOLERANCES}


def _program(points: Points) -> Program:
    """Return the oracle's form of an input."""
    ends = [*points[1:], (np.inf, points[-1][1])]
    spans = [(*begin, end) for begin, end in zip(points, ends, strict=True) if end[0] > begin[0]]
    slopes = [0.0 if np.isinf(end[0]) else (end[1] - value) / (end[0] - time) for time, value, end in spans]
    return Program([span[0] for span in spans], [span[1] for span in spans], slopes)


def _experiment(
    name: str,
    description: str,
    stop_time: float,
    step_size: float,
    every: int,
    parameters: Mapping[str, float] | None = None,
    inputs: Mapping[str, Points] | None = None,
) -> Experiment:
    plant = Plant(stop_time, parameters or {}, inputs or {})
    return Experiment(
        name, description, stop_time, step_size, every, plant.answer, TOLERANCES, parameters or {}, inputs or {},
        DIGITS, plant.jumps,
    )  # fmt: skip


EXPERIMENTS = (
    _experiment(
        "stick-slip",
        "Nothing set: stick-slip from rest, Fig. 2 of the paper, with the short second slip at 5.58 s",
        30.0, 0.01, 10,
    ),
    _experiment(
        "higher-speed", "Steady drilling at a higher speed, Fig. 4 of the paper, in longer steps",
        30.0, 0.05, 5, inputs={"Omega": held((0.0, 20.0)), "WOB": held((0.0, 97347.0))},
    ),
    _experiment(
        "input-changes", "Weight lowered and raised, drive brought up in a staircase, while the bit sticks and slips",
        30.0, 0.02, 5,
        inputs={
            "Omega": held((0.0, 10.0), *((12.0 + 0.5 * k, 11.0 + k) for k in range(8))),
            "WOB": held((0.0, 97347.0), (5.0, 60000.0), (22.0, 110000.0)),
        },
    ),
    _experiment(
        "reverse-slip", "The weight is lifted off a wound-up string: the bit is thrown forward, then turns back",
        20.0, 0.025, 4,
        inputs={"WOB": held((0.0, 97347.0), (2.5, 5000.0), (6.0, 97347.0), (15.0, 500.0))},
    ),
    _experiment(
        "another-string", "Every parameter other than its default; the string starts turning, and wound up backwards",
        20.0, 0.1, 1,
        parameters={
            "G": 82e9, "J": 1.4e-5, "I": 0.11, "L": 1500.0, "I_B": 120.0, "c_a": 1500.0, "c_b": 0.5, "R_b": 0.12,
            "mu_cb": 0.45, "mu_sb": 0.7, "gamma_b": 0.7, "v_f": 1.3, "initial_speed": 5.0, "initial_torque": -15000.0,
        },
        inputs={"Omega": held((0.0, 9.0)), "WOB": held((0.0, 90000.0))},
    ),
    _experiment(
        "ramps", "Drive and weight run up on straight lines, followed by input derivatives in long steps",
        30.0, 0.25, 1,
        inputs={
            "Omega": ((0.0, 0.0), (2.0, 0.0), (14.0, 12.0)),
            "WOB": ((0.0, 20000.0), (5.0, 20000.0), (15.0, 97347.0)),
        },
    ),
)  # fmt: skip
