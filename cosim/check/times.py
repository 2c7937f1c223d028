"""Whether an FMU copes with importers' time: another start, points added up, steps of changing size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cosim.check.bench import Bench
from cosim.check.exercise import Exercise, Record, Runner, not_finite
from cosim.check.verdict import Outcome, failed, not_checked, noted, passed

PATTERN = (0.5, 2.0, 0.5, 2.0, 1.0)
"""Steps of changing size, in step sizes of the plan; five steps over six, so that who ignores the size is too slow."""

_SHIFT = 12.5
_GROSS, _OFTEN, _SLIGHT, _TIMES, _FLOOR = 0.1, 0.2, 1e-3, 10.0, 1e-6


def check_start_time(bench: Bench) -> Outcome:
    """Start at another time than the default experiment."""
    plan = replace(bench.plan, start=bench.plan.start + _SHIFT, steps=min(bench.plan.steps, 50))
    with bench.instance() as instance:
        exercise = Exercise(bench.description, plan)
        exercise.initialise(instance)
        problem = not_finite(exercise.run(instance))
    found = problem or f"runs from {plan.start:g} s"
    return failed(found, "runs") if problem else passed(found, "runs")


def check_added_times(bench: Bench) -> Outcome:
    """Add step sizes up, as many importers do, so that communication points are off by rounding."""
    with bench.started() as instance:
        runner, time = Runner(bench.exercise, instance), bench.plan.start
        for index in range(bench.plan.steps):
            runner.step(index, time)
            time += bench.plan.step
    off = abs(time - bench.plan.time(bench.plan.steps))
    return passed(f"{bench.plan.steps} steps, off by {off:.1g} s at last", "no step refused")


def check_step_sizes(bench: Bench) -> Outcome:
    """Take steps of changing size with held inputs; results must differ no more than step sizes explain."""
    if not bench.description.can_vary_step:
        return not_checked("canHandleVariableCommunicationStepSize is not claimed")
    blocks = bench.plan.steps // round(sum(PATTERN))
    if not blocks:
        return not_checked(f"the default experiment has {bench.plan.steps} steps only")
    varied, plain, halved = (
        _blocks(bench, blocks, pattern)
        for pattern in (PATTERN, (1.0,) * round(sum(PATTERN)), (0.5,) * (2 * round(sum(PATTERN)) - 2) + (1.0,))
    )
    if problem := not_finite(varied):
        return failed(problem, "finite outputs")
    if not varied.reals.shape[1]:
        return passed(f"{blocks * len(PATTERN)} steps of changing size", "no step refused")
    return _judge(varied, plain, halved)


def _blocks(bench: Bench, blocks: int, pattern: tuple[float, ...]) -> Record:
    """Repeat a pattern of step sizes and keep the outputs at the end of each."""
    exercise = Exercise(bench.description, replace(bench.plan, moves=False))
    plan, length = bench.plan, sum(pattern)
    points = np.cumsum([0.0, *pattern])
    with bench.started() as instance:
        runner = Runner(exercise, instance)
        for block in range(blocks):
            for here, there in zip(points[:-1].tolist(), points[1:].tolist(), strict=True):
                begin = plan.start + (block * length + here) * plan.step
                instance.step(begin, plan.start + (block * length + there) * plan.step - begin)
            runner.read()
    return runner.record()


def _judge(varied: Record, plain: Record, halved: Record) -> Outcome:
    """Fail what is grossly off in a fifth of the run, note what is off beyond what halving the steps explains."""
    largest = np.abs(plain.reals).max(axis=0)
    scale = np.maximum(np.ptp(plain.reals, axis=0), _FLOOR * largest + np.finfo(float).tiny)
    off = np.abs(varied.reals - plain.reals) / scale
    explained = _TIMES * np.abs(plain.reals - halved.reals) / scale
    wrong = (off > _GROSS).mean(axis=0)
    beyond = (off - np.maximum(_SLIGHT, explained)).max(axis=0)
    if wrong.max() >= _OFTEN:
        return failed(_share(varied, off, int(np.argmax(wrong))), f"{100.0 * _GROSS:g} % of range")
    if beyond.max() > 0.0:
        return noted(_share(varied, off, int(np.argmax(beyond))), f"{100.0 * _SLIGHT:g} % of range")
    within = off.max() <= _SLIGHT
    allowed = f"{100.0 * _SLIGHT:g} % of range" if within else f"{_TIMES:g} x half steps"
    return passed(_share(varied, off, int(np.argmax(off.max(axis=0)))), allowed)


def _share(record: Record, off: NDArray[np.float64], column: int) -> str:
    return f"{record.names[column]} off by {100.0 * off[:, column].max():.2g} %"
