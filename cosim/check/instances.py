"""Whether instances are the same and leave each other alone, and whether a reset makes one new."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack

from cosim.check.bench import Bench
from cosim.check.exercise import Record, Runner
from cosim.check.verdict import Outcome, failed, not_checked, noted, passed

SAME = "the same bits"


def check_repeats(bench: Bench) -> Outcome:
    """Run the exercise again on a second instance."""
    with bench.started("again") as instance:
        difference = bench.undisturbed().difference(bench.exercise.run(instance))
    return failed(difference, SAME) if difference else passed(SAME, SAME)


def check_together(bench: Bench) -> Outcome:
    """Run instances step by step beside each other, one freed on the way; each must run as if alone."""
    if bench.description.once_per_process:
        return not_checked("the FMU claims canBeInstantiatedOnlyOncePerProcess")
    with ExitStack() as stack:
        instances = [stack.enter_context(bench.started(f"number{number}")) for number in range(3)]
        runners = [Runner(bench.exercise, instance, variant) for variant, instance in enumerate(instances)]
        for index in range(bench.plan.steps):
            for runner in runners:
                runner.step(index)
            if index == bench.plan.steps // 2:
                runners.pop()
                instances.pop().free()
        records = [runner.record() for runner in runners]
    for variant, record in enumerate(records):
        if difference := record.difference(bench.undisturbed(variant)):
            return failed(f"beside others and alone: {difference}", SAME)
    return passed("each as if alone", SAME)


def check_threads(bench: Bench) -> Outcome:
    """Run instances at once in threads of their own; FMI does not say that this must work."""
    if bench.description.once_per_process:
        return not_checked("the FMU claims canBeInstantiatedOnlyOncePerProcess")
    alone = [bench.undisturbed(variant) for variant in range(2)]
    bench.forgive()
    with ExitStack() as stack, ThreadPoolExecutor(2) as pool:
        instances = [stack.enter_context(bench.started(f"thread{number}")) for number in range(2)]

        def run(variant: int) -> Record:
            return bench.exercise.run(instances[variant], variant=variant)

        records = list(pool.map(run, range(2)))
    for one, other in zip(records, alone, strict=True):
        if difference := one.difference(other):
            return noted(f"in a thread and alone: {difference}", SAME)
    return passed("each as if alone", SAME)


def check_reset(bench: Bench) -> Outcome:
    """Run with other inputs half way, reset, and run as if new."""
    with bench.started() as instance:
        bench.exercise.run(instance, end=max(1, bench.plan.steps // 2), variant=1)
        instance.must("Reset")
        bench.exercise.initialise(instance)
        difference = bench.undisturbed().difference(bench.exercise.run(instance))
    return failed(f"new and reset: {difference}", SAME) if difference else passed(SAME, SAME)
