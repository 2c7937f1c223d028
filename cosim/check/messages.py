"""Debug logging: categories that are declared, and silence when it is off (FMI 2.0.4, section 2.1.5)."""

from __future__ import annotations

from collections import Counter
from ctypes import c_char_p

from cosim.check.bench import Bench
from cosim.check.instance import ACCEPTED, OK, Instance
from cosim.check.verdict import Outcome, failed, noted, passed


def check_logging(bench: Bench) -> Outcome:
    """Run with all categories on, then with logging off."""
    declared = bench.description.log_categories
    with bench.started(logging=True) as instance:
        if (status := switch(instance, True, declared)) not in ACCEPTED:
            instance.judge("SetDebugLogging", status)
        bench.exercise.run(instance)
        heard = Counter(message.category for message in instance.messages)
    undeclared = sorted(set(heard) - set(declared))
    with bench.started() as instance:
        instance.judge("SetDebugLogging", switch(instance, False, ()))
        bench.exercise.run(instance)
        chatter = [message.text for message in instance.messages if message.status == OK]
    allowed = "only declared"
    if chatter:
        return failed(f"{len(chatter)} messages though logging is off, such as '{chatter[0]}'", allowed)
    if undeclared:
        what = f"messages of undeclared category {', '.join(map(repr, undeclared))}"
        return failed(what, allowed) if declared else noted(f"{what}; none is declared", allowed)
    counts = ", ".join(f"{count} of {category}" for category, count in heard.most_common())
    return passed(f"{counts or 'no messages'}; {len(declared)} declared", allowed)


def switch(instance: Instance, on: bool, categories: tuple[str, ...]) -> int:
    """Switch debug logging and return the status."""
    array = (c_char_p * max(1, len(categories)))(*(category.encode() for category in categories))
    return instance.call("SetDebugLogging", int(on), len(categories), array)
