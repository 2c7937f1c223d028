"""What no importer should do, and what an FMU had better refuse: values out of bounds, unknown references, wrong order.

None of this is for an FMU to survive by the standard, so nothing here fails one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from ctypes import byref, c_double, c_uint

from cosim.check.bench import Bench
from cosim.check.instance import ACCEPTED, CallError
from cosim.check.verdict import Outcome, not_checked, noted, passed
from cosim.check.wording import sample, some
from cosim.system.description import Variable
from cosim.system.signals import Value

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
