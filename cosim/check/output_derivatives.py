"""Derivatives of outputs over time, beside differences of the outputs (FMI 2.0.4, section 4.2.1)."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cosim.check.bench import Bench
from cosim.check.exchange import Exchange
from cosim.check.exercise import Exercise, Runner
from cosim.check.instance import Instance
from cosim.check.simulate import Run
from cosim.check.states import unclaimed
from cosim.check.verdict import Outcome, failed, not_checked, passed
from cosim.description import Variable

FloatArray = NDArray[np.float64]

_MOST, _CLOSE, _FEWEST = 0.9, 0.05, 8


def check_output_derivatives(bench: Bench) -> Outcome:
    """Compare first derivatives of outputs with differences, along the exercise and the reference experiments.

    A derivative is right if it agrees with the difference behind or ahead of it; at jumps and kinks neither need do.
    """
    outputs = bench.continuous("output")
    if not bench.description.output_derivative_order:
        if not outputs:
            return not_checked("maxOutputDerivativeOrder is 0")
        return unclaimed(bench, "maxOutputDerivativeOrder", lambda i: i.output_derivatives(outputs[:1])[0])
    agreeing = [pair for track in _tracks(bench, outputs) for pair in track.agreement().items()]
    if not agreeing:
        return not_checked("no continuous output changes in any run")
    name, share = min(agreeing, key=lambda pair: pair[1])
    judge = passed if share >= _MOST else failed
    return judge(f"{name}: right at {100.0 * share:.0f} % of points", f"{100.0 * _MOST:g} % of points")


class _Track:
    """Outputs and their derivatives along a run.

    Parameters
    ----------
    outputs : tuple of Variable
        Continuous ones.
    step : float
        Communication step size [s].
    """

    def __init__(self, outputs: tuple[Variable, ...], step: float) -> None:
        self._outputs, self._step = outputs, step
        self._exchange = Exchange("Real", outputs)
        self._values: list[list[float]] = []
        self._given: list[list[float]] = []

    def read(self, instance: Instance) -> None:
        """Get both after a step; CallError if that fails."""
        self._values.append(self._exchange.get(instance))
        status, derivatives = instance.output_derivatives(self._outputs)
        instance.judge("GetRealOutputDerivatives", status)
        self._given.append(derivatives)

    def agreement(self) -> dict[str, float]:
        """Return for each output that changes the share of points at which its derivative is right."""
        if len(self._values) < _FEWEST:
            return {}
        values, given = np.array(self._values), np.array(self._given)[2:-1]
        behind = (3.0 * values[2:-1] - 4.0 * values[1:-2] + values[:-3]) / (2.0 * self._step)
        ahead = (values[3:] - values[2:-1]) / self._step
        off = np.minimum(np.abs(given - behind), np.abs(given - ahead))
        # all but the greatest differences, so that a jump does not set the scale
        scale = np.maximum(np.quantile(np.abs(behind), 0.9, axis=0), 1e-9 * np.abs(values).max(axis=0) / self._step)
        shares = (off <= _CLOSE * scale).mean(axis=0)
        changes = np.ptp(values, axis=0) > 0.0
        return {v.name: float(s) for v, s, change in zip(self._outputs, shares, changes, strict=True) if change}


def _tracks(bench: Bench, outputs: tuple[Variable, ...]) -> Generator[_Track]:
    """Yield the exercise with held inputs, and every reference experiment."""
    plan = replace(bench.plan, moves=False)
    track = _Track(outputs, plan.step)
    with bench.started() as instance:
        runner = Runner(Exercise(bench.description, plan), instance)
        for index in range(plan.steps):
            runner.step(index)
            track.read(instance)
    yield track
    for experiment in bench.experiments:
        run = Run(bench.description, experiment)
        track = _Track(outputs, run.step)
        with bench.instance(experiment.name) as instance:
            run.results(instance, track.read)
        yield track
