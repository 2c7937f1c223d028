"""Check the calling sequence: an FMU loads, starts as it says, runs, and ends in every legal order.

The legal orders are those of FMI 2.0.4, section 4.2.4. Importers' time is tried too: another start, points added up,
steps of changing size. Last comes what an FMU had better refuse: values out of bounds, unknown references, wrong order;
the standard asks no FMU to survive that, so none is failed for it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from ctypes import byref, c_double, c_uint
from dataclasses import asdict, replace

import numpy as np
from numpy.typing import NDArray

from cosim.check.examination.bench import Bench
from cosim.check.examination.exercise import Exercise, Plan, Record, Runner, not_finite
from cosim.check.examination.instance import CallError
from cosim.check.verdict import Outcome, failed, not_checked, noted, passed, sample, some
from cosim.fmi2.functions import ACCEPTED
from cosim.system.description import Variable
from cosim.system.signals import Value

OTHER_GUID = "{00000000-0000-0000-0000-000000000000}"
_SECONDS = 2.0
_FEW = 3


def check_library(bench: Bench) -> Outcome:
    """Ask the loaded library, which has every function, for version and platform of types."""
    version = (bench.library.version() or b"").decode()
    platform = (bench.library.types_platform() or b"").decode()
    found, allowed = f"version {version}, types {platform}", "2.0, default"
    return passed(found, allowed) if (version, platform) == ("2.0", "default") else failed(found, allowed)


def check_instantiate(bench: Bench) -> Outcome:
    """Instantiate and free; try with a GUID that is not the FMU's."""
    with bench.instance() as instance:
        if instance.component is None:
            return failed(f"no instance: {instance.reason or 'the FMU does not say why'}", "an instance")
    with bench.instance("foreign", guid=OTHER_GUID) as instance:
        if instance.component is not None:
            return noted("made, with a wrong GUID as well", "wrong GUID refused")
    return passed("made; a wrong GUID is refused", "an instance")


def check_start_values(bench: Bench) -> Outcome:
    """Read in initialization mode what the file says variables start with."""
    known = [variable for variable in bench.description.variables if _starts_exactly(variable)]
    with bench.instance() as instance:
        if instance.component is None:
            return failed(f"no instance: {instance.reason}", "as declared")
        instance.set_up(bench.plan.start)
        instance.must("EnterInitializationMode")
        for variable in known:
            value, declared = instance.get(variable), variable.start_value
            if value != declared:
                return failed(f"{variable.name} is {value!r}; declared is {declared!r}", "as declared")
    return passed(f"{len(known)} as declared", "as declared")


def _starts_exactly(variable: Variable) -> bool:
    exact = variable.initial == "exact" or variable.causality in ("input", "parameter")
    return exact and variable.start is not None


def check_readable(bench: Bench) -> Outcome:
    """Get every variable by itself after initialisation."""
    with bench.started() as instance:
        for variable in bench.description.variables:
            try:
                value = instance.get(variable)
            except CallError as error:
                return failed(f"{variable.name}: {error}", "all of them")
            except ValueError as error:
                return failed(str(error), "all of them")
            if isinstance(value, float) and variable.causality == "output" and not math.isfinite(value):
                return failed(f"{variable.name} is {value} after initialisation", "finite outputs")
    return passed(f"all {len(bench.description.variables)}", "all of them")


def check_run(bench: Bench) -> Outcome:
    """Step through the exercise, moving the inputs if the FMU bears it.

    It is shortened if it takes long, or to where the FMU asks to end.
    """
    held = replace(bench.plan, moves=False)
    for plan in (bench.plan, held):
        try:
            plan = _as_far_as_it_goes(bench, plan)
        except CallError:
            if plan.moves and Exercise(bench.description, plan).moved:
                continue
            raise
        bench.adopt(plan)
        break
    if problem := not_finite(bench.undisturbed()):
        return failed(problem, "finite outputs")
    moved = len(bench.exercise.moved)
    how = f"{moved} inputs moved" if moved > 1 else "1 input moved" if moved else "no input moved"
    return passed(f"{bench.plan}, {how}", "finite outputs", data=asdict(bench.plan))


