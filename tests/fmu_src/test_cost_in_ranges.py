"""No step inside the declared ranges takes more than 50 times the work of the start values, unless it is refused.

Work is counted in calls of Python functions by the slaves of the python packaging, which do what C does operation by
operation: a machine that is busy makes none of them.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random
from types import FrameType
from typing import Any

import pytest

from fmu_src.fmus import MODELS
from fmu_src.schema import Variable
from models.plant.work import INPUT_CREDIT, MOST_TIMES, SAVED, START_BLOCKS
from tests.plant.drive import DAMPED, PLANTS
from tests.plant.test_work import slave_of

DRAWS = 40
MOST_CALLS = 20_000_000
"""More than any course may take: one that does not end is given up there."""

USUAL_SIZE = 0.01
"""Of the steps of the default experiment [s]."""

SIZES = (1e-4, 1e-2, 0.1)
"""Of steps, in s: each is drawn between one of these and half of it."""


@dataclass
class Course:
    """Parameters and inputs to begin with, and steps in order: the size of each [s], and the inputs set before it."""

    start: dict[str, Any]
    steps: list[tuple[float, dict[str, float]]]


@dataclass
class Ride:
    """What a slave has done: calls made in its steps, time tried [s], changes of inputs, and whether it refused."""

    calls: int = 0
    time: float = 0.0
    changes: int = 0
    refused: bool = False
    told: list[str] = field(default_factory=list[str])


def calls_of(action: Callable[[], object]) -> tuple[int, object]:
    """Return how many functions an action calls, and what it returns."""
    calls = 0

    def count(_frame: FrameType, event: str, _argument: object) -> None:
        nonlocal calls
        calls += event == "call"
        if calls > MOST_CALLS:
            raise RecursionError(f"more than {MOST_CALLS} calls")

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        result = action()
    finally:
        sys.setprofile(before)
    return calls, result


def ridden(model: str, course: Course) -> Ride:
    """Take a course, up to a refusal."""
    slave = slave_of(model, course.start)
    ride = Ride(refused=bool(slave._refusals))
    time = 0.0
    for size, inputs in () if ride.refused else course.steps:
        for name, value in inputs.items():
            reference = slave.model.value_reference(name)
            ride.changes += slave.values[reference] != value
            slave.set_real([reference], [value])
        calls, stepped = calls_of(lambda at=time, size=size: slave.do_step(at, size))
        ride.calls += calls
        ride.time += size
        time += size
        ride.refused = not stepped
        if ride.refused:
            break
    ride.told = [message.msg for message in slave.log_queue]
    return ride


def drawn(random: Random, variable: Variable, share: float) -> Any:
    """Draw a legal value: of a share of them one from the range, an end, a magnitude or any; else the start value."""
    low, high = variable.minimum, variable.maximum
    if variable.kind not in ("Real", "Integer") or low is None or high is None or random.random() > share:
        return variable.start
    value = random.choice((low, high, _magnitude(random, low, high), random.uniform(low, high)))
    return int(value) if variable.kind == "Integer" else float(value)


def _magnitude(random: Random, low: float, high: float) -> float:
    greatest = max(abs(low), abs(high))
    value = math.exp(random.uniform(math.log(low if low > 0.0 else 1e-6 * greatest), math.log(greatest)))
    return min(max(value if low >= 0.0 else random.choice((-1.0, 1.0)) * value, low), high)


def course_of(model: str, random: Random) -> Course:
    """Draw a course through the ranges of a model."""
    share = random.choice((0.1, 0.3, 0.7))
    variables = [v for v in MODELS[model].variables if v.causality in ("parameter", "input")]
    start = {v.name: value for v in variables if (value := drawn(random, v, share)) != v.start}
    inputs = [v for v in variables if v.causality == "input" and v.kind == "Real"]
    sizes = [random.choice(SIZES) * random.uniform(0.5, 1.0) for _ in range(4)]
    return Course(start, [(size, {v.name: drawn(random, v, share) for v in inputs}) for size in sizes])


def allowed(model: str, course: Course, ride: Ride) -> float:
    """Return how many calls a ride may take: 50 times those of the start values in as many steps and as much time.

    The start values are stepped as well as the default experiment does it. A plant may be in arrears by what it has
    saved; what a change of an input brings is up to who sets it.
    """
    usual: dict[str, Any] = {}
    if model in PLANTS:
        usual = {"initial_speed": 10.0, "initial_torque": 8000.0} | ({"beta": 1e-3} if course.start.get("beta") else {})
    second = ridden(model, Course(usual, [(USUAL_SIZE, {})] * 20)).calls / (20 * USUAL_SIZE)
    a_step = ridden(model, Course(usual, [(SIZES[0], {})] * 20)).calls / 20
    saved = SAVED + INPUT_CREDIT * ride.changes / (MOST_TIMES * START_BLOCKS) if model in PLANTS else 0.0
    return MOST_TIMES * ((ride.time + saved) * second + len(course.steps) * a_step)


def examine(model: str, random: Random) -> tuple[Ride, float, Course]:
    """Take a course at random, and return with the ride what share of the calls that are allowed it took."""
    course = course_of(model, random)
    ride = ridden(model, course)
    return ride, ride.calls / allowed(model, course, ride), course


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS)
def test_no_step_inside_the_ranges_takes_more_than_fifty_times_the_usual_work(model: str) -> None:
    random = Random(model)
    rides: list[Ride] = []
    for number in range(DRAWS if model in PLANTS else DRAWS // 4):
        ride, share, course = examine(model, random)
        assert share <= 1.0, f"draw {number}: {ride} on {course}"
        assert ride.told or not ride.refused, f"draw {number}: refused without a sentence on {course}"
        rides.append(ride)
    assert any(ride.calls and not ride.refused for ride in rides)
    if model == DAMPED:
        assert any(ride.calls and ride.refused for ride in rides)
