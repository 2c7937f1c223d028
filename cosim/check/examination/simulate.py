"""Run one reference experiment, and find how far its results are from the references, and whether that is allowed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from cosim.check.examination.bench import Bench
from cosim.check.examination.instance import CallError, Instance, exchanges
from cosim.check.reference import SAME_TIME, Experiment, Series, Tolerance, same_time
from cosim.check.verdict import Comparison, Outcome, Verdict, counted, failed, not_checked, passed, some
from cosim.errors import InputError
from cosim.system.compatibility import convert
from cosim.system.description import Description, Variable
from cosim.system.signals import FloatArray, Value

_LAST = 1e-6
Advance = Callable[[Instance, float, float], None]
"""Takes a step of an instance from a communication point, of a size [s]."""


def check_experiment(bench: Bench, name: str) -> Outcome:
    """Run an experiment of the reference and compare all that its results hold."""
    description = bench.description
    experiment = next(each for each in bench.experiments if each.name == name)
    if experiment.references is None:
        return not_checked("it has no reference results")
    run = ExperimentRun(description, experiment)
    if experiment.tolerances and run.sloping and not description.can_interpolate_inputs:
        return not_checked(f"{', '.join(run.sloping)}: has slopes, and canInterpolateInputs is not claimed")
    if not run.compared:
        return failed("no column of the reference is a variable of the FMU", "at least one")
    with bench.instance(name) as instance:
        results = run.results(instance)
    comparisons = [
        comparison
        for result in results
        if (comparison := _compare(experiment, experiment.references, result, run.step))
    ]
    return _outcome(run, comparisons)


def _compare(experiment: Experiment, references: Series, result: Response, step: float) -> Comparison | None:
    name = result.variable.name
    tolerance = experiment.tolerances.get(name)
    tolerance = tolerance or default_tolerance(result.variable, references.column(name), step)
    return compare(experiment.name, result, references, tolerance)


def _outcome(run: ExperimentRun, comparisons: list[Comparison]) -> Outcome:
    if not comparisons:
        return failed("the reference holds no time within the run", "at least one")
    wrong = [comparison for comparison in comparisons if comparison.verdict is Verdict.FAILED]
    worst = max(comparisons, key=lambda comparison: comparison.share)
    if wrong:
        names = some([comparison.variable for comparison in wrong])
        found = f"{len(wrong)} of {len(comparisons)} variables wrong ({names}); {worst.variable} is {worst.result:.9g} "
        found += f"at t = {worst.time:g} s, reference {worst.reference:.9g}"
    else:
        found = f"{100.0 * worst.share:.2g} % of allowed, {counted(len(comparisons), 'variable')}"
    if run.missing:
        found += f"; not in the FMU: {some(list(run.missing))}"
    data = [asdict(each) for each in comparisons]
    return (failed if wrong else passed)(found, "see below", done=run.title, data=data)


class ExperimentRun:
    """An experiment on an FMU: its communication points, its inputs, and what is read.

    Parameters
    ----------
    description : Description
        Of the FMU.
    experiment : Experiment
        With references.

    Raises
    ------
    InputError
        If a parameter or an input does not fit the FMU.
    """

    def __init__(self, description: Description, experiment: Experiment) -> None:
        references = experiment.references
        columns = () if references is None else tuple(references.texts)
        self._experiment = experiment
        self._interpolates = description.can_interpolate_inputs
        compared = [v for v in description.variables if v.name in columns and v.type != "String"]
        self._groups = exchanges(compared)
        self.compared = tuple(variable for group in self._groups for variable in group.variables)
        self.missing = tuple(name for name in columns if name not in description.by_name)
        self._start_values: dict[Variable, Value] = {}
        for name, given in experiment.parameters.items():
            variable = _settable(description, name)
            self._start_values[variable] = convert(name, variable, given.for_variable(name, variable))
        driven = () if experiment.stimuli is None else tuple(experiment.stimuli.texts)
        self._driven = tuple(_input(description, name) for name in driven if name in description.by_name)
        self._plan_times(description, experiment, references)

    def _plan_times(self, description: Description, experiment: Experiment, references: Series | None) -> None:
        last = float(references.times[-1]) if references is not None else 0.0
        start = _first(experiment.start_time, description.start_time, 0.0)
        stop = _first(experiment.stop_time, description.stop_time, last)
        self.step = _first(experiment.step_size, description.step_size, (stop - start) / 500)
        if not stop > start or not self.step > 0.0:
            raise InputError(f"{experiment.name}: from {start:g} s to {stop:g} s in steps of {self.step:g} s is no run")
        count = round((stop - start) / self.step)
        whole = abs(start + count * self.step - stop) <= _LAST * self.step
        count = count if whole else int((stop - start) / self.step)
        points = [start + index * self.step for index in range(count + 1)]
        if description.can_vary_step:
            jumps = experiment.stimuli.jumps if experiment.stimuli is not None else ()
            extra = [time for time in (*jumps, stop) if start < time <= stop and not _among(time, points)]
            points = sorted([*points, *extra])
        self.points = points
        self.title = f"{counted(count, 'step')} of {self.step:g} s"

    @property
    def sloping(self) -> tuple[str, ...]:
        """Names of inputs that change between communication points."""
        stimuli = self._experiment.stimuli
        if stimuli is None:
            return ()
        return tuple(
            variable.name
            for variable in self._driven
            if variable.is_continuous and any(stimuli.slope(variable.name, time) for time in self.points[:-1])
        )

    def results(self, instance: Instance, advance: Advance = Instance.step) -> list[Response]:
        """Run to where experiment or FMU ends, `advance` taking each step; CallError if a call fails."""

        def prepare() -> None:
            for variable, value in self._start_values.items():
                instance.must_set(variable, value)
            self._set_inputs(instance, self.points[0])

        instance.initialise(self.points[0], prepare)
        rows = [self._read(instance)]
        for here, there in zip(self.points[:-1], self.points[1:], strict=True):
            self._set_inputs(instance, here)
            self._set_slopes(instance, here)
            try:
                advance(instance, here, there - here)
            except CallError as error:
                if instance.wants_to_end(error):
                    break
                raise
            rows.append(self._read(instance))
        table = np.array(rows, dtype=np.float64)
        times = np.array(self.points[: len(rows)])
        return [Response(variable, times, table[:, place]) for place, variable in enumerate(self.compared)]

    def _read(self, instance: Instance) -> list[float]:
        return [float(value) for group in self._groups for value in group.get(instance)]

    def _set_inputs(self, instance: Instance, time: float) -> None:
        stimuli = self._experiment.stimuli
        if stimuli is None:
            return
        for variable in self._driven:
            value = stimuli.value(variable.name, time, interpolate=variable.is_continuous)
            instance.must_set(variable, _typed(variable, value))

    def _set_slopes(self, instance: Instance, time: float) -> None:
        stimuli = self._experiment.stimuli
        if stimuli is None or not self._interpolates:
            return
        slopes = {v: stimuli.slope(v.name, time) for v in self._driven if v.is_continuous}
        slopes = {variable: slope for variable, slope in slopes.items() if slope}
        if slopes:
            instance.judge("SetRealInputDerivatives", instance.set_slopes(slopes))


def _first(*values: float | None) -> float:
    return next(value for value in values if value is not None)


def _among(time: float, points: list[float]) -> bool:
    return any(same_time(time, point) for point in points)


def _typed(variable: Variable, value: float) -> Value:
    if variable.type == "Real":
        return value
    return bool(value) if variable.type == "Boolean" else int(value)


def _settable(description: Description, name: str) -> Variable:
    variable = description.by_name.get(name)
    if variable is None or not variable.settable:
        raise InputError(f"parameter {name}: expected the name of a variable with a start value")
    return variable


def _input(description: Description, name: str) -> Variable:
    variable = description.by_name[name]
    if not variable.settable or variable.type == "String":
        raise InputError(f"input {name}: expected an input or a parameter that is no String")
    return variable


RANGE_SHARE = 1e-3
UNSTATED = "none stated, so 0.1 % of the reference's range, and up to one step early or late"
UNSTATED_DISCRETE = "none stated, so equal, and up to one step early or late"


@dataclass(frozen=True)
class Response:
    """One variable over the communication points of a run."""

    variable: Variable
    times: FloatArray
    values: FloatArray


def default_tolerance(variable: Variable, reference: FloatArray, step: float) -> Tolerance:
    """Return what is allowed where nobody has said what is.

    A reference that says nothing of its own accuracy was made to be looked at: a thousandth of a signal's range is less
    than a line's width in a plot. Tools record an event at the communication point before or after it, so that a
    result may be early or late by one step.

    Parameters
    ----------
    variable : Variable
        What is compared.
    reference : ndarray
        All its values.
    step : float
        Communication step size [s].
    """
    if variable.type != "Real":
        return Tolerance(UNSTATED_DISCRETE, time=step)
    reach = float(np.ptp(reference)) or float(np.abs(reference).max())
    return Tolerance(UNSTATED, absolute=RANGE_SHARE * reach, time=step)


def compare(experiment: str, result: Response, references: Series, tolerance: Tolerance) -> Comparison | None:
    """Compare a result with its reference at the times they share.

    Where they share less than half of the reference's times, a continuous result is interpolated.

    Parameters
    ----------
    experiment : str
        Its name.
    result : Response
        At communication points.
    references : Series
        With a column of the variable's name.
    tolerance : Tolerance
        What is allowed.

    Returns
    -------
    Comparison or None
        Where the result is worst; None if there is no time to compare at.
    """
    values = references.column(result.variable.name)
    times = np.unique(references.times)
    inside = times[(times >= result.times[0] - 1e-9) & (times <= result.times[-1] + 1e-9)]
    at, found = _at(result, inside)
    if not at.size:
        return None
    low, high = _band(references.times, values, at, tolerance.time, result.variable)
    off = np.maximum(np.maximum(low - found, found - high), 0.0)
    off = np.where(np.isfinite(found), off, np.inf)
    allowed = tolerance.absolute + tolerance.relative * np.maximum(np.abs(low), np.abs(high))
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(off == 0.0, 0.0, off / allowed)
    worst = int(np.argmax(share))
    unit = result.variable.unit.name if result.variable.unit else ""
    nearest = low[worst] if abs(found[worst] - low[worst]) <= abs(found[worst] - high[worst]) else high[worst]
    return Comparison(
        experiment, result.variable.name, unit, float(at[worst]), float(found[worst]), float(nearest),
        float(off[worst]), float(allowed[worst]), int(at.size), tolerance.reason,
    )  # fmt: skip


def _at(result: Response, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return times at which a result can be compared, and its values there."""
    places = np.clip(np.searchsorted(result.times, times), 0, len(result.times) - 1)
    before = np.maximum(places - 1, 0)
    nearer = np.where(np.abs(result.times[before] - times) < np.abs(result.times[places] - times), before, places)
    pairs = zip(result.times[nearer].tolist(), times.tolist(), strict=True)
    shared = np.array([same_time(one, other) for one, other in pairs], dtype=bool)
    if shared.sum() * 2 >= len(times) or not result.variable.is_continuous:
        return times[shared], result.values[nearer[shared]]
    return times, np.interp(times, result.times, result.values)


def _band(
    times: FloatArray, values: FloatArray, at: FloatArray, reach: float, variable: Variable
) -> tuple[FloatArray, FloatArray]:
    """Return the least and greatest reference within reach [s] of each time."""
    low, high = np.empty(at.size), np.empty(at.size)
    for place, time in enumerate(float(time) for time in at):
        rounding = SAME_TIME * max(1.0, abs(time))
        near = values[np.abs(times - time) <= reach + rounding]
        if reach > 0.0 and variable.is_continuous:
            near = np.append(near, np.interp([time - reach, time + reach], times, values))
        elif reach > 0.0:
            held = int(np.searchsorted(times, time - reach + rounding, side="right")) - 1
            near = np.append(near, values[max(held, 0)])
        low[place], high[place] = near.min(), near.max()
    return low, high
