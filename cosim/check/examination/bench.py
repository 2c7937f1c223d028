"""Hold what the checks of a running FMU share: its library, the exercise, and the record of an undisturbed run.

Its messages are checked here too: their categories are declared, and there are none when debug logging is off (FMI
2.0.4, section 2.1.5).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from ctypes import c_char_p
from functools import cache
from pathlib import Path

from cosim.check.examination.exercise import Exercise, Plan, Record
from cosim.check.examination.instance import ACCEPTED, OK, Instance
from cosim.check.examination.library import Library
from cosim.check.reference import Experiment
from cosim.check.verdict import Outcome, failed, noted, passed
from cosim.system.description import Description, Variable


class Bench:
    """One loaded FMU under test.

    Parameters
    ----------
    library : Library
        The FMU's functions.
    plan : Plan
        How far runs go.
    experiments : sequence of Experiment
        Of its reference.
    folder : Path
        For what a check leaves to a later one in another process.
    forgive : callable
        Called before what no standard asks an FMU to survive.
    """

    def __init__(
        self,
        library: Library,
        plan: Plan,
        experiments: Sequence[Experiment],
        folder: Path,
        forgive: Callable[[], None],
    ) -> None:
        self.library = library
        self.experiments = tuple(experiments)
        self.exercise = Exercise(library.description, plan)
        self.folder = folder
        self.forgive = forgive
        self.undisturbed = cache(self._undisturbed)

    @property
    def description(self) -> Description:
        """Return what the FMU says about itself."""
        return self.library.description

    def continuous(self, causality: str) -> tuple[Variable, ...]:
        """Return the continuous inputs or outputs."""
        found = self.description.with_causality(causality)
        return tuple(v for v in found if v.type == "Real" and v.variability == "continuous")

    @property
    def plan(self) -> Plan:
        """Return how far runs go."""
        return self.exercise.plan

    def adopt(self, plan: Plan) -> None:
        """Let later runs follow another plan."""
        self.exercise = Exercise(self.description, plan)
        self.undisturbed.cache_clear()

    def instance(self, name: str = "checked", *, guid: str | None = None, logging: bool = False) -> Instance:
        """Return a new instance; it frees itself at the end of a with statement."""
        return Instance(self.library, name, guid=guid, logging=logging)

    @contextmanager
    def started(self, name: str = "checked", *, logging: bool = False) -> Generator[Instance]:
        """Yield an initialised instance; CallError if it cannot be had."""
        with self.instance(name, logging=logging) as instance:
            self.exercise.initialise(instance)
            yield instance

    def _undisturbed(self, variant: int = 0) -> Record:
        """Run the whole exercise on an instance of its own."""
        with self.started() as instance:
            return self.exercise.run(instance, variant=variant)


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
