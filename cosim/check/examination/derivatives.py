"""Check derivatives: of inputs and outputs over time (FMI 2.0.4, section 4.2.1), of outputs by inputs (section 2.1.9).

Each is compared with differences of what the FMU computes.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from cosim.check.examination.bench import Bench
from cosim.check.examination.exercise import Exercise, Runner
from cosim.check.examination.instance import Instance, VariableExchange
from cosim.check.examination.simulate import ExperimentRun
from cosim.check.examination.states import unclaimed
from cosim.check.verdict import Outcome, failed, not_checked, passed, sample
from cosim.system.description import Variable
from cosim.system.signals import FloatArray

_NEARER = 0.75
_NUDGE, _AGREE = 1e-6, 1e-4
_MOST_INPUTS, _MOST_PAIRS = 4, 100


def check_input_derivatives(bench: Bench) -> Outcome:
    """Ramp each input three ways: by derivatives, held at the start of each step, held at its middle.

    A slave that uses derivatives comes out nearer to the middle, which is right to second order, than to the start,
    which is half a step late.
    """
    inputs = bench.continuous("input")
    if not bench.description.can_interpolate_inputs:
        return _unclaimed_inputs(bench, inputs)
    if not inputs:
        return not_checked("there are no continuous inputs")
    used: list[str] = []
    for variable in sample(inputs, _MOST_INPUTS):
        by_slope = _ramp(bench, variable, 0.0, slopes=True)
        at_start, at_middle = (_ramp(bench, variable, place, slopes=False) for place in (0.0, 0.5))
        lag, rest = np.abs(by_slope - at_start), np.abs(by_slope - at_middle)
        if not np.abs(at_start - at_middle).any():
            continue
        if not lag.any():
            return failed(f"{variable.name}: accepted, and not used", "used")
        shares = rest.max(axis=0)[lag.any(axis=0)] / lag.max(axis=0)[lag.any(axis=0)]
        if np.median(shares) > _NEARER:
            found = f"{variable.name}: no nearer to the ramp than held values ({np.median(shares):.2g} of their lag)"
            return failed(found, f"at most {_NEARER:g} of their lag")
        used.append(f"{variable.name} ({np.median(shares):.2g})")
    if not used:
        return not_checked("no output answers to an input within the run")
    return passed(f"used; left of the lag: {', '.join(used)}", f"at most {_NEARER:g}")


def _unclaimed_inputs(bench: Bench, inputs: tuple[Variable, ...]) -> Outcome:
    if not inputs:
        return not_checked("canInterpolateInputs is not claimed")

    def attempt(instance: Instance) -> int:
        return instance.set_slopes({inputs[0]: 0.0})

    return unclaimed(bench, "canInterpolateInputs", attempt)


def _ramp(bench: Bench, variable: Variable, place: float, slopes: bool) -> FloatArray:
    """Run with one input on a ramp, set to its value at a place within each step, and return the Real outputs."""
    plan = replace(bench.plan, moves=False)
    start = float(variable.start or 0.0)
    slope = _room(variable, start) / (plan.steps * plan.step)
    with bench.started() as instance:
        runner = Runner(Exercise(bench.description, plan), instance)
        for index in range(plan.steps):
            instance.must_set(variable, start + slope * (index + place) * plan.step)
            if slopes:
                instance.judge("SetRealInputDerivatives", instance.set_slopes({variable: slope}))
            runner.step(index)
        return runner.record().reals


def _room(variable: Variable, start: float) -> float:
    """Return how far an input is moved: a tenth of its start value, or of one, away from the nearer bound."""
    reach = 0.1 * (abs(start) or 1.0)
    if variable.maximum is not None and start + reach > variable.maximum:
        return -reach
    return reach


def check_directional_derivatives(bench: Bench) -> Outcome:
    """Compare partial derivatives of outputs by inputs with differences, in initialization mode."""
    inputs, outputs = bench.continuous("input"), bench.continuous("output")
    if not bench.description.provides_directional_derivative:
        if not inputs or not outputs:
            return not_checked("providesDirectionalDerivative is not claimed")
        claim = "providesDirectionalDerivative"
        return unclaimed(bench, claim, lambda i: i.directional_derivative(outputs[0], inputs[0])[0])
    fed = {output: bench.description.fed_through(output.name, initially=True) for output in outputs}
    pairs = [(output, variable) for output in outputs for variable in inputs if variable.name in fed[output]]
    if not pairs:
        return not_checked("no output is declared to depend on an input directly")
    chosen = sample(pairs, _MOST_PAIRS)
    for output, variable in chosen:
        given, quotients = _partial(bench, output, variable)
        if not any(abs(given - each) <= _AGREE * max(abs(given), abs(each), _AGREE) for each in quotients):
            found = f"{output.name} by {variable.name}: {given:.9g}; difference quotients {_listed(quotients)}"
            return failed(found, f"within {_AGREE:g} of itself")
    found = f"{len(pairs)} right" if len(chosen) == len(pairs) else f"{len(chosen)} of {len(pairs)} tried, all right"
    return passed(found, f"within {_AGREE:g} of itself")


def _listed(quotients: Sequence[float]) -> str:
    return ", ".join(dict.fromkeys(f"{each:.9g}" for each in quotients))


def _partial(bench: Bench, output: Variable, variable: Variable) -> tuple[float, tuple[float, ...]]:
    """Return a partial derivative as given, and as differences in initialization mode: central, and to either side.

    At a kink, as the start value of an input can be one, it may be that of either side. The FMU must give it between
    steps as well, where there is no difference to compare with: to get after a set needs a step between.
    """
    start = float(variable.start or 0.0)
    nudge = _NUDGE * max(abs(start), 1.0)
    with bench.instance() as instance:
        instance.set_up(bench.plan.start)
        instance.must("EnterInitializationMode")
        status, given = instance.directional_derivative(output, variable)
        instance.judge("GetDirectionalDerivative", status)
        places = [place for place in (start - nudge, start, start + nudge) if _allowed(variable, place)]
        values = [_answer(instance, output, variable, place) for place in places]
        instance.must_set(variable, start)
        instance.must("ExitInitializationMode")
        status, later = instance.directional_derivative(output, variable)
        instance.judge("GetDirectionalDerivative", status)
    pairs = combinations(zip(places, values, strict=True), 2)
    quotients = tuple((high - low) / (end - begin) for (begin, low), (end, high) in pairs)
    return (given if np.isfinite(later) else later), quotients


def _allowed(variable: Variable, value: float) -> bool:
    low = -np.inf if variable.minimum is None else variable.minimum
    high = np.inf if variable.maximum is None else variable.maximum
    return bool(low <= value <= high)


def _answer(instance: Instance, output: Variable, variable: Variable, value: float) -> float:
    instance.must_set(variable, value)
    return float(instance.get(output))


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
        self._exchange = VariableExchange("Real", outputs)
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
            ExperimentRun(bench.description, experiment).results(instance, track.advance)
        yield track
