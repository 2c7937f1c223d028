"""Whether an FMU loads, starts as it says, runs, and can be ended in every legal order (FMI 2.0.4, section 4.2.4)."""

from __future__ import annotations

import math
import time
from dataclasses import asdict, replace

from cosim.check.bench import Bench
from cosim.check.exercise import Exercise, Plan, Runner, not_finite
from cosim.check.instance import CallError
from cosim.check.verdict import Outcome, failed, noted, passed
from cosim.system.description import Variable

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
        instance.must("SetupExperiment", 0, 0.0, bench.plan.start, 0, 0.0)
        instance.must("EnterInitializationMode")
        for variable in known:
            value, declared = instance.get(variable), _declared(variable)
            if value != declared:
                return failed(f"{variable.name} is {value!r}; declared is {declared!r}", "as declared")
    return passed(f"{len(known)} as declared", "as declared")


def _starts_exactly(variable: Variable) -> bool:
    exact = variable.initial == "exact" or variable.causality in ("input", "parameter")
    return exact and variable.start is not None


def _declared(variable: Variable) -> float | int | bool | str:
    start = str(variable.start)
    match variable.type:
        case "Real":
            return float(start)
        case "Boolean":
            return start in ("true", "1")
        case "String":
            return start
        case _:
            return int(start)


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
        instance.must("SetupExperiment", 0, 0.0, bench.plan.start, 0, 0.0)
    with bench.instance() as instance:
        instance.must("SetupExperiment", 0, 0.0, bench.plan.start, 0, 0.0)
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