def _as_far_as_it_goes(bench: Bench, plan: Plan) -> Plan:
    exercise = Exercise(bench.description, plan)
    began = time.monotonic()
    with bench.instance() as instance:
        exercise.initialise(instance)
        runner = Runner(exercise, instance)
        for index in range(plan.steps):
            try:
                runner.step(index)
            except CallError as error:
                if index >= _FEW and instance.wants_to_end(error):
                    return replace(plan, steps=index)
                raise
            if time.monotonic() - began > _SECONDS and index + 1 >= _FEW:
                return replace(plan, steps=index + 1)
    return plan


def check_ends(bench: Bench) -> Outcome:
    """Free, terminate and reset in every legal order."""
    few = min(_FEW, bench.plan.steps)
    with bench.instance() as instance:
        instance.set_up(bench.plan.start)
    with bench.instance() as instance:
        instance.set_up(bench.plan.start)
        instance.must("EnterInitializationMode")
    with bench.started() as instance:
        bench.exercise.run(instance, end=few)
    with bench.started() as instance:
        bench.exercise.run(instance, end=few)
        instance.must("Terminate")
        Runner(bench.exercise, instance).read()
        instance.must("Reset")
        bench.exercise.initialise(instance)
        bench.exercise.run(instance, end=few)
        instance.must("Terminate")
    return passed("every order", "fmi2OK always")


_MOST_ATTEMPTS = 40


def check_bounds_kept(bench: Bench) -> Outcome:
    """Set inputs and parameters beyond their declared bounds, and Real ones to NaN."""
    attempts = [
        (variable, value)
        for variable in bench.description.variables
        if variable.causality in ("input", "parameter") and variable.settable
        for value in _misfits(variable)
    ]
    if not attempts:
        return not_checked("no input or parameter has bounds")
    bench.forgive()
    tried = sample(attempts, _MOST_ATTEMPTS)
    accepted = [f"{variable.name} = {value}" for variable, value in tried if _accepts(bench, variable, value)]
    if accepted:
        return noted(f"{len(accepted)} of {len(tried)} accepted: {some(accepted)}", "refused")
    return passed(f"all {len(tried)} refused", "refused")


def _misfits(variable: Variable) -> list[Value]:
    """Return values that a variable must not have."""
    values: list[float] = []
    if variable.maximum is not None:
        values.append(variable.maximum + max(1.0, 0.1 * abs(variable.maximum)))
    if variable.minimum is not None:
        values.append(variable.minimum - max(1.0, 0.1 * abs(variable.minimum)))
    if variable.type == "Real":
        return [*values, math.nan]
    return [int(value) for value in values if -(2**31) <= value < 2**31]


def _accepts(bench: Bench, variable: Variable, value: Value) -> bool:
    """Return whether an FMU can be set to a value, and initialised and stepped with it."""
    with bench.instance() as instance:
        if instance.set(variable, value) not in ACCEPTED:
            return False
        try:
            bench.exercise.initialise(instance)
            instance.step(bench.plan.start, bench.plan.step)
        except CallError:
            return False
    return True


def check_misuse(bench: Bench) -> Outcome:
    """Step before initialisation, get an unknown variable, initialise twice, step back in time."""
    bench.forgive()
    attempts: dict[str, Callable[[Bench], int]] = {
        "a step before initialisation": _early_step,
        "an unknown value reference": _unknown_reference,
        "initialising twice": _second_initialisation,
        "a step from the past": _step_from_the_past,
    }
    accepted = [name for name, attempt in attempts.items() if attempt(bench) in ACCEPTED]
    if accepted:
        return noted(f"accepted: {', '.join(accepted)}", "refused")
    return passed("all four refused", "refused")


def _early_step(bench: Bench) -> int:
    with bench.instance() as instance:
        return instance.call("DoStep", bench.plan.start, bench.plan.step, 0)


def _unknown_reference(bench: Bench) -> int:
    unknown = 1 + max((variable.reference for variable in bench.description.variables), default=0)
    with bench.started() as instance:
        return instance.call("GetReal", byref(c_uint(unknown + 1000)), 1, byref(c_double()))


def _second_initialisation(bench: Bench) -> int:
    with bench.started() as instance:
        return instance.call("EnterInitializationMode")


def _step_from_the_past(bench: Bench) -> int:
    with bench.started() as instance:
        bench.exercise.run(instance, end=2)
        return instance.call("DoStep", bench.plan.start, bench.plan.step, 0)


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
