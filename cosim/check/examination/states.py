"""Check that instances keep their state whole and to themselves.

A state is restored, serialised, and restored in another process (FMI 2.0.4, section 2.1.8); instances are the same and
leave each other alone; a reset makes one new.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from ctypes import byref, c_size_t, c_void_p

import numpy as np

from cosim.check.examination.bench import Bench
from cosim.check.examination.exercise import Record, Runner
from cosim.check.examination.instance import ACCEPTED, Instance
from cosim.check.verdict import Outcome, failed, not_checked, noted, passed

STATE, EXPECTED, OTHERS = "state.bin", "expected.npz", "expected.json"
_DAMAGED = 8


def saving_points(steps: int) -> tuple[int, ...]:
    """Return after how many steps states are saved."""
    return tuple(sorted({max(1, steps * tenths // 10) for tenths in (2, 5, 8)}))


def check_state(bench: Bench) -> Outcome:
    """Save on the way, go on with other inputs, come back, and repeat the rest."""
    if not bench.description.can_save_state:
        return unclaimed(bench, "canGetAndSetFMUstate", _try_to_save)
    points = saving_points(bench.plan.steps)
    whole = bench.undisturbed()
    with bench.started() as instance:
        states: dict[int, c_void_p] = {}
        for begin, end in zip((0, *points), (*points, bench.plan.steps), strict=True):
            if begin:
                states[begin] = instance.save()
            rest = bench.exercise.run(instance, begin, end)
            if difference := whole.part(begin, end).difference(rest):
                return failed(f"saving changes the run: {difference}", SAME)
        for point in reversed(points):
            instance.restore(states[point])
            bench.exercise.run(instance, point, min(point + 10, bench.plan.steps), variant=2)
            instance.restore(states[point])
            if difference := _repeated(bench, instance, point, whole):
                return failed(f"restored after step {point}: {difference}", SAME)
        for state in states.values():
            instance.discard(state)
    return passed(f"{SAME}, from {len(points)} states", SAME)


def _repeated(bench: Bench, instance: Instance, point: int, whole: Record) -> str:
    """Compare the outputs at the point and the rest of the run with those of the undisturbed run."""
    runner = Runner(bench.exercise, instance)
    instance.time = bench.plan.time(point)
    runner.read()
    for index in range(point, bench.plan.steps):
        runner.step(index)
    return whole.part(point - 1, bench.plan.steps).difference(runner.record())


def check_serialised(bench: Bench) -> Outcome:
    """Serialise a state, and go on from it on another instance; leave it for another process."""
    if not bench.description.can_serialize_state:
        return unclaimed(bench, "canSerializeFMUstate", _try_to_serialise)
    point = saving_points(bench.plan.steps)[1]
    whole = bench.undisturbed()
    with bench.started() as instance:
        bench.exercise.run(instance, end=point)
        state = instance.save()
        content = instance.serialise(state)
        instance.discard(state)
    if difference := _continued(bench, content, point, whole):
        return failed(difference, SAME)
    (bench.folder / STATE).write_bytes(content)
    np.savez(bench.folder / EXPECTED, times=whole.times, reals=whole.reals)
    others = [[_plain(value) for value in row] for row in whole.others]
    (bench.folder / OTHERS).write_text(json.dumps({"point": point, "others": others}), encoding="utf-8")
    return passed(f"{SAME}, from {len(content)} bytes", SAME)


def check_elsewhere(bench: Bench) -> Outcome:
    """Go on from the state that another process has left."""
    if not bench.description.can_serialize_state:
        return not_checked("canSerializeFMUstate is not claimed")
    left = json.loads((bench.folder / OTHERS).read_text(encoding="utf-8"))
    arrays = np.load(bench.folder / EXPECTED)
    names = [variable.name for variable in bench.exercise.outputs]
    others = [tuple(_exact(value) for value in row) for row in left["others"]]
    whole = Record(names, arrays["times"].tolist(), arrays["reals"], others)
    content = (bench.folder / STATE).read_bytes()
    difference = _continued(bench, content, left["point"], whole)
    return failed(difference, SAME) if difference else passed(SAME, SAME)


def _continued(bench: Bench, content: bytes, point: int, whole: Record) -> str:
    """Go on from a serialised state on a new instance and compare with the undisturbed run."""
    with bench.started("restored") as instance:
        status, state = instance.deserialise(content)
        instance.judge("DeSerializeFMUstate", status)
        instance.restore(state)
        difference = _repeated(bench, instance, point, whole)
        instance.discard(state)
    return difference


def check_damaged(bench: Bench) -> Outcome:
    """Flip bytes of a serialised state and cut its tail; an FMU should see that."""
    if not bench.description.can_serialize_state:
        return not_checked("canSerializeFMUstate is not claimed")
    content = (bench.folder / STATE).read_bytes()
    places = [len(content) * number // _DAMAGED for number in range(_DAMAGED)]
    damaged = [_flipped(content, place) for place in dict.fromkeys(places)] + [content[: len(content) // 2]]
    bench.forgive()
    accepted = sum(_accepts(bench, each) for each in damaged)
    if accepted:
        return noted(f"{accepted} of {len(damaged)} damaged states are accepted", "all refused")
    return passed(f"all {len(damaged)} damaged states are refused", "all refused")


def _flipped(content: bytes, place: int) -> bytes:
    return content[:place] + bytes([content[place] ^ 0x55]) + content[place + 1 :]


def _accepts(bench: Bench, content: bytes) -> bool:
    """Return whether an FMU takes a damaged state, and steps on from it."""
    with bench.started("damaged") as instance:
        status, state = instance.deserialise(content)
        if status not in ACCEPTED or instance.call("SetFMUstate", state) not in ACCEPTED:
            return False
        point = saving_points(bench.plan.steps)[1]
        return instance.call("DoStep", bench.plan.time(point), bench.plan.step, 0) in ACCEPTED


def unclaimed(bench: Bench, claim: str, attempt: Callable[[Instance], int]) -> Outcome:
    """Try on an initialised instance what an FMU does not claim to be able to; it should refuse."""
    bench.forgive()
    with bench.started() as instance:
        accepted = attempt(instance) in ACCEPTED
    if accepted:
        return noted(f"{claim} is not claimed, yet the call is accepted", "refused")
    return passed("not claimed, and refused", "refused")


def _try_to_save(instance: Instance) -> int:
    return instance.call("GetFMUstate", byref(c_void_p()))


def _try_to_serialise(instance: Instance) -> int:
    state = c_void_p()
    status = instance.call("GetFMUstate", byref(state))
    return instance.call("SerializedFMUstateSize", state, byref(c_size_t())) if status in ACCEPTED else status


def _plain(value: int | bytes | None) -> int | str | None:
    """Return what JSON can hold of an Integer, a Boolean or a String."""
    return value.decode("latin-1") if isinstance(value, bytes) else value


def _exact(value: int | str | None) -> int | bytes | None:
    """Return what `_plain` was given."""
    return value.encode("latin-1") if isinstance(value, str) else value


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
