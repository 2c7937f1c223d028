"""Derivatives of outputs over time, beside differences of the outputs (FMI 2.0.4, section 4.2.1)."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from cosim.check.bench import Bench
from cosim.check.exchange import Exchange
from cosim.check.instance import Instance
from cosim.check.simulate import Run
from cosim.check.states import unclaimed
from cosim.check.verdict import Outcome, failed, not_checked, passed
from cosim.system.description import Variable

LAST_PART = 1e-3
"""Part of a step over which a difference is taken, a time in which little else happens."""

ROUNDING = 1e-9
"""An output that varies by no more than this part of itself stands still: differences of it would be noise."""

_MOST, _CLOSE = 0.9, 0.05


def check_output_derivatives(bench: Bench) -> Outcome:
    """Compare first derivatives of outputs with differences, along the exercise and the reference experiments.

    Each step is taken twice, from a saved state, a little shorter and whole: so an output that tells of the last step,
    such as an extreme, is compared as well. Where an output has a kink at a communication point, a derivative may be
    that of either side, so that not all points need agree.
    """
    outputs = bench.continuous("output")
    if not bench.description.output_derivative_order:
        if not outputs:
            return not_checked("maxOutputDerivativeOrder is 0")
        return unclaimed(bench, "maxOutputDerivativeOrder", lambda i: i.output_derivatives(outputs[:1])[0])
    if not (bench.description.can_vary_step and bench.description.can_save_state):
        return not_checked("differences need states and steps of changing size, which are not claimed")
    agreeing = [pair for track in _tracks(bench, outputs) for pair in track.agreement().items()]
    if not agreeing:
        return not_checked("no continuous output changes in any run")
    name, share = min(agreeing, key=lambda pair: pair[1])
    judge = passed if share >= _MOST else failed
    return judge(f"{name}: right at {100.0 * share:.0f} % of points", f"{100.0 * _MOST:g} % of points")


class _Track:
    """Differences of outputs at the ends of steps, and the derivatives given there.

    Parameters
    ----------
    outputs : tuple of Variable
        Continuous ones.
    """

    def __init__(self, outputs: tuple[Variable, ...]) -> None:
        self._outputs = outputs
        self._exchange = Exchange("Real", outputs)
        self._values: list[list[float]] = []
        self._differences: list[list[float]] = []
        self._given: list[list[float]] = []

    def advance(self, instance: Instance, time: float, size: float) -> None:
        """Take a step but for its last part, go back, and take it whole [s]; CallError if that fails."""
        rest = LAST_PART * size
        state = instance.save()
        instance.step(time, size - rest)
        before = self._exchange.get(instance)
        instance.restore(state)
        instance.discard(state)
        instance.step(time, size)
        after = self._exchange.get(instance)
        status, derivatives = instance.output_derivatives(self._outputs)
        instance.judge("GetRealOutputDerivatives", status)
        self._values.append(after)
        self._differences.append([(late - early) / rest for early, late in zip(before, after, strict=True)])
        self._given.append(derivatives)

    def agreement(self) -> dict[str, float]:
        """Return for each output that changes the share of points at which its derivative is right."""
        values, differences, given = (np.array(rows) for rows in (self._values, self._differences, self._given))
        # all but the greatest, so that a jump does not set the scale
        scale = np.quantile(np.abs(differences), 0.9, axis=0)
        shares = (np.abs(given - differences) <= _CLOSE * scale).mean(axis=0)
        changes = np.ptp(values, axis=0) > ROUNDING * np.abs(values).max(axis=0)
        return {v.name: float(s) for v, s, change in zip(self._outputs, shares, changes, strict=True) if change}


def _tracks(bench: Bench, outputs: tuple[Variable, ...]) -> Generator[_Track]:
    """Yield the exercise with held inputs, and every reference experiment."""
    plan = bench.plan
    track = _Track(outputs)
    with bench.started() as instance:
        for index in range(plan.steps):
            track.advance(instance, plan.time(index), plan.step)
    yield track
    for experiment in bench.experiments:
        track = _Track(outputs)
        with bench.instance(experiment.name) as instance:
            Run(bench.description, experiment).results(instance, track.advance)
        yield track
